"""Inverse dynamics: an excavator by hand, shared forces, what is refused, and what smoothing does."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, compile_system, loads, run
from mbproj.scene import read_scene_text
from mbproj.studies.inverse.given_motion import GivenMotion
from mbproj.studies.inverse.spline import smoothed
from tests.studies.inverse import excavator

CYLINDERS = tuple(f"{name}_cylinder" for name in excavator.NAMES)
PINS = tuple(f"{name}_pin.angle" for name in excavator.NAMES)


@pytest.fixture(scope="module")
def dug():
    """A run of the driven excavator."""
    return run(excavator.scene(driven=True), duration=1.0, step=0.01, output_step=0.02)


def given(t, noise=0.0):
    values = excavator.coordinates(t)
    return GivenMotion(PINS, ("rad",) * 3, t, values + noise * np.random.default_rng(4).normal(size=values.shape))


def test_the_cylinders_of_an_excavator_push_as_the_moments_by_hand_say(dug):
    found = loads(dug, actuators=CYLINDERS)
    expected = excavator.cylinder_forces(dug.time)
    np.testing.assert_allclose(found.force, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    assert found.units == ("N",) * 3
    assert found.freedom == found.rank == 3
    assert found.balance < 1e-12


def test_along_the_motions_their_own_torques_are_found_again(dug):
    found = loads(dug)
    recorded = dug["motions/force"]
    np.testing.assert_allclose(found.force, recorded, rtol=0.0, atol=1e-10 * np.abs(recorded).max())


def test_a_motion_given_by_samples_takes_the_same_forces_but_for_the_spline():
    """The error of the second derivative of a spline of degree 5 falls with h⁴."""
    errors = []
    for count in (31, 61):
        t = np.linspace(0.0, 4.0, count)
        found = loads(excavator.scene(driven=False), given(t), actuators=CYLINDERS)
        expected = excavator.cylinder_forces(t)
        inside = slice(count // 5, -count // 5)
        errors.append(np.abs(found.force - expected)[inside].max() / np.abs(expected).max())
        assert found.balance < 1e-12
        assert all(each.noise == 0.0 and each.largest < 1e-12 for each in found.smoothing)
    assert errors[0] < 3e-4
    assert errors[0] / errors[1] > 10.0


def test_without_names_the_given_coordinates_are_the_actuators():
    t = np.linspace(0.0, 4.0, 41)
    found = loads(excavator.scene(driven=False), given(t))
    assert found.names == PINS
    assert found.units == ("N m",) * 3


def test_the_tooth_of_the_bucket_and_one_angle_tell_the_whole_motion():
    """Markers: x and z of the tooth and the angle of the bucket's pin take the place of three angles."""
    scene, t = excavator.scene(driven=True), np.linspace(0.0, 1.0, 51)
    results = run(scene, duration=1.0, step=0.02)
    tooth = results.marker("tooth").position
    values = np.column_stack([tooth[:, 0], tooth[:, 2], results.coordinate("bucket_pin.angle").value])
    motion = GivenMotion(("tooth.x", "tooth.z", "bucket_pin.angle"), ("m", "m", "rad"), results.time, values)
    found = loads(excavator.scene(driven=False), motion, actuators=CYLINDERS)
    expected = excavator.cylinder_forces(t)
    inside = slice(10, -10)
    np.testing.assert_allclose(found.force[inside], expected[inside], rtol=0.0, atol=1e-5 * np.abs(expected).max())


@pytest.mark.full
def test_noise_is_smoothed_and_what_that_changes_is_said():
    """Samples with noise of 1e-4 rad: its size is found, and the forces are near those of the true motion,
    while interpolation would make accelerations of noise."""
    t = np.linspace(0.0, 4.0, 121)
    found = loads(excavator.scene(driven=False), given(t, 1e-4), actuators=CYLINDERS)
    expected = excavator.cylinder_forces(t)
    assert [each.noise for each in found.smoothing] == pytest.approx([1e-4] * 3, rel=0.3)
    assert all(1e-4 < each.largest < 6e-4 for each in found.smoothing)
    off = np.abs(found.force - expected)[12:-12] / np.abs(expected).max(axis=0)
    assert off.max() < 0.1
    raw = loads(excavator.scene(driven=False), given(t, 1e-4), actuators=CYLINDERS, smooth={"rad": 0.0})
    assert np.abs(raw.force - expected)[12:-12].max() > 3.0 * np.abs(found.force - expected)[12:-12].max()


