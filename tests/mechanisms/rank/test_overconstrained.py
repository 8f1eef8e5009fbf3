"""Linkages that move although they have more rows than they need, structures that cannot, and mechanisms that lean."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mbproj
from mbproj import InputError, assemble, compile_system, initial_guess, read_scene, simulate, unique_components
from mbproj.base.mechanisms_folder import mechanism
from mbproj.equations.rank.redundancy import redundancy
from mbproj.scene.scene import read_scene_text
from scripts.turned_mechanisms import disagreements, turned
from tests.crossed import crossed, once, some
from tests.mechanisms.closed_forms import Linkage, bennett_poses, bennett_ratio, bricard_poses
from tests.mechanisms.running import TIGHT, Run, assert_close, run, run_text
from tests.support import ROOT, assembled

# Linkages in space that move although their joints have more rows than they need, against their closed forms: redundant
# joints change no motion, and the rows that are left out stay closed.


@pytest.mark.parametrize(("name", "redundant"), [("bennett", 3), ("bricard", 1), ("n_four_bar", 6), ("locomotive", 7)])
def test_the_full_formulation_has_the_same_motion_and_the_same_smallest_reactions(name, redundant):
    """Independent combinations of all rows, against rows that are left out in the kernel."""
    settings = {"integrator": "dop853", "step": "5 ms", "duration": "50 ms", "output_step": "25 ms"}
    full, reduced = (run(name, **settings, formulation=formulation) for formulation in ("full", "reduced"))
    assert full.report.redundant_rows == reduced.report.redundant_rows == redundant
    for path, tolerance in (
        ("bodies/position", 1e-12),
        ("bodies/velocity", 1e-11),
        ("bodies/acceleration", 1e-9),
        ("joints/reaction_force", 1e-8),
        ("joints/reaction_torque", 1e-8),
    ):
        assert_close(full[path], reduced[path], tolerance * max(1.0, np.abs(reduced[path]).max()))
    assert full.report.position_violation.value <= 2e-13


class Blocks(list):
    """Takes the blocks of samples of a run."""

    def write(self, block):
        self.append(block.samples)

    def joined(self, quantity: str) -> np.ndarray:
        return np.concatenate([getattr(samples, quantity) for samples in self])


@pytest.mark.parametrize("name", some(["bricard", "bennett", "stewart_platform", "n_four_bar", "locomotive"], 5))
def test_a_full_run_that_starts_at_a_recorded_state_is_the_long_one(name):
    """To the bit. The kernel's runs: tests/integrate/test_row_policy.py."""
    step, steps, long = 1.0 / 128.0, 40, Blocks()
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml")
    system, rk4 = compile_system(scene), replace(scene.settings, formulation="full", integrator="rk4", tolerance=None)
    settings = replace(rk4, duration=steps * step, step=step, output_step=step)
    simulate(system, assemble(system, initial_guess(scene, system)), settings, long)
    states = [samples.state(k) for samples in long for k in range(len(samples.t))]
    for at in (9, 31):
        again = Blocks()
        simulate(system, states[at], replace(settings, duration=(steps - at) * step), again)
        for quantity in ("q", "v", "acceleration"):
            np.testing.assert_array_equal(again.joined(quantity), long.joined(quantity)[at:])


def test_the_rows_that_are_held_are_changed_before_they_depend_on_each_other():
    """The linkage is as far from singular all round, any 17 of its 20 rows are not: on the constraints they say the
    same, and in the stages of a step that comes near such a pose they do not. Where they were kept until the smallest
    pivot of all was 1e-2 of what it had been, 34 of 154 steps were rejected."""
    settings = {"integrator": "dopri5", "tolerance": "1e-8", "duration": "0.4", "output_step": "0.1"}
    full, reduced = (run("bennett", **settings, formulation=which).report.counters for which in ("full", "reduced"))
    assert reduced["rejected_steps"] <= 5
    assert reduced["projection_failures"] == 0
    assert reduced["evaluations"] < 1.5 * full["evaluations"]


@pytest.fixture(scope="module")
def bennett() -> Run:
    return run("bennett", **TIGHT, duration=1.0, output_step=0.02)


def test_bennetts_relation_between_the_angles(bennett):
    θ1, θ2, θ3, θ4 = bennett_angles(bennett)
    assert np.ptp(θ1) > 2 * np.pi
    assert_close(np.sin(θ1 / 2) * np.sin(θ2 / 2), bennett_ratio(bennett) * np.cos(θ1 / 2) * np.cos(θ2 / 2), 1e-12)
    assert_close(θ3, -θ1, 1e-12)
    assert_close(θ4, -θ2, 1e-12)


