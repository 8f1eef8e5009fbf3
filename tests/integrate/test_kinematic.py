"""Motions that drive everything: branches, turning points, dry friction, works and states along the motion."""

from __future__ import annotations

from math import cos, sin

import numpy as np
import pytest

import mbproj
from mbproj import Mechanism, check, simulate_certified
from mbproj.base.arrays import Array
from mbproj.base.errors import InputError, SimulationError
from mbproj.motion.formulations import choice
from mbproj.motion.steppers.tableau import ERROR_ORDER, ORDER, quadrature
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run
from mbproj.studies.compare import compare
from tests.crossed import crossed, full
from tests.integrate.kinematic_scenes import (
    BY_THE_ROCKER,
    FORMULATIONS,
    FOUR_BAR,
    PARALLELOGRAM,
    rocker_angle,
    rocker_at_dead_centre,
    run,
)
from tests.model.element_scenes import DRIVEN, T1, with_states

# The motion itself: closed forms, branches, turning points, and what a run says of itself.

COORDINATE, SPEED = "joints/coordinate", "joints/speed"


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_driven_four_bar_is_where_the_cosine_rule_puts_it(formulation):
    report, found, _ = run(FOUR_BAR, formulation=formulation, duration="2 s")
    assert report.kinematic and report.formulation == formulation
    rocker = found[COORDINATE][:, 3]
    np.testing.assert_allclose(rocker - rocker[0], rocker_angle(found["time"]) - rocker_angle(0.0), atol=4e-13)
    step = 1e-5
    rate = (rocker_angle(found["time"] + step) - rocker_angle(found["time"] - step)) / (2.0 * step)
    np.testing.assert_allclose(found[SPEED][:, 3], rate, rtol=0, atol=1e-7)
    assert report.energy_drift_relative < 1e-10
    assert not report.drifts


def test_accelerations_reactions_and_torques_are_those_of_a_run_that_integrates():
    _, found, _ = run(FOUR_BAR)
    report, integrated, _ = run(FOUR_BAR, kinematic=False, tolerance=1e-11)
    assert not report.kinematic
    np.testing.assert_array_equal(found["time"], integrated["time"])
    for path in ("bodies/acceleration", "joints/reaction_force", "motions/force", "diagnostics/work"):
        scale = np.abs(integrated[path]).max()
        np.testing.assert_allclose(found[path], integrated[path], rtol=0, atol=1e-9 * scale, err_msg=path)


def test_samples_take_no_more_than_two_evaluations_each():
    pytest.importorskip("mbproj.kernel._core")
    report, _, _ = run(FOUR_BAR, output_step="2 ms")
    assert report.counters["evaluations"] < 2 * 1001
    assert report.counters["steps"] < 100


def test_steps_of_the_scene_say_when_to_record_and_nothing_else():
    _, found, _ = run(FOUR_BAR, duration="0.4 s")
    _, fixed, _ = run(FOUR_BAR, duration="0.4 s", step="10 ms", integrator="heun2")
    np.testing.assert_allclose(fixed["time"], found["time"], rtol=1e-15)
    np.testing.assert_allclose(fixed[COORDINATE], found[COORDINATE], rtol=0, atol=1e-12)


def test_a_motion_turns_back_before_the_dead_centre():
    before = rocker_at_dead_centre() - 1e-5
    there_and_back = BY_THE_ROCKER.replace("constant_speed: 20 rpm", f"expression: '{before}*sin(3*t)**2'")
    _, found, _ = run(there_and_back, duration="3 s")
    np.testing.assert_allclose(found[COORDINATE][:, 3], before * np.sin(3.0 * found["time"]) ** 2, atol=1e-12)
    crank = np.unwrap(found[COORDINATE][:, 0])
    assert np.ptp(crank) < np.pi  # it has not gone over to the other branch


