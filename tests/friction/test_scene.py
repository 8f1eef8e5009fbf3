"""Dry friction as scenes write it, at joints and on planes, as arrays, and what changes of the scene do to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from mbproj import InputError, assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.functions.series import constant_series, run
from mbproj.model.planar.reduction import obstacle_in_plane, planar_reduction
from mbproj.scene.blocks.friction import KEYS, friction_units
from mbproj.scene.fields.rotations import to_matrix, unit
from mbproj.scene.scene import SceneText
from mbproj.scene.schema import scene_schema
from mbproj.studies.variants import RigidMotion, rescaled, with_damping, with_speed
from mbproj.studies.verify.invariance import renumbered
from tests.friction.scenes import EVERY_FRICTION
from tests.scene.scenes import errors
from tests.stops.runs import Recorded
from tests.support import assembled


@pytest.fixture(scope="module")
def system():
    return compile_system(read_scene_text(EVERY_FRICTION, "f.yaml"))


def test_what_can_stick(system):
    """What is regularised is a law; the numbers of coordinates and bearings are the system's."""
    dry, names = system.frictions, system.names
    assert names.frictions == ("bearing", "brake", "sleeve.displacement", "thread", "collar")
    assert names.friction_units == ("rad", "rad", "m", "rad", "rad")
    on = [names.coordinates[at] for at in dry.joint_coordinate]
    assert on == ["A.angle", "A.angle", "C.displacement", "S.angle", "S.angle"]
    np.testing.assert_array_equal(dry.sliding, [0.2, 4, 2, 0.1, 0.3])
    np.testing.assert_array_equal(dry.static, [0.3, 5, 2.5, 0.1, 0.3])
    np.testing.assert_array_equal(dry.stribeck, [0, 0.05, 0, 0, 0])
    np.testing.assert_array_equal(dry.bearing, [0, -1, -1, 2, 3])
    assert dry.owners[1] == "force 'brake'" and dry.owners[2] == "force 'sleeve'"
    lines = EVERY_FRICTION.splitlines()
    begins = ["coulomb:", "coulomb: {torque", "displacement: {", "coulomb: {coefficient", "angle: {coefficient"]
    for place, text in zip(dry.places, begins, strict=True):
        assert lines[place.line - 1][place.column - 1 :].startswith(text)


def test_bearings(system):
    """Arms in m on angles, parts of the force on displacements; a screw's thread is pressed by the axial force."""
    bearings = system.bearings
    assert [system.names.joints[at] for at in bearings.joint] == ["A", "D", "S", "S"]
    np.testing.assert_allclose(bearings.radial, [0.01, 1, 0, 0.006], rtol=1e-15)
    np.testing.assert_allclose(bearings.axial, [0.008, 0, 0.006, 0.009], rtol=1e-15)
    np.testing.assert_array_equal(bearings.length, [0.03, np.inf, np.inf, np.inf])
    np.testing.assert_allclose(bearings.preload, [0.05, 2000, 0.06, 0], rtol=1e-15)
    # The plate sits on the disc, whose axes are global at the start; block and nut have their own.
    np.testing.assert_allclose(bearings.axis, [[0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, 1]], atol=1e-15)


def test_what_is_regularised_is_a_law(system):
    laws = system.forces.laws
    assert system.names.forces == ("guide", "sleeve.angle")
    np.testing.assert_array_equal(laws.damping, [3, 0.5])
    np.testing.assert_array_equal(laws.bearing, [1, -1])
    assert laws.loses.tolist() == [True, True]
    s = np.linspace(-7.0, 7.0, 29)
    at = [constant_series(x) for x in (np.zeros_like(s), np.zeros_like(s), s)]
    guide, sleeve = (run(system.forces.programs, int(program), at)[0] for program in laws.program)
    np.testing.assert_allclose(guide, -0.1 * np.tanh(s / 1e-3), rtol=1e-15)
    np.testing.assert_allclose(sleeve, -(1 + np.exp(-((s / 3) ** 2))) * np.tanh(s / 0.1), rtol=1e-14)


