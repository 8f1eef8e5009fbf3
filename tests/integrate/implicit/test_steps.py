"""Implicit steps in the full formulation, in halves, numbers of steps, and stiff mechanisms by their own equations."""

from __future__ import annotations

from functools import cache
from math import asin, cos, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbproj import Mechanism
from mbproj.base.errors import SimulationError
from mbproj.base.registry import implicit_integrators, integrators
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.motion.formulations.choice import choose
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.studies.record import notes_on
from scripts.beside.lagrange import CRANK, HALF, FourBar, Governor
from scripts.beside.stiff_scenes import CASES, belt, chain, four_bar, governor, ringing
from tests.integrate.event_scenes import bounce, contact_times, height_at, rotor
from tests.integrate.implicit.stiff_run import run as run_stiff
from tests.kernel.scenes import needs_kernel, run
from tests.support import ROOT, Recorder, assembled

# Implicit steps in the full formulation: their orders in space, closed joints, stiff forces of any size, events, and
# redundant rows.

IMPLICIT = ("esdirk4", "radau5")
#: A disk that spins and sways on a universal joint, with a spring, a damper and a force that does work.
SPINNING = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  arm: {mass: 1, inertia: [0.05, 0.1, 0.08], position: [0.3, 0, 0], angular_velocity: [0, 1, 2]}
  disk: {mass: 2, inertia: [0.2, 0.15, 0.1], position: [0.7, 0.1, 0], angular_velocity: [15, 0, 3]}
joints:
  pin: {type: universal, bodies: [ground, arm], location: [0, 0, 0], axes: [[0, 0, 1], [0, 1, 0]]}
  ball: {type: spherical, bodies: [arm, disk], location: [0.6, 0, 0]}
forces:
  spring: {type: spring_damper, points: {ground: [0, 0, 1], disk: [0.8, 0.2, 0]}, stiffness: 50, damping: 2}
  push: {type: force, body: disk, location: [0.7, 0.3, 0], force: [3*sin(5*t), 1, 2], axes: body}