def test_a_parallelogram_stays_one_where_branches_cross():
    report, found, _ = run(PARALLELOGRAM, duration="3 s", output_step="7 ms")
    crank, rocker = found[COORDINATE][:, 0], found[COORDINATE][:, 3]
    np.testing.assert_allclose(np.unwrap(rocker), np.unwrap(crank), atol=1e-9)
    assert report.kinematic


def test_a_motion_begins_at_rest():
    text = FOUR_BAR.replace(
        "constant_speed: 60 rpm", "smooth_step: {from: 0, to: 2 rad, start: 0.1 s, duration: 0.5 s}"
    )
    report, found, _ = run(text, duration="0.8 s", output_step="10 ms")
    np.testing.assert_allclose(found[COORDINATE][found["time"] >= 0.6, 0], 2.0, atol=1e-12)
    assert report.energy_drift_relative < 1e-9


def test_a_run_goes_on_from_its_mark_to_the_same_bits():
    _, whole, _ = run(FOUR_BAR, duration="1 s", resumed={})
    _, _, marks = run(FOUR_BAR, duration="0.5 s", resumed={})
    _, rest, _ = run(FOUR_BAR, duration="1 s", resumed=marks[-1])
    count = len(rest["time"])
    assert 0 < count < len(whole["time"])
    for path in (COORDINATE, "motions/force", "diagnostics/work"):
        np.testing.assert_array_equal(rest[path], whole[path][-count:])


def test_a_mechanism_that_is_free_is_refused():
    free = FOUR_BAR[: FOUR_BAR.index("motions:")]
    with pytest.raises(InputError, match="has 1 degree of freedom: a kinematic run needs 0"):
        run(free, kinematic=True)
    assert not run(free, duration="0.1 s")[0].kinematic


#: A trailer whose axle keeps its direction, behind a hitch that is drawn along x.
TRAILER = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, tolerance: 1e-9}
bodies:
  hitch: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  trailer: {mass: 2, inertia: [0.1, 0.1, 0.2], position: [0, -1.2, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, hitch], location: [0, 0, 0], axis: x}
  pin: {type: revolute, bodies: [hitch, trailer], location: [0, 0, 0], axis: z}
  edge: {type: knife_edge, bodies: [ground, trailer], location: [0, -1.2, 0], axis: [1, 0, 0]}