def bennett_angles(done: Run) -> list[np.ndarray]:
    """θ1 to θ4, up to full turns: the rocker's joint angle is that of the frame from the rocker, taken backwards."""
    first, second = done.parameters["start"], done.parameters["next"]
    A, B, C, D = (done.column("joints/coordinate", f"{joint}.angle") for joint in "ABCD")
    return [first + A, second + B, C - first, -D - second]


def test_bennetts_linkage_is_where_its_closed_form_and_its_energy_have_it(bennett):
    linkage = Linkage(bennett, lambda u: bennett_poses(bennett, u))
    θ, speed = bennett_angles(bennett)[0], bennett.column("joints/speed", "A.angle")
    linkage.assert_poses(θ, 1e-12)
    linkage.assert_velocities(θ, speed, 1e-11)
    linkage.assert_accelerations(θ, speed, 1e-8)
    linkage.assert_times(θ, bennett.parameters["speed"], 1e-10)
    assert bennett.report.energy_drift_relative < 1e-11


@pytest.fixture(scope="module")
def bricard() -> Run:
    return run("bricard", **TIGHT, duration=1.0, output_step=0.02)


def bricard_coordinate(done: Run) -> tuple[np.ndarray, np.ndarray]:
    """u and u', where x = tan(45° + β/2) = √3 sin u and y = tan(45° + α/2) = √3 cos u / w with w² = 1 + x²: the closed
    curve of (α, β), once round in 2π. u is the inclination of the pins B to the plane that the axis of symmetry is
    normal to."""
    (x, x_rate), (y, y_rate) = (
        (
            np.tan(np.pi / 4 + done.column("joints/coordinate", f"{joint}1.angle") / 2),
            done.column("joints/speed", f"{joint}1.angle") / 2,
        )
        for joint in "BA"
    )
    w = np.sqrt(1 + x * x)
    sine, cosine = x / np.sqrt(3), y * w / np.sqrt(3)
    x_rate, y_rate = (1 + x * x) * x_rate, (1 + y * y) * y_rate
    rate = (cosine * x_rate - sine * (y_rate * w + y * x * x_rate / w)) / np.sqrt(3)
    return np.unwrap(np.arctan2(sine, cosine)), rate


def test_the_invertible_cube_turns_every_second_pin_alike(bricard):
    α, β = (bricard.column("joints/coordinate", f"{joint}1.angle") for joint in "AB")
    assert_close((1 - np.sin(α)) * (1 - np.sin(β)), 1.0, 1e-11)
    for k in "23":
        assert_close(bricard.column("joints/coordinate", f"A{k}.angle"), α, 1e-11)
        assert_close(bricard.column("joints/coordinate", f"B{k}.angle"), β, 1e-11)
    assert np.ptp(bricard_coordinate(bricard)[0]) > 2 * np.pi, "it has not turned inside out and back"


def test_the_invertible_cube_is_where_its_closed_form_and_its_energy_have_it(bricard):
    linkage = Linkage(bricard, lambda u: bricard_poses(bricard, u))
    u, rate = bricard_coordinate(bricard)
    linkage.assert_poses(u, 1e-11)
    linkage.assert_velocities(u, rate, 1e-10)
    linkage.assert_accelerations(u, rate, 1e-7)
    linkage.assert_times(u, rate[0], 1e-10)
    assert bricard.report.energy_drift_relative < 1e-11


# Mechanisms that cannot move, or only in part, and whose rows depend on each other: each formulation runs them, with
# the same reactions. The bodies are given velocities that the joints do not allow, of which round-off is left.

HEAD = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 20 ms, step: 1 ms, output_step: 10 ms}
"""
MOVING = "velocity: [0.31, -0.72, 0.53], angular_velocity: [0.7, 1.1, -0.4]"
PLATE = f"plate: {{mass: 3, inertia: [0.2, 0.3, 0.4], position: [0.4, 0, 0.1], {MOVING}}}"

#: A plate in the x-z plane on two pins that it can turn about neither of.
PINNED = f"""{HEAD}
bodies:
  {PLATE}
joints:
  left: {{type: revolute, bodies: [ground, plate], location: [0, 0, 0], axis: [0, 1, 0]}}
  right: {{type: revolute, bodies: [ground, plate], location: [1, 0, 0], axis: [0, 1, 0]}}