def test_what_is_given_twice_is_averaged():
    """Angles and a marker that contradict each other by noise: the closed motion is between them."""
    t = np.linspace(0.0, 1.0, 26)
    results = run(excavator.scene(driven=True), duration=1.0, step=0.02, output_step=0.04)
    tooth = results.marker("tooth").position[:, [0, 2]]
    values = np.column_stack([excavator.coordinates(t), tooth + np.array([3e-4, -3e-4])])
    names, units = (*PINS, "tooth.x", "tooth.z"), ("rad",) * 3 + ("m",) * 2
    found = loads(excavator.scene(driven=False), GivenMotion(names, units, t, values), actuators=CYLINDERS)
    changes = {each.name: each.largest for each in found.smoothing}
    assert 0.0 < changes["tooth.x"] < 3e-4
    assert 0.0 < changes["boom_pin.angle"] < 3e-4
    assert found.balance < 1e-12


def test_of_more_actuators_than_freedoms_the_least_weighted_squares_are_taken(dug):
    """With cylinders and torques at the same joints: p = W⁻¹Bᵀ(B W⁻¹Bᵀ)⁻¹ τ, of which B is known in closed form."""
    torques, cylinders = loads(dug, actuators=PINS).force, loads(dug, actuators=CYLINDERS).force
    weights = {"boom_cylinder": 4.0}
    both = loads(dug, actuators=(*PINS, *CYLINDERS), weights=weights)
    assert both.is_shared
    lever = torques / cylinders
    w = np.array([4.0, 1.0, 1.0])
    share = torques / (1.0 + lever**2 / w)
    np.testing.assert_allclose(both.force[:, :3], share, rtol=1e-9, atol=1e-9 * np.abs(torques).max())
    np.testing.assert_allclose(both.force[:, 3:], lever * share / w, rtol=1e-9, atol=1e-9 * np.abs(cylinders).max())
    assert both.balance < 1e-12


def test_a_freedom_without_an_actuator_is_named(dug):
    with pytest.raises(InputError) as raised:
        loads(dug, actuators=CYLINDERS[:2])
    problem = raised.value.problems[0]
    assert "reach 2 of 3 degrees of freedom" in problem.message
    assert "bucket_pin.angle" in str(problem.hint)


def test_a_motion_that_leaves_a_freedom_open_is_refused():
    t = np.linspace(0.0, 4.0, 41)
    motion = GivenMotion(PINS[:2], ("rad",) * 2, t, excavator.coordinates(t)[:, :2])
    with pytest.raises(InputError, match="determines 2 of 3 degrees of freedom"):
        loads(excavator.scene(driven=False), motion, actuators=CYLINDERS)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"actuators": ("boom_cylindre",)}, "no actuator 'boom_cylindre'"),
        ({"actuators": ("boom_motion", "boom_pin.angle")}, "two actuators act along 'boom_pin.angle'"),
        ({"weights": {"arm_motian": 2.0}}, "'arm_motian' is no actuator here"),
    ],
)
def test_names_that_are_wrong_are_said(dug, asked, said):
    with pytest.raises(InputError, match=said):
        loads(dug, **asked)


def test_a_free_motion_takes_no_force_of_an_actuator():
    """A pendulum that swings by itself, with a torque at its joint: zero."""
    results = run("mechanisms/physical_pendulum.yaml", duration=0.5)
    (name,) = results.names("coordinates")
    found = loads(results, actuators=[name])
    assert np.abs(found.force).max() < 1e-9


def test_actuators_that_are_forces_of_the_scene_replace_what_they_do():
    """A spring along a slide, whose recorded force is found again as that of an actuator."""
    text = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5, step: 1 ms, output_step: 10 ms}
bodies: {box: {mass: 2, inertia: [1, 1, 1], position: [0.3, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, box], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.1}}
forces:
  spring: {type: linear_spring_damper, joint: rail, stiffness: 80, damping: 3}
  push: {type: force, body: box, force: [4, 0, 0]}