motions: {pull: {joint: rail, displacement: 0.4*t}}
"""


def test_what_rolls_has_to_be_integrated():
    """Its pose is not a function of the drive: the angle from the path goes with tan(φ/2) = exp(-v t / l)."""
    with pytest.raises(InputError, match="leave 1 freedom of the pose: it has to be integrated; leave out 'kinematic'"):
        run(TRAILER, kinematic=True)
    report, columns, _ = run(TRAILER)
    place = columns["bodies/position"][-1]
    φ = 2.0 * np.arctan(np.exp(-0.4 / 1.2))
    assert not report.kinematic
    assert place[1] - place[0] == pytest.approx([-1.2 * np.cos(φ), -1.2 * np.sin(φ), 0], abs=1e-8)


def test_a_kinematic_scene_needs_neither_step_nor_tolerance():
    text = FOUR_BAR.replace("tolerance: 1e-3, integrator: dop853", "kinematic: true")
    report, found, _ = run(text, duration="0.1 s")
    assert report.kinematic and len(found["time"]) == 3


def test_a_certificate_compares_with_poses_of_another_method():
    scene = read_scene_text(FOUR_BAR, simulation={"duration": "0.5 s"})
    _, trust = simulate_certified(Mechanism.of(scene), settings_to_run(scene))
    assert trust.error.max() < 1e-12 and trust.uncertainty.max() < 1e-12
    assert "Gauss-Newton" in trust.solution


def test_full_says_to_use_reduced(monkeypatch):
    """Its steps in NumPy integrate; contacts and implicit steps, which the kernel makes for it, may be kinematic."""
    with pytest.raises(InputError, match="the full formulation has no kinematic steps; use reduced: 'form") as refused:
        run(FOUR_BAR, formulation="full")
    assert "or integrate the motion, with 'kinematic: false'" in str(refused.value)
    assert run(FOUR_BAR, projection="gpopm-pinv", duration="0.1 s")[0].formulation == "planar"  # it is not used
    assert not run(FOUR_BAR, formulation="full", kinematic=False, duration="0.05 s")[0].kinematic
    found = check(read_scene_text(FOUR_BAR, simulation={"formulation": "full"}))
    assert [each.message for each in found.problems] == ["the full formulation has no kinematic steps"]
    monkeypatch.setattr(choice, "core", lambda: None)
    with pytest.raises(InputError, match="kinematic steps need the kernel; install a C\\+\\+ compiler, or a wheel"):
        run(FOUR_BAR, formulation="full")


def test_studies_say_that_there_is_no_setting_to_choose():
    scene = read_scene_text(FOUR_BAR)
    with pytest.raises(InputError, match="kinematic, exact at any setting"):
        compare(scene, tolerances=[1e-6])


# Branches of a motion that cross, that nearly cross, and that end at a dead centre.

#: A force with a state: what is integrated beside the motion does not shorten the steps at what is nearly singular.
SEAL = "forces: {seal: {type: torsion_maxwell, joint: A, stiffness: 1, damping: 1}}\n"
COARSE = {"integrator": "dopri5", "tolerance": 1e-2, "output_step": "20 ms"}
CRANK, LENGTH, CRANK_SPEED = 0.2, 0.5, 57.0 * 2.0 * np.pi / 60.0


def rocker_angle_of_branch(crank, side, shorter):
    """Of the rocker from the ground's line, by the cosine rule, on the branch to this side of the diagonal."""
    x, z = LENGTH - (CRANK - shorter) * np.cos(crank), -(CRANK - shorter) * np.sin(crank)
    diagonal = np.hypot(x, z)
    inner = np.arccos((diagonal**2 + CRANK**2 - LENGTH**2) / (2.0 * diagonal * CRANK))
    return np.arctan2(-z, -x) + side * inner