"""


def run_full(scene, projection="gpopm", **keys):
    """(recorder, report)."""
    recorder = Recorder()
    if keys.get("integrator") in IMPLICIT:
        keys = {"formulation": "full"} | keys
    report = simulate(*assembled(scene), Settings(projection=ProjectionSettings(projection), **keys), recorder)
    return recorder, report


def of(recorder, name):
    return np.concatenate([getattr(block.samples, name) for block in recorder.blocks])


def off(one, other, name):
    return float(np.abs(of(one, name) - of(other, name)).max())


@cache
def spinning():
    """The reference, at 1e-12."""
    scene = read_scene_text(SPINNING)
    return run_full(scene, duration=0.1, tolerance=1e-12, integrator="dop853", output_step=0.02, formulation="full")[0]


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_orders_in_space(integrator):
    """Of coordinates, velocities, work and dissipation, with gyroscopic moments and rotations about changing axes."""
    steps = (0.02, 0.01)
    runs = [
        run_full(read_scene_text(SPINNING), duration=0.1, step=h, output_step=0.02, integrator=integrator)
        for h in steps
    ]
    for name in ("q", "v", "work"):
        coarse, fine = (off(recorder, spinning(), name) for recorder, _ in runs)
        assert np.log2(coarse / fine) == pytest.approx(integrators()[integrator].order, abs=0.15)
    for _, report in runs:
        assert report.position_violation.value <= 1e-13
        assert report.velocity_violation.value <= 1e-13
        assert report.formulation == "full"


@pytest.mark.parametrize("method", ["none", "baumgarte", "gopm", "mass-orthogonal", "mmopm", "gpopm", "gpopm-pinv"])
def test_every_projection(method):
    scene = read_scene_text(SPINNING)
    own = {"baumgarte": {"gains": (20.0, 20.0)}, "mass-orthogonal": {"alpha": 1e6}, "mmopm": {"alpha": 1e6}}
    recorder = Recorder()
    projection = ProjectionSettings(method, **own.get(method, {}))
    simulate(
        *assembled(scene), Settings(projection=projection, duration=0.1, step=0.02, integrator="esdirk4"), recorder
    )
    assert off(recorder, spinning(), "q") < 2e-6


@needs_kernel
@pytest.mark.parametrize("integrator", IMPLICIT)
@pytest.mark.parametrize("softness", ["0.1", "1e-5"])
def test_a_bushing_of_any_stiffness_takes_large_steps(integrator, softness):
    """The coupler of a four-bar in two halves, held by 1e6 and by 1e10 N/m, against DOP853's 1,000 and 90,000 steps a
    second; joints stay closed."""
    scene = read_scene(ROOT / "mechanisms" / "split_coupler.yaml", {"softness": softness})
    reference, _ = run_full(scene, duration=0.1, tolerance=1e-10, integrator="dop853", output_step=0.05)
    found, report = run_full(scene, duration=0.1, step=0.01, integrator=integrator, output_step=0.05)
    assert off(found, reference, "q") < {"esdirk4": 1e-4, "radau5": 1e-5 if softness == "0.1" else 1e-7}[integrator]
    assert report.position_violation.value <= 1e-13
    assert report.velocity_violation.value <= 1e-13


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_mass_bounces_on_a_spring_as_in_closed_form(integrator):
    """Steps end at the events in the state."""
    recorder, report = run_full(
        read_scene_text(bounce()), duration=0.5, tolerance=1e-8, integrator=integrator, output_step=0.1
    )
    height = recorder["joints/coordinate"][:, 0]
    np.testing.assert_allclose(height, [height_at(t) for t in recorder["time"]], atol=1e-7)
    assert report.events == len([t for t in contact_times(9) if t < 0.5])


@pytest.mark.parametrize(
    ("name", "integrator", "error"), [("bennett", "radau5", 1e-6), ("massless_coupler", "esdirk4", 5e-5)]
)
def test_redundant_rows_and_a_massless_body(name, integrator, error):
    """A Bennett linkage, with three rows that follow from the others; a coupler that its joints alone hold."""
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml")
    reference, _ = run_full(scene, duration=0.1, tolerance=1e-11, integrator="dop853", output_step=0.05)
    found, report = run_full(scene, duration=0.1, step=0.025, integrator=integrator, output_step=0.05)
    assert off(found, reference, "q") < error
    assert report.position_violation.value <= 1e-13


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_samples_within_a_step(integrator):
    """By the continuous extension: closed, and at a tolerance of 1e-6 as near to the reference as the steps are; so are
    accelerations and multipliers, with a power of h less."""
    found, report = run_full(
        read_scene_text(SPINNING), duration=0.1, tolerance=1e-6, integrator=integrator, output_step=0.02
    )
    assert report.counters["steps"] < 20
    assert off(found, spinning(), "q") < 1e-6
    assert off(found, spinning(), "acceleration") < 1e-3


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_forces_within_a_long_step_are_those_of_their_time(integrator):
    """What bears a load that swings while nothing moves: steps see nothing of it, samples within them do."""
    scene = read_scene_text(
        "mbproj: 1\ngravity: [0, 0, 0]\nbodies: {block: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\n"
        "joints: {pin: {type: revolute, bodies: [ground, block], location: [0, 0, 0], axis: [1, 0, 0]}}\n"
        "forces: {load: {type: force, body: block, location: [0, 0, 0], force: [8*sin(3*t), 0, 0]}}\n"
    )
    found, report = run_full(scene, duration=2, tolerance=1e-6, integrator=integrator, output_step=0.02)
    assert report.counters["steps"] < 20
    borne = np.abs(of(found, "multipliers")).max(axis=1)
    np.testing.assert_allclose(borne, np.abs(8.0 * np.sin(3.0 * of(found, "t"))), atol=1e-12)


def test_what_does_not_converge_is_named():
    """With steps in which the disk turns too far: a stiff force, or else a body."""
    for stiffness, where in ((50, "force 'spring'"), (0, "body 'disk'")):
        text = SPINNING.replace("stiffness: 50, damping: 2", f"stiffness: {stiffness}, damping: 0")
        _, report = run_full(read_scene_text(text), duration=0.5, step=0.5, integrator="radau5")
        assert where in report.halved


# Fixed implicit steps that Newton's method does not solve are made in halves.

#: A belt of 0.1 m/s carries a mass away; it sticks within 1e-5 m/s.
BELT = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {mass: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}}
forces:
  friction:
    type: linear_spring_damper
    joint: rail
    force: "-100*displacement - 5*tanh((displacement_dot - 0.1)/5e-6)"
"""
both = pytest.mark.parametrize("integrator", implicit_integrators())


def stiff_governor():
    return read_scene(ROOT / "mechanisms/governor.yaml", {"stiffness": "1e8", "damping": "1e5"})