"""
    results = run(text)
    spring = loads(results, actuators=["spring"]).force[:, 0]
    np.testing.assert_allclose(spring, results.force("spring").force, rtol=0.0, atol=1e-10)
    push = loads(results, actuators=["push.x"]).force[:, 0]
    np.testing.assert_allclose(push, 4.0, rtol=1e-10)


def test_at_a_dead_centre_there_is_no_force_and_it_is_said():
    """A slider-crank moved by its crank, with the force at the piston: through the dead centre that pushes nothing."""
    text = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {duration: 1, step: 0.01}
bodies:
  crank: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.1, 0, 0]}
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
  piston: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.8, 0, 0]}
joints:
  main: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1]}
  pin: {type: revolute, bodies: [crank, rod], location: [0.2, 0, 0], axis: [0, 0, 1]}
  wrist: {type: point_on_line, bodies: [piston, rod], location: [0.8, 0, 0], axis: [0, 0, 1]}
  bore: {type: prismatic, bodies: [ground, piston], location: [0.8, 0, 0], axis: [1, 0, 0]}
motions: {drive: {joint: main, angle: {constant_speed: 1 Hz}}}
"""
    results = run(text.replace("1 Hz", "6.283185307179586 rad/s"))
    found = loads(results, actuators=["bore.displacement"])
    assert found.dead.tolist() == pytest.approx([0.0, 0.5, 1.0])
    assert np.isnan(found.force[0, 0])
    assert np.isfinite(found.force[1:50, 0]).all()


def test_dry_friction_is_refused_as_it_goes_by_reactions():
    text = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.1, step: 1 ms}
bodies: {box: {mass: 2, inertia: [1, 1, 1], position: [0.3, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, box], location: [0, 0, 0], axis: [1, 0, 0]}}
forces: {guide: {type: friction, joint: rail, coulomb: {coefficient: 0.1}}}
motions: {drive: {joint: rail, displacement: 0.1*t}}
"""
    with pytest.raises(InputError, match="dry friction 'guide"):
        loads(text)


def test_dry_friction_of_a_constant_force_acts_against_the_rate():
    """A box on a slope that goes to and fro, and rests in between: m (a + g sin β) + F sign v."""
    rise, back = ("max(0, min(1, (t - 0.2)/0.3))", "max(0, min(1, (t - 0.7)/0.3))")
    law = " - ".join(f"0.2*({x})**3*(10 - 15*{x} + 6*({x})**2)" for x in (rise, back))
    text = f"""
mbproj: 1
gravity: [-4, 0, -9]
simulation: {{duration: 1.2, output_step: 10 ms, kinematic: true}}
bodies: {{box: {{mass: 2, inertia: [1, 1, 1], position: [0.3, 0, 0]}}}}
joints: {{rail: {{type: prismatic, bodies: [ground, box], location: [0, 0, 0], axis: [1, 0, 0]}}}}
forces: {{guide: {{type: friction, joint: rail, coulomb: {{force: 3 N}}}}}}
motions: {{drive: {{joint: rail, displacement: "{law}"}}}}
"""
    found, done = loads(text), run(text)
    t = found.time
    inside = (np.abs(t - 0.35) < 0.14) | (np.abs(t - 0.85) < 0.14)
    rests = (t < 0.2) | (np.abs(t - 0.6) < 0.09) | (t > 1.01)
    x = np.where(t < 0.6, t - 0.2, t - 0.7) / 0.3
    sign = np.where(t < 0.6, 1.0, -1.0)
    bend = 0.2 * (60.0 * x - 180.0 * x**2 + 120.0 * x**3) / 0.09
    np.testing.assert_allclose(found["drive"][inside], (2.0 * (sign * bend + 4.0) + 3.0 * sign)[inside], atol=1e-10)
    np.testing.assert_allclose(found["drive"][rests], 8.0, atol=1e-10)
    np.testing.assert_allclose(found["drive"][inside], done["motions/force"][inside, 0], atol=1e-10)
    assert found.balance < 1e-12


def test_a_spline_tells_noise_from_a_smooth_motion():
    t = np.linspace(0.0, 2.0, 201)
    smooth = np.sin(3.0 * t)
    assert smoothed(t, smooth, None).noise == 0.0
    noisy = smooth + 1e-3 * np.random.default_rng(1).normal(size=len(t))
    found = smoothed(t, noisy, None)
    assert found.noise == pytest.approx(1e-3, rel=0.15)
    assert np.sqrt(np.mean(found.change**2)) == pytest.approx(found.noise, rel=0.01)


def test_a_motion_names_what_the_scene_has():
    system = compile_system(read_scene_text(excavator.scene(driven=False), "digger"))
    assert system.names.coordinates == PINS