def nearly_a_parallelogram(shorter: float) -> str:
    """The crank is shorter than the rocker by this: twice a turn it is in line with it, and nearly with the others."""
    z = CRANK - shorter
    beside = rocker_angle_of_branch(np.pi / 2.0, -1, shorter)
    x, height = LENGTH + CRANK * np.cos(beside), CRANK * np.sin(beside)
    text = PARALLELOGRAM.replace("location: [0, 0, 0.2]", f"location: [0, 0, {z!r}]")
    return text.replace("location: [0.5, 0, 0.2]", f"location: [{float(x)!r}, 0, {float(height)!r}]")


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("shorter", [1e-4, 1e-6, 1e-8])
def test_a_motion_stays_on_its_branch_where_another_one_is_next_to_it(shorter, formulation):
    """In line both branches are √(shorter) apart. A step that goes straight on comes to the other one, with velocities
    that agree."""
    text = nearly_a_parallelogram(shorter).replace("tolerance: 1e-3, integrator: dop853, ", "") + SEAL
    report, found, _ = run(text, formulation=formulation, duration="3 s", **COARSE)
    assert report.kinematic
    crank = np.pi / 2.0 + CRANK_SPEED * found["time"]
    own, other = (rocker_angle_of_branch(crank, side, shorter) for side in (-1, 1))
    turned = found["joints/coordinate"][:, 3] + rocker_angle_of_branch(np.pi / 2.0, -1, shorter)
    off = np.abs(np.exp(1j * turned) - np.exp(1j * own))
    assert np.abs(np.exp(1j * own) - np.exp(1j * other)).max() > 1.0
    assert off.max() < 1e-10


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_parallelogram_with_a_state_passes_where_branches_cross(formulation):
    text = PARALLELOGRAM.replace("tolerance: 1e-3, integrator: dop853, ", "") + SEAL
    report, found, _ = run(text, formulation=formulation, duration="3 s", **COARSE)
    assert report.kinematic
    crank, rocker = found["joints/coordinate"][:, 0], found["joints/coordinate"][:, 3]
    assert crank[-1] > 0.5 * np.pi
    np.testing.assert_allclose(np.unwrap(rocker), np.unwrap(crank), atol=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_run_stops_at_a_dead_centre_and_names_the_motion_and_its_joint(formulation):
    with pytest.raises(SimulationError) as stopped:
        run(BY_THE_ROCKER, formulation=formulation, output_step="10 ms")
    time = rocker_at_dead_centre() / (2.0 * np.pi / 3.0)
    assert stopped.value.time == pytest.approx(time, abs=1e-7)
    assert stopped.value.where == "motion 'drive'"
    assert f"D.angle = {rocker_at_dead_centre():.3g} rad" in str(stopped.value)


def test_the_branch_of_a_mechanism_of_many_bodies_is_watched_too():
    """Eight linkages with a motion each, of which two have their branches next to each other."""
    pytest.importorskip("mbproj.kernel._core")
    shorter = [1e-6, 1e-8, *np.linspace(0.02, 0.05, 6).tolist()]
    texts = [nearly_a_parallelogram(each) for each in shorter]
    blocks = {"bodies": "", "joints": "", "motions": ""}
    for number, text in enumerate(texts):
        for name in blocks:
            lines = text[text.index(f"{name}:") :].splitlines()[1:]
            own = "\n".join(lines[: next((k for k, line in enumerate(lines) if line[:1] != " "), len(lines))])
            for part in ("crank", "coupler", "rocker"):
                own = own.replace(f"{part}:", f"{part}{number}:").replace(f"{part}]", f"{part}{number}]")
                own = own.replace(f"[{part},", f"[{part}{number},")
            for joint in "ABCD":
                own = own.replace(f"  {joint}: ", f"  {joint}{number}: ").replace(
                    f"joint: {joint},", f"joint: {joint}{number},"
                )
            blocks[name] += own.replace("drive:", f"drive{number}:") + "\n"
    head = texts[0][: texts[0].index("bodies:")].replace("tolerance: 1e-3, integrator: dop853, ", "")
    text = head + "".join(f"{name}:\n{entries}" for name, entries in blocks.items())
    report, found, _ = run(text + SEAL.replace("joint: A", "joint: A0"), duration="3 s", **COARSE)
    assert report.kinematic and found["bodies/position"].shape[1] == 24
    crank = np.pi / 2.0 + CRANK_SPEED * found["time"]
    for number, each in enumerate(shorter):
        turned = found["joints/coordinate"][:, 4 * number + 3] + rocker_angle_of_branch(np.pi / 2.0, -1, each)
        off = np.abs(np.exp(1j * turned) - np.exp(1j * rocker_angle_of_branch(crank, -1, each)))
        assert off.max() < 1e-10, each


# Dry friction where motions drive everything: a force that follows the rate of its joint, and decides no motion.

TORQUE = 2.0
SWING = "expression: '0.3*sin(5*t)'"


def smooth_step(start: float, end: float) -> str:
    """From 0 to 1, at rest before and after."""
    x = f"max(0, min(1, (t - {start})/({end} - {start})))"
    return f"({x})**3*(10 - 15*{x} + 6*({x})**2)"


#: There, at rest from 0.3 s to 0.45 s, and back.
THERE_AND_BACK = f"expression: '{smooth_step(0.1, 0.3)} - {smooth_step(0.45, 0.6)}'"
PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1.3 s, output_step: 10 ms, kinematic: true}
bodies:
  arm: {mass: 2, inertia: [0.05, 0.05, 0.05], position: [0, 0, -0.4]}