@both
@pytest.mark.parametrize("formulation", ["full", "reduced", "planar"])
def test_a_mass_that_comes_to_stick(formulation, integrator):
    """The samples are where they were; the belt takes the mass along, and slow steps find where it sticks."""
    keys = {"duration": 0.1, "output_step": 0.02, "integrator": integrator, "formulation": formulation}
    found, report = run(read_scene_text(BELT), step=0.005, **keys)
    np.testing.assert_allclose(found["time"], 0.02 * np.arange(6), rtol=0.0, atol=1e-15)
    halvings = report.counters["rejected_steps"]
    assert 3 <= halvings <= 25
    assert report.counters["steps"] <= 20 + halvings
    assert f"{halvings} times, for want of " in report.halved
    assert any("fixed steps were halved" in note.text and "Newton's method" in note.text for note in notes_on(report))
    fine, _ = run(read_scene_text(BELT), tolerance=1e-8, **keys | {"formulation": "reduced", "integrator": "radau5"})
    assert np.abs(found["bodies/position"] - fine["bodies/position"]).max() < 2e-4


@both
@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_stiff_springs_at_a_coarse_step(formulation, integrator):
    """The governor turns by more than a radian in a step, and its joints stay closed."""
    _, report = run(
        stiff_governor(), duration=0.1, step=0.1, output_step=0.1, integrator=integrator, formulation=formulation
    )
    assert report.counters["steps"] - 1 == report.counters["rejected_steps"] > 0
    assert report.halved
    assert report.position_violation.value < 1e-12


@needs_kernel
def test_the_force_that_is_the_cause_is_named():
    _, report = run(read_scene_text(BELT), duration=0.1, step=0.01, output_step=0.1, integrator="esdirk4")
    assert "for want of force 'friction'" in report.halved


@both
@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_what_halving_does_not_mend(formulation, integrator):
    """A torque that grows with the speed without bound."""
    with pytest.raises(SimulationError, match=r"at (body 'rotor'|force 'push'): Newton's method did not") as caught:
        keys = {"integrator": integrator, "formulation": formulation}
        run(read_scene_text(rotor("1 + 1e6*sinh(50*angle_dot)")), duration=2.0, step=0.5, output_step=0.5, **keys)
    assert "nor did it those of its parts, down to 0.0" in caught.value.cause
    assert "smooth it; or try --integrator dop853" in caught.value.hint


@needs_kernel
@both
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_a_run_goes_on_between_two_parts_of_a_step(formulation, integrator):
    """With the bits of one run, and its counts."""
    system, state = assembled(read_scene_text(BELT))
    settings = Settings(duration=0.05, step=0.01, output_step=0.01, integrator=integrator, formulation=formulation)
    compiled = choose(system, state, settings).compiled
    whole = compiled.run(state, settings)
    whole.advance(1000, 60.0)
    parts = set()
    for attempts in range(3, 21):
        begun, rest = compiled.run(state, settings), compiled.run(state, settings)
        begun.keeps_marks = True
        begun.advance(1000, 60.0, attempts)
        mark = begun.mark()
        parts.add(mark["part"])
        rest.resume(mark)
        rest.advance(1000, 60.0)
        np.testing.assert_array_equal(rest.standing["y"], whole.standing["y"])
        np.testing.assert_array_equal(rest.counters[:3], whole.counters[:3])
        assert rest.halved == whole.halved
    assert len(parts) > 3


# How many steps of error control a stiff vibration takes that nothing damps: the more, the finer the tolerance.


def counts(k, tolerances, **keys):
    """Steps, and steps that were rejected, at each tolerance."""
    scene, keys = ringing(k), {"duration": 0.2, "output_step": 0.2} | keys
    found = [run(scene, tolerance=each, **keys)[1].counters for each in tolerances]
    return [[each[name] for each in found] for name in ("steps", "rejected_steps")]


@needs_kernel
@both
@pytest.mark.parametrize("k", [1e6, 1e8, 1e10])
def test_finer_tolerances_take_more_steps(k, integrator):
    """In half decades, past that at which a step begins to follow the vibration."""
    steps, rejected = counts(k, 10.0 ** np.arange(-3.0, -5.5, -0.5), integrator=integrator)
    assert all(np.diff(steps) > -3)
    assert all(np.array(rejected) <= np.array(steps) / 2 + 2)


@both
@pytest.mark.parametrize("formulation", ["full", pytest.param("planar", marks=needs_kernel)])
def test_a_vibration_that_is_damped_stays_so(formulation, integrator):
    """A step that is rejected on the way does not lead back to steps that follow it: of 3e-5 s, more than 1,000."""
    steps, _ = counts(1e8, [10.0**-3.5], integrator=integrator, formulation=formulation)
    assert steps[0] <= 16