def test_dry_friction_that_sticks_is_no_law():
    scene = read_scene_text(EVERY_FRICTION)
    dry = tuple(force for force in scene.forces if force.name in ("bearing", "brake", "thread"))
    system = compile_system(replace(scene, forces=dry))
    assert system.forces.is_empty and system.names.forces == () and system.frictions.size == 3
    none = compile_system(replace(scene, forces=()))
    assert none.frictions is None and none.bearings is None and none.names.frictions == ()


FOUR_BAR = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  crank: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.5]}
  rod: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 1]}
  rocker: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0.5]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [crank, rod], location: [0, 0, 1], axis: [0, 1, 0]}
  C: {type: cylindrical, bodies: [rod, rocker], location: [2, 0, 1], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [ground, rocker], location: [2, 0, 0], axis: [0, 1, 0]}
forces:
  pin: {type: friction, joint: C, coulomb: {FRICTION}}
"""


def test_friction_across_the_plane_makes_a_mechanism_spatial():
    """The pin cannot slide along its axis, and the planar formulation has no such coordinate."""
    obstacles = []
    for text in ("angle: {torque: 1}", "displacement: {force: 1}"):
        scene = read_scene_text(FOUR_BAR.replace("FRICTION", text))
        system = compile_system(scene)
        plane = planar_reduction(system, assemble(system, initial_guess(scene, system)).q)
        obstacles.append(obstacle_in_plane(system, plane))
    assert obstacles == [None, "force 'pin' acts along a coordinate out of the plane"]


# What a change of the scene, of its unit of length or of its order does to dry friction.


def carried(bearings, force, torque):
    """The loads of bearings whose joints exert a force and a torque (3,) in the axes of body 2."""
    z = bearings.axis
    axial = z @ force
    bent = np.cross(torque, z) / bearings.length[:, None]
    ends = [np.linalg.norm(0.5 * (force - axial[:, None] * z) + sign * bent, axis=1) for sign in (1, -1)]
    return bearings.preload + bearings.radial * sum(ends) + bearings.axial * np.abs(axial)


def held(system, force, torque):
    """The largest force or torque that each friction holds."""
    dry, load = system.frictions, carried(system.bearings, force, torque)
    return dry.static * np.where(dry.bearing < 0, 1.0, load[dry.bearing])


def slid(system, s):
    """What the regularised frictions give at these rates, without the load of a bearing."""
    programs, at = system.forces.programs, [constant_series(x) for x in (0.0 * s, 0.0 * s, s)]
    return [run(programs, int(program), at)[0] for program in system.forces.laws.program]


def test_a_scene_in_another_unit_of_length_has_the_same_friction():
    """Forces are k times, torques k² times as large where the joints bear so much more, at k times the speed in m/s."""
    scene, k = read_scene_text(EVERY_FRICTION), 7.0
    system, larger = compile_system(scene), compile_system(rescaled(scene, k))
    force, torque = np.array([3.0, -4.0, 5.0]), np.array([0.2, 0.3, -0.1])
    of = np.where(np.array(system.names.friction_units) == "m", k, k**2)
    ratio = held(larger, k * force, k**2 * torque) / held(system, force, torque)
    np.testing.assert_allclose(ratio, of, rtol=1e-12)
    np.testing.assert_array_equal(larger.frictions.stribeck, system.frictions.stribeck)  # all of them in rad/s
    s = np.linspace(-0.01, 0.01, 7)
    np.testing.assert_allclose(slid(larger, s)[1], k**2 * slid(system, s)[1], rtol=1e-12)
    np.testing.assert_allclose(slid(larger, k * s)[0], slid(system, s)[0], rtol=1e-12)  # a coefficient of the load


def test_a_scene_moved_or_numbered_otherwise_has_the_same_friction():
    scene = read_scene_text(EVERY_FRICTION)
    system = compile_system(scene)
    turn = np.array(to_matrix(unit((0.3, -0.5, 0.2, 0.7))))
    moved = compile_system(RigidMotion(turn, np.array([1.0, -2.0, 0.5])).scene(scene))
    np.testing.assert_allclose(moved.bearings.axis, system.bearings.axis, atol=1e-12)
    other = compile_system(renumbered(scene, seed=2))
    assert other.names.frictions != system.names.frictions
    at = [system.names.frictions.index(name) for name in other.names.frictions]
    for name in ("sliding", "static", "stribeck"):
        np.testing.assert_array_equal(getattr(other.frictions, name), getattr(system.frictions, name)[at])
    force, torque = np.array([3.0, -4.0, 5.0]), np.array([0.2, 0.3, -0.1])
    np.testing.assert_allclose(held(other, force, torque), held(system, force, torque)[at], rtol=1e-14)


def test_a_study_changes_any_value_of_it():
    """By its path or by a parameter that it names, from the text that was read once; wrong ones have their place."""
    text = SceneText(EVERY_FRICTION, "f.yaml")

    def dry(**changes):
        frictions = compile_system(text.scene(changes)).frictions
        return frictions.sliding[1], frictions.static[1], frictions.stribeck[1]

    assert dry() == (4.0, 5.0, 0.05)
    assert dry(grip="4500 N*mm") == (4.5, 5.0, 0.05)
    assert dry(**{"forces.brake.coulomb.torque": 3.0}) == (3.0, 5.0, 0.05)
    assert dry(**{"forces.brake.coulomb.static": "2 * grip", "grip": 2.5}) == (2.5, 5.0, 0.05)
    assert dry(**{"forces.brake.coulomb.stribeck_speed": "1 rpm"})[2] == pytest.approx(np.pi / 30)
    assert dry() == (4.0, 5.0, 0.05)
    with pytest.raises(InputError, match=r"'static' must be at least the 'torque', 6 N\*m, found 5"):
        dry(grip=6.0)
    units = text.units()
    wanted = {"torque": "N*m", "static": "N*m", "stribeck_speed": "rad/s"}
    assert {key: units["forces", "brake", "coulomb", key] for key in wanted} == wanted
    assert (
        units["forces", "bearing", "coulomb", "static"] == "" and units["forces", "guide", "coulomb", "preload"] == "N"
    )


def test_a_study_of_damping_leaves_dry_friction_as_it_is():
    scene = read_scene_text(EVERY_FRICTION)
    before, after = compile_system(scene), compile_system(with_damping(scene, 3.0))
    np.testing.assert_array_equal(after.forces.laws.damping, 3.0 * before.forces.laws.damping)
    np.testing.assert_array_equal(after.frictions.static, before.frictions.static)


PIN = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {rod: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}
forces: {k: {type: friction, joint: A, coulomb: {"""
SIZES = st.floats(0.0, 1e6)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(SIZES, SIZES, st.floats(1e-6, 1e3), st.floats(1e-6, 1e3))
def test_regularised_friction_never_drives_nor_passes_its_bounds(sliding, static, speed, width):
    """At any rate it takes energy, is not more than what holds, and tends to what slides; where less holds than slides
    the reader says so, and where as much does that there is nothing from which friction could fall."""
    text = f"{PIN}torque: {sliding!r}, static: {static!r}, stribeck_speed: {speed!r}, regularised: {width!r}}}}}}}\n"
    if static <= sliding:
        with pytest.raises(InputError, match=r"'static' must be at least|'stribeck_speed' does nothing"):
            read_scene_text(text)
        return
    s = np.concatenate([[0.0], *(np.outer([1e-3, 0.1, 1.0, 40.0], [-of, of]).ravel() for of in (speed, width))])
    (found,) = slid(compile_system(read_scene_text(text)), s)
    assert (found * s <= 0.0).all() and found[0] == 0.0
    assert np.abs(found).max() <= static * (1.0 + 1e-15)
    far = 40.0 * max(speed, width) * np.array([-1.0, 1.0])
    (last,) = slid(compile_system(read_scene_text(text)), far)
    np.testing.assert_allclose(last, -np.sign(far) * sliding, rtol=1e-14)