joints:
  pin: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, -1, 0]}
motions:
  drive: {joint: pin, angle: {expression: '0.8*sin(3*t)'}}
forces:
  rub: {type: friction, joint: pin, coulomb: {coefficient: 0.2, radius: 30 mm}}
"""


def four_bar(law: str, joint: str = "") -> str:
    """The four bars with this law of their crank, and dry friction at a joint."""
    rub = f"forces: {{rub: {{type: friction, joint: {joint}, coulomb: {{torque: {TORQUE}}}}}}}\n" if joint else ""
    return FOUR_BAR.replace("constant_speed: 60 rpm", law) + rub


@pytest.mark.full_where(formulation="full")
@crossed(
    "joint, column, formulation", [pytest.param("A", 0), pytest.param("D", 3)], ["full", *FORMULATIONS], dear=["full"]
)
def test_a_swing_takes_what_friction_loses_in_either_direction(joint, column, formulation):
    """Through two reversals, or one in full, the drive adds M |s'| / θ', s' the rate of the joint that rubs and θ' that
    of the drive."""
    until = "0.6 s" if formulation == "full" else "1.2 s"  # in NumPy: seconds
    options = {"formulation": formulation, "duration": until, "output_step": "25 ms"}
    report, found, _ = run(four_bar(SWING, joint), **options)
    _, without, _ = run(four_bar(SWING), **options | {"formulation": "reduced"})
    assert report.kinematic
    t, rate = found["time"], found["joints/speed"][:, column]
    drive = 1.5 * np.cos(5.0 * t)
    np.testing.assert_allclose(found["friction/force"][:, 0], -TORQUE * np.sign(rate), rtol=1e-14)
    more = found["motions/force"][:, 0] - without["motions/force"][:, 0]
    np.testing.assert_allclose(more, TORQUE * np.abs(rate) / drive, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(found["joints/coordinate"], without["joints/coordinate"], rtol=0.0, atol=1e-12)
    assert report.energy_drift_relative < 1e-9


@pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS])
def test_the_work_of_a_swing_is_its_torque_times_the_way(formulation):
    report, found, _ = run(four_bar(SWING, "A"), formulation=formulation, duration="1.2 s", output_step="0.1 s")
    t = found["time"]
    quarter = np.floor(5.0 * t / np.pi + 0.5)  # half turns of the sine that are over
    way = 0.3 * (2.0 * quarter + np.cos(np.pi * quarter) * np.sin(5.0 * t))
    np.testing.assert_allclose(found["diagnostics/dissipation"], TORQUE * way, rtol=0.0, atol=1e-10)
    assert report.energy_drift_relative < 1e-9


@pytest.mark.parametrize(
    ("formulation", "joint", "column"),
    [full("full", "A", 0), *((each, "D", 3) for each in FORMULATIONS)],  # the full one takes 0.1 s an event
)
def test_at_rest_friction_bears_nothing_and_the_motion_all(formulation, joint, column):
    options = {"formulation": formulation, "duration": "0.7 s", "output_step": "10 ms"}
    report, found, _ = run(four_bar(THERE_AND_BACK, joint), **options)
    _, without, _ = run(four_bar(THERE_AND_BACK), **options | {"formulation": "reduced"})
    assert report.kinematic
    t, force = found["time"], found["friction/force"][:, 0]
    rests = (t < 0.1) | ((t > 0.305) & (t < 0.45)) | (t > 0.605)
    moves = ((t > 0.1) & (t < 0.3)) | ((t > 0.45) & (t < 0.6))
    rate = found["joints/speed"][:, column]
    np.testing.assert_array_equal(force[rests], 0.0)
    np.testing.assert_array_equal(found["friction/state"][rests, 0], 0)
    np.testing.assert_allclose(rate[rests], 0.0, atol=1e-20)
    np.testing.assert_allclose(force[moves], -TORQUE * np.sign(rate[moves]), rtol=1e-14)
    np.testing.assert_allclose(
        found["motions/force"][rests, 0], without["motions/force"][rests, 0], rtol=0.0, atol=1e-12
    )
    way = np.abs(np.diff(found["joints/coordinate"][:, column])).sum()
    assert found["diagnostics/dissipation"][-1] == pytest.approx(TORQUE * way, rel=2e-3 if joint == "D" else 1e-9)
    assert report.energy_drift_relative < 1e-8


@pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS])
def test_friction_that_goes_by_the_load_of_its_bearing_turns_with_the_rate(formulation):
    """m g a sin θ + J θ'' + μ r |F| sign θ', with F what holds the arm's mass on its circle."""
    report, found, _ = run(PENDULUM, formulation=formulation)
    t = found["time"]
    angle, rate, bend = 0.8 * np.sin(3.0 * t), 2.4 * np.cos(3.0 * t), -7.2 * np.sin(3.0 * t)
    m, a, J, g = 2.0, 0.4, 0.05, 9.81
    along, across = m * (a * rate**2 + g * np.cos(angle)), m * (a * bend + g * np.sin(angle))
    expected = (J + m * a**2) * bend + m * g * a * np.sin(angle)
    expected += 0.2 * 0.03 * np.hypot(along, across) * np.sign(rate)
    np.testing.assert_allclose(found["motions/force"][:, 0], expected, rtol=0.0, atol=1e-12)
    assert report.kinematic and report.energy_drift_relative < 1e-9


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_what_rests_under_load_does_no_work(formulation):
    """A spring holds its force through a rest in which the arm's velocity is no more than round-off."""
    text = PENDULUM.replace("0.8*sin(3*t)", f"0.5*{smooth_step(0.8, 1.2)}").replace("-9.81]", "0]")
    text = (
        text[: text.index("forces:")]
        + "forces: {k: {type: torsion_spring_damper, joint: pin, stiffness: 40, free_angle: 1}}\n"
    )
    report, found, _ = run(text, formulation=formulation)
    rests = found["time"] < 0.8
    np.testing.assert_allclose(found["bodies/velocity"][rests], 0.0, atol=1e-20)
    np.testing.assert_allclose(found["diagnostics/work"][rests], 0.0, atol=1e-20)
    np.testing.assert_allclose(found["motions/force"][rests, 0], -40.0, rtol=1e-13)
    assert report.energy_drift_relative < 1e-9