"""
#: The same with a lamp that swings below it.
LAMP = PINNED.replace(
    "joints:",
    f"""  lamp: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.4, 0, -0.4], {MOVING}}}
joints:
  hook: {{type: revolute, bodies: [plate, lamp], location: [0.4, 0, 0.1], axis: [0, 1, 0]}}""",
)
#: Two bodies that are welded and pinned to each other as well, on a wall.
WELDED = f"""{HEAD}
bodies:
  {PLATE}
  shelf: {{mass: 1, inertia: [0.02, 0.03, 0.04], position: [0.9, 0, 0.2], {MOVING}}}
joints:
  wall: {{type: fixed, bodies: [ground, plate], location: [0, 0, 0], reaction: true}}
  weld: {{type: fixed, bodies: [plate, shelf], location: [0.7, 0, 0.1], reaction: true}}
  bolt: {{type: revolute, bodies: [plate, shelf], location: [0.8, 0, 0.1], axis: [0, 1, 0]}}
"""
#: A four-bar of spatial revolutes whose motion takes the last freedom, and begins at rest.
DRIVEN = f"""{HEAD}
bodies:
  crank: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.05, 0, 0.15], {MOVING}}}
  rod: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.4, 0, 0.4], {MOVING}}}
  rocker: {{mass: 1.5, inertia: [0.03, 0.03, 0.03], position: [0.65, 0, 0.2], {MOVING}}}
joints:
  A: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}}
  B: {{type: revolute, bodies: [crank, rod], location: [0.1, 0, 0.3], axis: [0, 1, 0]}}
  C: {{type: revolute, bodies: [rod, rocker], location: [0.7, 0, 0.5], axis: [0, 1, 0]}}
  D: {{type: revolute, bodies: [ground, rocker], location: [0.6, 0, -0.1], axis: [0, 1, 0]}}
motions:
  drive: {{joint: A, angle: {{polynomial: [0, 0, 2.5]}}}}
"""
AGAINST_EACH_OTHER = """
motions:
  one: {joint: left, angle: {polynomial: [0, 0, 2.5]}}
  other: {joint: right, angle: {polynomial: [0, 0, 1.5]}}
"""
STRUCTURES = {"pinned": (PINNED, 0), "lamp": (LAMP, 1), "welded": (WELDED, 0), "driven": (DRIVEN, 0)}


def runs(text: str) -> dict[str, Run]:
    return {each: run_text(text, formulation=each, kinematic="false") for each in ("full", "reduced", "planar")}


@pytest.mark.parametrize("name", STRUCTURES)
def test_each_formulation_runs_a_structure_with_the_same_reactions(name):
    text, freedom = STRUCTURES[name]
    full, *others = runs(text).values()
    assert full.report.degrees_of_freedom == freedom
    assert full.report.redundant_rows > 0
    for other in others:
        assert other.report.degrees_of_freedom == freedom
        for path in ("bodies/position", "bodies/acceleration", "joints/reaction_force", "joints/reaction_torque"):
            assert_close(other[path], full[path], 1e-11 * max(1.0, np.abs(full[path]).max()))
    if "motions" in text:
        assert_close(others[0]["motions/force"], full["motions/force"], 1e-11 * 100)


@pytest.mark.parametrize("name", ("pinned", "welded"))
def test_a_structure_stays_and_bears_its_weight(name):
    for done in runs(STRUCTURES[name][0]).values():
        assert_close(done["bodies/position"], done["bodies/position"][0], 1e-13)
        assert_close(done["bodies/acceleration"], 0.0, 1e-11)
    system, state = assembled(read_scene_text(STRUCTURES[name][0]))
    marks = unique_components(system, state)["joints/reaction_force_unique"]
    assert not marks.all()
    borne = [joint for joint in done.system.names.joints if joint in ("left", "right", "wall")]
    force = sum(done.column("joints/reaction_force", joint) for joint in borne)
    weight = 10.0 * sum(body.mass for body in done.scene.bodies)
    assert_close(force, [0.0, 0.0, weight], 1e-11 * weight)


@pytest.mark.parametrize("name", STRUCTURES)
def test_what_round_off_leaves_of_velocities_contradicts_nothing(name):
    """Rows that ask for accelerations of 1e-60 instead of 0 agree."""
    found = redundancy(*assembled(read_scene_text(STRUCTURES[name][0])))
    assert found.sets
    assert found.is_constant
    assert [entry.residual for entry in found.sets] == [(0.0, 0.0)] * len(found.sets)


def test_motions_that_start_from_rest_against_each_other_contradict_each_other():
    """Their accelerations differ by 5 - 3 rad/s^2, whatever round-off leaves of the velocities."""
    doubled = PINNED.replace("[1, 0, 0]", "[0, 0.5, 0]")
    found = redundancy(*assembled(read_scene_text(doubled + AGAINST_EACH_OTHER)))
    (clash,) = [entry for entry in found.sets if set(entry.motions) == {"one", "other"}]
    assert clash.residual == pytest.approx((0.0, 2.0), rel=1e-9)
    assert not found.is_constant


#: A truss of three rods on skew hinges, with 12 rows more than freedoms, and a lamp that swings below it.
TRUSS = f"""{HEAD}
parameters: {{light: 1}}
bodies:
  first: {{mass: light, inertia: [light, light, light], position: [0.1, 0.2, 0.4]}}
  second: {{mass: light, inertia: [light, light, light], position: [0.7, -0.3, 0.5]}}
  third: {{mass: light, inertia: [light, light, light], position: [-0.2, 0.6, 0.1]}}
  lamp: {{mass: 2, inertia: [0.1, 0.1, 0.15], position: [0.4, 0.8, 0.3]}}