# Whatever is written as dry friction: it compiles to numbers that make sense, or the reader says where it is wrong.

VALIDATOR = Draft202012Validator(scene_schema())
TYPES = {"A": "revolute", "D": "prismatic", "C": "cylindrical", "S": "screw, pitch: 1", "P": "planar"}
PLACE = "location: [0, 0, 0], axis: [0, 0, 1]"
BODIES = [f"  {name}-body: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\n" for name in TYPES]
JOINTS = [f"  {name}: {{type: {kind}, bodies: [ground, {name}-body], {PLACE}}}\n" for name, kind in TYPES.items()]
HEAD = f"mbproj: 1\ngravity: [0, 0, 0]\nbodies:\n{''.join(BODIES)}joints:\n{''.join(JOINTS)}forces:\n"
LINE = HEAD.count("\n") + 1
USUAL = ["0.1", "2", "3"]
ODD = ["0", "-1", "3 N", "3 N*m", "1 rad/s", "1 m/s", "2 mm", "1e99", "[1]", "{}", "x", ""]
#: What is right, and what may come to it or stand instead.
PLAIN = [{"torque": "2"}, {"force": "2"}, {"coefficient": "2"}, {"coefficient": "2", "radius": "1"}, {}]
MORE = st.one_of(
    st.just({}),
    st.dictionaries(st.sampled_from(["static", "stribeck_speed", "preload", "axial_radius"]), st.sampled_from(USUAL)),
    st.dictionaries(st.sampled_from([*KEYS, "radios"]), st.sampled_from(USUAL + ODD), max_size=2),
)