# What is integrated along a kinematic motion: works, losses, states of elements; and the quadrature.

#: Behind the crank's motion goes nothing; x follows a sine, z follows x.
LAGS = (f"(sin({DRIVEN}*t) - x)/{T1}", "x")


def test_the_quadrature_is_exact_for_polynomials_of_its_order():
    rule = quadrature()
    for degree in range(ORDER):
        assert rule.b @ rule.c**degree == pytest.approx(1.0 / (degree + 1), abs=1e-13)
    assert rule.b @ rule.c**ORDER != pytest.approx(1.0 / (ORDER + 1), abs=1e-9)
    for degree in range(ERROR_ORDER):
        assert rule.error[0, :-1] @ rule.c**degree == pytest.approx(0.0, abs=1e-13)
    assert abs(rule.error[0, :-1] @ rule.c**ERROR_ORDER) > 1e-5


def test_its_extension_is_the_integral_to_any_part_of_a_step():
    rule, theta = quadrature(), 0.37
    for degree in range(7):
        found = theta ** np.arange(1, 8) @ (rule.dense[:-1].T @ rule.c**degree)
        assert found == pytest.approx(theta ** (degree + 1) / (degree + 1), abs=1e-13)


def test_a_stage_is_predicted_from_those_before():
    rule = quadrature()
    for stage in range(1, 7):
        for degree in range(stage):
            found = rule.a[stage, :stage] @ rule.c[:stage] ** degree
            assert found == pytest.approx(rule.c[stage] ** (degree + 1) / (degree + 1), rel=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_dampers_take_what_their_rate_says(formulation):
    """Of a damper at the driven pin: c ω² a second; and of the same with a sine, in closed form."""
    text = FOUR_BAR.replace("constant_speed: 60 rpm", "expression: '0.3*sin(5*t)'")
    text += "forces: {damper: {type: torsion_spring_damper, joint: A, damping: 0.4}}\n"
    report, found, _ = run(text, formulation=formulation, duration="0.6 s")
    t = found["time"]
    lost = 0.4 * 1.5**2 * (0.5 * t + np.sin(10.0 * t) / 20.0)
    np.testing.assert_allclose(found["diagnostics/dissipation"], lost, rtol=0, atol=1e-10)
    assert report.energy_drift < 1e-9


def test_dry_friction_at_a_driven_joint_loses_its_torque_times_the_way():
    text = FOUR_BAR + "forces: {rub: {type: friction, joint: D, coulomb: {torque: 2 N*m}}}\n"
    report, found, _ = run(text, duration="1 s", output_step="1 ms", kinematic="true")
    way = np.abs(np.diff(np.unwrap(found["joints/coordinate"][:, 3]))).sum()
    assert report.kinematic
    assert report.energy.dissipation == pytest.approx(2.0 * way, rel=1e-5)
    assert report.energy_drift_relative < 1e-9


@crossed(
    "settings, off, formulation",
    [
        pytest.param({"integrator": "dop853", "tolerance": 1e-9}, 1e-8),
        pytest.param({"integrator": "rk4", "step": "2.5 ms"}, 1e-6),
        pytest.param({"integrator": "radau5", "tolerance": 1e-6}, 1e-5),
        pytest.param({"integrator": "auto", "tolerance": 1e-8}, 1e-6),
    ],
    FORMULATIONS,
)
def test_states_are_integrated_by_the_scenes_integrator(formulation, settings, off):
    text = FOUR_BAR.replace("tolerance: 1e-3, integrator: dop853, ", "")
    options = {"formulation": formulation, "duration": "0.05 s", "output_step": "0.025 s", **settings}
    report, found, _ = run(text, change=lambda system: with_states(system, LAGS, start=(0.0, 0.0)), **options)
    assert report.kinematic
    t, ω = found["time"], DRIVEN
    x = (np.sin(ω * t) - ω * T1 * np.cos(ω * t) + ω * T1 * np.exp(-t / T1)) / (1.0 + (ω * T1) ** 2)
    np.testing.assert_allclose(found["states/value"][:, 0], x, rtol=0, atol=off)
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], 2.0 * np.pi * t, atol=1e-12)