joints:
  a: {{type: revolute, bodies: [ground, first], location: [0, 0.3, 0], axis: [1, 0.2, -0.4]}}
  b: {{type: revolute, bodies: [ground, second], location: [0.8, 0, 0.1], axis: [0.3, 1, 0.2]}}
  c: {{type: revolute, bodies: [ground, third], location: [-0.5, 0.1, 0], axis: [-0.6, 0.1, 1]}}
  d: {{type: revolute, bodies: [first, second], location: [0.4, -0.2, 0.6], axis: [0.5, -0.7, 0.1]}}
  e: {{type: revolute, bodies: [second, third], location: [0.2, 0.3, 0.7], axis: [0.1, 0.8, -0.5]}}
  f: {{type: revolute, bodies: [third, first], location: [0, 0.5, 0.3], axis: [0.9, 0.4, 0.3]}}
  hook: {{type: revolute, bodies: [third, lamp], location: [0.1, 0.7, 0.2], axis: [0.2, -0.3, 1]}}
"""


@crossed("light, formulation", ["1", "1/1000000000", "0"], ["full", "reduced"], dear=["full"])
def test_what_redundant_joints_lock_does_not_accelerate_however_light_it_is(light, formulation):
    """Round-off of the lamp's, which swings by the same law each time."""
    done = run_text(TRUSS, {"light": light}, formulation=formulation)
    lamp, heavy = done.column("bodies/acceleration", "lamp"), run_text(TRUSS, formulation=formulation)
    for rod in ("first", "second", "third"):
        assert_close(done.column("bodies/acceleration", rod), 0.0, 1e-12)
        assert_close(done.column("bodies/angular_acceleration", rod), 0.0, 1e-12)
    assert np.abs(lamp).max() > 1.0
    assert_close(lamp, heavy.column("bodies/acceleration", "lamp"), 1e-9)


# Degrees of freedom, verdict, and distance from a singular pose of mechanisms that lean, or whose numbers are rounded.
#
# `check`, `run` and the full formulation agree. `python scripts/turned_mechanisms.py` asks all shipped mechanisms.

#: A four-bar with a hinge that is tilted.
FOUR_BAR = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {{tilt: {tilt}}}
simulation: {{duration: 20 ms, step: 5 ms, formulation: {formulation}{more}}}
bodies:
  crank: {{mass: 1, inertia: [1e-3, 2e-3, 2e-3], position: [0.04, 0, 0.09]}}
  coupler: {{mass: 2, inertia: [0.02, 0.02, 0.02], position: [0.3, 0, 0.24]}}
  rocker: {{mass: 1, inertia: [6e-3, 6e-3, 1e-3], position: [0.48, 0, 0.15]}}