def flow(items):
    return "{" + ", ".join(f"{key}: {value}" for key, value in items.items()) + "}"


DRY = st.tuples(st.sampled_from(PLAIN), MORE).map(lambda both: flow(both[0] | both[1]))
BY_NAME = st.dictionaries(st.sampled_from(["angle", "displacement", "displacement_x"]), DRY, min_size=1).map(flow)


@settings(derandomize=True, deadline=None, max_examples=150)
@given(st.sampled_from("ADCSP"), DRY | BY_NAME, st.sampled_from(["", ", coefficient: 3"]))
@example("A", "{torque: 3, static: 4}", "")
@example("S", "{angle: {coefficient: 0.1, radius: 2}, displacement: {force: 3}}", "")
@example("D", "{coefficient: 0.1, bearing_length: 2, preload: 3, regularised: 2}", ", coefficient: 3")
def test_it_compiles_or_has_its_place(joint, dry, viscous):
    text = f"{HEAD}  k: {{type: friction, joint: {joint}, coulomb: {dry}{viscous}}}\n"
    try:
        scene = read_scene_text(text, "f.yaml")
    except InputError as error:
        assert all(problem.place is not None and problem.place.line == LINE for problem in error.problems)
        return
    assert VALIDATOR.is_valid(yaml.load(text, Loader=yaml.BaseLoader))
    system = compile_system(scene)
    (force,) = scene.forces
    assert set(system.names.frictions) | set(system.names.forces) == (
        {"k"} if len(force.coordinates) == 1 else {f"k.{name}" for name in force.coordinates}
    )
    if system.frictions is not None:
        found = system.frictions
        assert ((found.static >= found.sliding) & (found.sliding >= 0.0) & (found.stribeck >= 0.0)).all()
        assert ((found.stribeck == 0.0) | (found.static > found.sliding)).all()
    if system.bearings is not None:
        loads = system.bearings
        assert (np.maximum(loads.radial, loads.axial) > 0.0).all() and (loads.preload >= 0.0).all()
        assert (np.isinf(loads.length) | (loads.radial > 0.0)).all()
        np.testing.assert_array_equal(loads.axis, np.tile([0.0, 0.0, 1.0], (loads.size, 1)))


def test_a_coordinate_that_is_driven_may_have_friction():
    """The drive pays for it. Two brakes may be on one shaft."""
    force = "{type: friction, joint: A, coulomb: {torque: 3}}"
    scene = read_scene_text(f"{HEAD}  k: {force}\n  l: {force}\nmotions:\n  m: {{joint: A, angle: 2 * t}}\n")
    assert compile_system(scene).frictions.joint_coordinate.tolist() == [0, 0]


# Friction of points on planes as scenes write it and studies change it.