@pytest.mark.full
def test_implicit_steps_integrate_them_in_full_too():
    test_states_are_integrated_by_the_scenes_integrator("full", {"integrator": "radau5", "tolerance": 1e-6}, 1e-5)


#: A bar that a motion turns: no degree of freedom, and no step.
TURNED = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, output_step: 0.25 s}
bodies:
  bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0]}
motions:
  drive: {joint: pin, angle: {constant_speed: 2}}
"""


def test_a_kinematic_run_needs_no_step():
    """The bar's centre is at (cos 2t, 0, sin 2t). A mechanism that has to be integrated needs one, as ever."""
    with mbproj.run(TURNED) as results:
        expected = np.stack([np.cos(2.0 * results.time), 0.0 * results.time, np.sin(2.0 * results.time)], axis=1)
        np.testing.assert_allclose(results.body("bar").position, expected, atol=1e-12)
    free = TURNED.replace("joints:\n", "  more: {mass: 1, inertia: [1, 1, 1], position: [5, 0, 0]}\njoints:\n")
    with pytest.raises(InputError, match="scene:4:1: error: the scene has neither step nor tolerance"):
        mbproj.run(free)
    with mbproj.run(free, step=0.01) as results:
        assert results.body("more").position[-1, 2] == pytest.approx(-0.5 * 9.81, abs=1e-9)