joints:
  A: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}}
  B: {{type: revolute, bodies: [crank, coupler], location: [0.08, 0, 0.18], axis: [0, 1, 0]}}
  C: {{type: revolute, bodies: [coupler, rocker], location: [0.52, 0, 0.3], axis: [0, 1, 0]}}
  D: {{type: revolute, bodies: [ground, rocker], location: [0.44, 0, 0], axis: [sin(tilt), cos(tilt), 0]}}
{motions}
"""


def four_bar(tilt=0.0, formulation="auto", more="", motions=""):
    return FOUR_BAR.format(tilt=tilt, formulation=formulation, more=more, motions=motions)


@pytest.mark.parametrize(
    "name, every", some([("bennett", 5), ("n_four_bar", 6), ("locomotive", 8), ("hooke_shaft", 8)], 4)
)
def test_shipped_mechanisms_do_not_depend_on_how_they_lean(name, every):
    assert list(disagreements(read_scene(mechanism(name)), every)) == []


def leaning(angle, driven):
    """The four-bar turned about an axis in its plane."""
    motions = "motions:\n  drive: {joint: A, angle: {constant_speed: 2}}" if driven else ""
    return turned(mbproj.read_scene_text(four_bar(motions=motions)), np.array([0.6, 0.0, 0.8]), angle)


@pytest.mark.parametrize(
    ("angle", "driven"), some(once([1e-9, 4e-9, 1.3e-8, 2.7e-8, 1e-7, 1e-6, 1e-4, 1e-2, 1.0], [False, True]), 3)
)
def test_a_leaning_four_bar_is_as_free_as_an_upright_one(angle, driven):
    upright, found = mbproj.check(leaning(0.0, driven)), mbproj.check(leaning(angle, driven))
    assert found.can_run
    assert found.degrees_of_freedom == upright.degrees_of_freedom == (0 if driven else 1)
    assert [entry.permanent for entry in found.diagnosis.redundancy.sets] == [True] * 3
    assert not any(entry.contradictory for entry in found.diagnosis.redundancy.sets)
    assert found.diagnosis.conditioning.distance == pytest.approx(upright.diagnosis.conditioning.distance, rel=1e-6)
    assert found.diagnosis.conditioning.distance > 0.1
    assert found.diagnosis.conditioning.scaled < 100.0
    assert mbproj.check(leaning(angle, driven), formulation="full", kinematic=False).choice.redundant == 3


@pytest.mark.parametrize(("tilt", "formulation"), once([1e-10, 1e-9, 1e-8], ["auto", "full"]))
def test_a_tilt_within_rounding_leaves_the_freedom_that_check_and_run_see(tilt, formulation):
    text = four_bar(tilt, formulation)
    assert mbproj.check(text).degrees_of_freedom == 1
    assert mbproj.check(text).diagnosis.verdict == "far from singular poses"
    assert mbproj.run(text).attributes["degrees_of_freedom"] == 1


@pytest.mark.parametrize(("tilt", "formulation"), once([3e-7, 1e-5, 3e-4], ["auto", "full"]))
def test_a_tilted_hinge_locks_with_words_in_every_formulation(tilt, formulation):
    text = four_bar(tilt, formulation)
    (problem,) = mbproj.check(text).problems
    assert "the joints lock" in problem.message and "adjust_joints" in problem.hint
    with pytest.raises(InputError, match="the joints lock"):
        mbproj.run(text)


def test_joints_that_are_adjusted_are_as_free_as_exact_ones():
    found = mbproj.check(four_bar(3e-7, more=", adjust_joints: 1 um"))
    assert found.can_run and found.degrees_of_freedom == 1
    assert all(entry.permanent and not entry.contradictory for entry in found.diagnosis.redundancy.sets)


def test_speeds_that_open_a_tilted_loop_name_the_joint_that_opens():
    text = four_bar(1e-4).replace(
        "location: [0, 0, 0], axis: [0, 1, 0]}", "location: [0, 0, 0], axis: [0, 1, 0], speed: 30}"
    )
    with pytest.raises(InputError, match=r"joint '[ABCD]' would open at \S+ rad/s"):
        mbproj.check(text)


def test_an_almost_stretched_pose_is_no_redundancy():
    """A parallelogram a little from flat: at it four rows depend on others, but three of them for good."""
    h = 1e-7
    text = f"""
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 1 ms, step: 1 ms}}
bodies:
  left: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.1, 0, {0.5 * h}]}}
  bar: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.5, 0, {h}]}}
  right: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.7, 0, {0.5 * h}]}}
joints:
  A: {{type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0]}}
  B: {{type: revolute, bodies: [left, bar], location: [0.2, 0, {h}], axis: [0, 1, 0]}}
  C: {{type: revolute, bodies: [bar, right], location: [0.8, 0, {h}], axis: [0, 1, 0]}}
  D: {{type: revolute, bodies: [ground, right], location: [0.6, 0, 0], axis: [0, 1, 0]}}
"""
    found = mbproj.check(text)
    assert [entry.permanent for entry in found.diagnosis.redundancy.sets] == [True] * 3
    assert found.diagnosis.verdict == "all but singular"
    assert 1e-9 < found.diagnosis.conditioning.distance < 1e-6