#: A puck that slides down a slope and comes to rest, and a pad on a disc, which turns beside it.
SCENE = """\
mbproj: 1
gravity: [3, 0, -9]
parameters: {rough: 0.5}
simulation: {duration: 1.5, tolerance: 1e-10, integrator: dop853, output_step: 0.1}
bodies:
  puck: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0], velocity: [0, 1, 0]}
  disc: {mass: 1, inertia: [1, 1, 1], position: [5, 0, 0]}
joints: {A: {type: revolute, bodies: [ground, disc], location: [5, 0, 0], axis: [0, 0, 1], speed: 2}}
forces:
  floor:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: puck, location: {puck: [0, 0, 0]}}
    rigid: true
    friction: {coefficient: rough, static: 1.2 * rough, stribeck_speed: 0.4}
  wall:
    type: stop
    plane: {body: ground, location: [9, 0, 0], normal: [-1, 0, 0]}
    point: {body: puck, location: {puck: [0, 0, 0]}}
    rigid: true
    friction: 0.1
  pad: {type: friction, joint: A, coulomb: {torque: 1}}
markers: {puck: {body: puck, location: {puck: [0, 0, 0]}}}
"""
NAMES = {"pad": "rad", **dict.fromkeys(("floor.1", "floor.2", "wall.1", "wall.2"), "m")}


def ran(scene):
    """What a run of a scene records."""
    recorded = Recorded()
    simulate(*assembled(scene), settings_to_run(scene), recorded)
    return recorded


@pytest.fixture(scope="module")
def scene():
    return read_scene_text(SCENE)


@pytest.fixture(scope="module")
def known(scene):
    return ran(scene)


def test_names_and_units_are_those_of_the_arrays(scene):
    names = compile_system(scene).names
    assert dict(zip(names.frictions, names.friction_units, strict=True)) == NAMES
    by_name = [{item.name: item for item in items} for items in (scene.joints, scene.forces)]
    assert friction_units(*by_name) == NAMES


def test_expectations_are_of_either_tangent():
    expected = SCENE + "expect: {e: {friction: NAME, quantity: force, at: end, value: 1 N, absolute: 1, source: x}}\n"
    (found,) = read_scene_text(expected.replace("NAME", "floor.2")).expectations
    assert (found.item, found.unit) == ("floor.2", "N")
    (message,) = errors(expected.replace("NAME", "floor"))
    assert message == "f.yaml:24:24: error: unknown dry friction 'floor'; did you mean 'floor.2'?"


def test_a_study_changes_any_value_of_a_plane():
    """By its path, in short and at length, or by a parameter."""
    text = SceneText(SCENE, "f.yaml")

    def static(**changes):
        return compile_system(text.scene(changes)).frictions.static[[1, 3]].tolist()

    assert static() == [0.6, 0.1]
    assert static(rough=1.0) == [1.2, 0.1]
    assert static(**{"forces.floor.friction.static": 0.8, "forces.wall.friction": "rough / 2"}) == [0.8, 0.25]
    units = text.units()
    assert units["forces", "floor", "friction", "stribeck_speed"] == "m/s" and units["forces", "wall", "friction"] == ""


def test_in_another_unit_of_length_it_moves_alike(scene, known):
    k = 7.0
    larger = ran(rescaled(scene, k))
    assert known["friction/state"][0, 2] == 1.0 and (known["friction/state"][-1, 1:3] == 0.0).all()
    np.testing.assert_allclose(larger["bodies/position"], k * known["bodies/position"], atol=k * 1e-9)
    np.testing.assert_allclose(larger["friction/dissipation"], k**2 * known["friction/dissipation"], atol=k**2 * 1e-8)


def test_turned_it_moves_alike(scene, known):
    """Both tangents are then others: what they lose together is the same."""
    turn, by = np.array(to_matrix(unit((0.3, -0.5, 0.2, 0.7)))), np.array([1.0, -2.0, 0.5])
    moved = ran(RigidMotion(turn, by).scene(scene))
    np.testing.assert_allclose(moved["bodies/position"], known["bodies/position"] @ turn.T + by, atol=1e-8)
    lost = [found["friction/dissipation"][:, 1:3].sum(axis=1) for found in (moved, known)]
    np.testing.assert_allclose(*lost, atol=1e-8)
    assert lost[0][-1] > 1.0


def test_a_faster_scene_has_the_same_friction(scene):
    before, after = compile_system(scene).frictions, compile_system(with_speed(scene, 2.0)).frictions
    for name in ("static", "sliding", "stribeck"):
        np.testing.assert_array_equal(getattr(before, name), getattr(after, name))