#: A bucket on a stick, turned by a rocker and a link. Both motions begin and end at rest.
BUCKET = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 3 s, output_step: 50 ms}
bodies:
  stick: {mass: 700 kg, inertia: [800, 800, 50], position: [4.0, 0, 1.0]}
  bucket: {mass: 1500 kg, inertia: [240, 290, 240], position: [5.1, 0, -1.1]}
  rocker: {mass: 40 kg, inertia: [1, 2, 2], position: [4.6, 0, -0.1]}
  link: {mass: 50 kg, inertia: [2, 2, 1], position: [4.85, 0, -0.3]}
joints:
  S: {type: revolute, bodies: [ground, stick], location: [3.8, 0, 2.0], axis: y}
  K: {type: revolute, bodies: [stick, bucket], location: [4.5, 0, -0.65], axis: y}
  M: {type: revolute, bodies: [stick, rocker], location: [4.35, 0, -0.15], axis: y}
  P: {type: revolute, bodies: [rocker, link], location: [4.85, 0, -0.1], axis: y}
  B: {type: revolute, bodies: [link, bucket], location: [4.85, 0, -0.5], axis: y}
motions:
  swing: {joint: S, angle: {smooth_step: {to: 10 deg, duration: 2 s}}}
  tilt: {joint: K, angle: {smooth_step: {to: 30 deg, duration: 2 s}}}
"""


def test_a_linkage_near_a_singular_pose_begins_and_ends_at_rest():
    """The first step of a motion from rest is shorter than round-off: the pose does not change, nor does its branch.
    The bucket's centre ends where two turns take it."""

    def turned(angle: float, x: float, z: float) -> Array:
        return np.array([cos(angle) * x + sin(angle) * z, cos(angle) * z - sin(angle) * x])

    pin = np.array([3.8, 2.0]) + turned(np.deg2rad(10.0), 0.7, -2.65)
    end = pin + turned(np.deg2rad(40.0), 0.6, -0.45)
    with mbproj.run(BUCKET) as results:
        assert results.attributes["kinematic"]
        np.testing.assert_allclose(results.body("bucket").position[-1, [0, 2]], end, atol=1e-12)
        assert float(results["diagnostics/position_violation"].max()) <= 1e-12


FAST = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 0.02, step: {step}}}
bodies: {{arm: {{mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}}}
joints: {{A: {{type: {kind}, bodies: [ground, arm], location: [0, 0, 0], axis: [0, 1, 0]}}}}
motions: {{m: {{joint: A, {key}: '{text}'}}}}
"""
TOO_FAST = {
    "angle: 1e9*t": "motion 'm' reaches 1e[+]09 rad/s, 1e[+]07 rad in a step",
    "angle: (1 + t)**1024": "motion 'm' reaches 6.4e[+]11 rad/s, 6.4e[+]09 rad in a step",
    "displacement: sin(1e12*t)": "motion 'm' reaches 1e[+]12 m/s, 1e[+]10 m in a step",
}


@pytest.mark.parametrize("motion", TOO_FAST)
def test_a_motion_too_fast_to_follow_is_refused_with_its_speed(motion):
    key, _, text = motion.partition(": ")
    kind = "revolute" if key == "angle" else "prismatic"
    with pytest.raises(InputError, match=TOO_FAST[motion]):
        mbproj.run(FAST.format(step=0.01, kind=kind, key=key, text=text))


def test_a_fast_motion_in_steps_that_follow_it_runs():
    """10^5 rad/s: 300 turns."""
    with mbproj.run(FAST.format(step=0.01, kind="revolute", key="angle", text="1e5*t")) as results:
        assert results.coordinate("A.angle").value[-1] == pytest.approx(2000.0, rel=1e-12)