# Stiff mechanisms at dials at which explicit steps are held up: few steps, small errors, closed joints.


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_mass_sticks_on_a_belt(integrator):
    """It slips, x'' = 5 - 100 x, until it is as fast as the belt, 0.1 m/s, and then sticks but for a part of the width
    of the law, 5e-5 m/s. DOP853 takes 1,300 steps."""
    found = run_stiff(belt(1e5), 0.2, integrator, 1e-5)
    sticks = asin(0.2) / 10.0
    assert found.q[-1, 0] == pytest.approx(0.05 * (1.0 - sqrt(1.0 - 0.2**2)) + 0.1 * (0.2 - sticks), abs=5e-6)
    assert found.steps <= 25


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_chain_of_stiff_torsion_springs_falls_as_a_bar(integrator):
    """Four links of 0.2 m and 0.1 kg, springs of 1e6 N m/rad: θ'' = 0.4 m M g cos θ / I, and θ is ½ θ'' t². DOP853
    takes 60,000 steps."""
    found = run_stiff(chain(1e6), 0.05, integrator, 1e-4)
    inertia, moment = 4 * 3.4e-4 + 0.1 * (0.1**2 + 0.3**2 + 0.5**2 + 0.7**2), 0.4 * 9.81 * 0.4
    angle = 0.5 * moment / inertia * 0.05**2
    assert found.q[-1, 0] == pytest.approx(0.1 * cos(angle), abs=1e-7)
    assert found.q[-1, 21] == pytest.approx(0.7 * cos(angle), abs=1e-6)
    assert found.steps <= 6
    assert found.closure <= 1e-13


def test_a_governor_whose_spring_and_damper_hardly_give_way():
    """1e8 N/m and 1e5 N s/m: two methods that differ agree in a few steps."""
    found = [run_stiff(governor(1e8), 0.05, name, 1e-4) for name in IMPLICIT]
    assert np.abs(found[0].q - found[1].q).max() < 2e-4
    assert max(each.steps for each in found) <= 20
    assert max(each.closure for each in found) <= 1e-13


@pytest.mark.parametrize("case", ["rsup", "elastic-rod"])
def test_rods_that_stiff_bushings_hold_together(case):
    """Two halves in space, ten pieces in the plane, at 1e10 N/m: two methods that differ agree in a few steps, where
    DOP853 takes thousands."""
    found = [run_stiff(CASES[case](1e10), 0.05, name, 1e-4) for name in IMPLICIT]
    assert found[0].off(found[1]) < 1e-4
    assert max(each.steps for each in found) <= 20
    assert max(each.closure for each in found) <= 1e-13


# A stiff four-bar and a governor beside Lagrange's equations in their angles, the reference for other programs.


@pytest.mark.parametrize("k", [1e4, 1e7])
def test_the_motion_is_that_of_the_angles(k):
    """At 1e7 N/m, too, the two methods, neither of which knows the other's coordinates, agree to what both leave."""
    bar, end = FourBar(k), 0.1
    exact = solve_ivp(bar.slope, (0.0, end), bar.start, method="DOP853", rtol=1e-10, atol=1e-12).y[:4, -1]
    q = run_stiff(four_bar(k), end, "radau5", 1e-9).q[-1].reshape(4, 7)
    near = q[1, [0, 2]] + HALF / 2 * np.array([np.cos(exact[1]), np.sin(exact[1])])
    assert near == pytest.approx(bar.watched(exact)[0, [0, 2]], abs=1e-8)
    crank = CRANK / 2 * np.array([np.cos(exact[0]), np.sin(exact[0])])
    assert q[0, [0, 2]] == pytest.approx(crank, abs=1e-8)


def test_the_accelerations_at_the_start_are_the_same():
    """By them each program is seen to have the same mechanism."""
    bar, mechanism, recorder = FourBar(1e6), Mechanism.of(four_bar(1e6)), Recorder()
    simulate(mechanism.system, mechanism.state, Settings(duration=1e-6, step=1e-6, integrator="rk4"), recorder)
    about_y = recorder["bodies/angular_acceleration"][0, :, 1]
    assert -about_y == pytest.approx(bar.slope(0.0, bar.start)[4:], rel=1e-9)


@pytest.mark.parametrize("k", [1e4, 1e7])
def test_the_governor_turns_and_opens_as_its_angles(k):
    made, end = Governor(k), 0.1
    exact = solve_ivp(made.slope, (0.0, end), made.start, method="DOP853", rtol=1e-11, atol=1e-13).y[:2, -1]
    q = run_stiff(governor(k), end, "radau5", 1e-9).q[-1].reshape(4, 7)
    ball, collar = made.watched(exact)
    assert [*q[1, :2], q[3, 2]] == pytest.approx([*ball[:2], collar[2]], abs=1e-8)
