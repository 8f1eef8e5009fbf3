"""Mechanisms that cannot move, or only in part, and whose rows depend on each other: each formulation runs them, with
the same reactions. The bodies are given velocities that the joints do not allow, of which round-off is left."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import unique_components
from mbproj.equations.rank.redundancy import redundancy
from mbproj.scene.scene import read_scene_text
from tests.crossed import crossed
from tests.dynamics.linkages import assembled
from tests.mechanisms.running import Run, assert_close, run_text

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
