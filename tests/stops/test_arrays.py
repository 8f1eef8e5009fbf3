"""Stops as a scene gives them and as arrays: gaps at known poses, and what a change of the scene does to them."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, assemble, compile_system, initial_guess, read_scene_text
from mbproj.equations.kinematics import attached, pose_of, slots_of
from mbproj.scene.blocks.oversights import oversights
from mbproj.scene.fields.rotations import to_matrix, unit
from mbproj.studies.variants import RigidMotion, rescaled, with_stiffness
from mbproj.studies.verify.invariance import renumbered
from tests.stops.scenes import SCENE


def gaps(scene):
    """The system, and the gaps of its stops at the assembled start."""
    system = compile_system(scene)
    stops, state = system.stops, assemble(system, initial_guess(scene, system))
    value = stops.coordinates.value(attached(pose_of(state.q), *slots_of(stops.coordinates)))
    return system, stops.side * (value - stops.bound)


def test_gaps_at_a_known_pose():
    """The door is 40° open, the block on its slide 0.3 m up, and the plate on it with it."""
    system, gap = gaps(read_scene_text(SCENE))
    assert system.names.stops == (
        "hinge.angle.low",
        "hinge.angle.high",
        "rail.angle.low",
        "rail.displacement.high",
        "rope",
        "gap.shortest",
        "gap.longest",
        "lid",
    )
    assert system.names.stop_units == ("rad", "rad", "rad", "m", "m", "m", "m", "m")
    door = 0.5 * np.array([np.cos(np.radians(40)), np.sin(np.radians(40)), 0.0])
    apart = float(np.linalg.norm(door - [2.0, 0.0, 1.3]))
    lid = 1.3 - 0.25 - (0.3 + 0.1 + 0.05) - 0.1
    expected = [np.radians(70), np.radians(55), 7.0, 0.2, 1.3, apart - 0.1, 4.0 - apart, lid]
    np.testing.assert_allclose(gap, expected, rtol=0, atol=1e-12)


def test_laws_and_owners():
    """What is not given is no damping; a stiffness in N/mm^1.5 is 1000^1.5 times that in N/m^1.5."""
    system = compile_system(read_scene_text(SCENE, "f.yaml"))
    stops = system.stops
    soft = 2e5 * 1000.0**1.5
    np.testing.assert_allclose(stops.stiffness, [4, 4, 2, np.inf, soft, np.inf, np.inf, 7], rtol=1e-15)
    np.testing.assert_array_equal(stops.exponent, [1.5, 1.5, 1, 1, 1.5, 1, 1, 1])
    nan = np.nan
    np.testing.assert_array_equal(stops.restitution, [0.4, 0.4, nan, 0, nan, 0.5, 0.5, nan])
    np.testing.assert_array_equal(stops.damping, [nan, nan, 3, nan, 0, nan, nan, 0])
    np.testing.assert_array_equal(stops.joint_coordinate, [0, 0, 1, 2, -1, -1, -1, -1])
    assert system.names.coordinates == ("hinge.angle", "rail.angle", "rail.displacement")
    assert stops.owners[0] == "joint 'hinge'" and stops.owners[4:6] == ("force 'rope'", "force 'gap'")
    lines = SCENE.splitlines()
    for place, text in zip(
        stops.places, ["-30 deg", "95 deg", "-7", "0.5]", "5 m", "10 cm", "4,", "lid:"], strict=True
    ):
        assert lines[place.line - 1][place.column - 1 :].startswith(text)
    assert system.forces.is_empty


def test_two_ends_on_one_rigid_body_are_an_error():
    for old, new, said in (
        ("{body: ball, location: {ball: [0.25, 0, 0]}}", "{body: block, location: [2, 0, 1]}", "a plane and a point"),
        (
            "points: {ground: [2, 0, 5], ball: [2, 0, 1.3]}",
            "points: {block: [2, 0, 5], plate: [0, 0, 0]}",
            "two points",
        ),
    ):
        assert SCENE.count(old) == 1
        with pytest.raises(InputError, match=f"acts between {said} of one rigid body; fixed joints have merged its"):
            compile_system(read_scene_text(SCENE.replace(old, new)))


def test_a_stop_holds_no_body():
    """The ball, at the end of a rope, moves freely, which is noted as for a body without it."""
    notes = [note.message for note in oversights(read_scene_text(SCENE))]
    assert notes == ["no joint holds body 'ball': it moves freely"]


def test_a_scene_moved_or_numbered_otherwise_has_the_same_gaps():
    scene = read_scene_text(SCENE)
    system, gap = gaps(scene)
    turn = np.array(to_matrix(unit((0.3, -0.5, 0.2, 0.7))))
    _, moved = gaps(RigidMotion(turn, np.array([1.0, -2.0, 0.5])).scene(scene))
    np.testing.assert_allclose(moved, gap, rtol=0, atol=1e-12)
    other, found = gaps(renumbered(scene, seed=1))
    assert other.names.stops != system.names.stops
    np.testing.assert_allclose(found, [gap[system.names.stops.index(name)] for name in other.names.stops], atol=1e-12)


def test_a_scene_in_another_unit_of_length_has_the_same_stops():
    """Gaps in metres are k times as large; forces then are k times and torques k² times as large, at k times the speed
    of a gap in metres."""
    scene, k = read_scene_text(SCENE), 7.0
    system, gap = gaps(scene)
    larger, found = gaps(rescaled(scene, k))
    unit_of = np.where(np.array(system.names.stop_units) == "m", k, 1.0)
    np.testing.assert_allclose(found, unit_of * gap, rtol=1e-12)

    def force(stops, penetration, rate):
        push = stops.stiffness * penetration**stops.exponent
        return push * (1.0 + np.where(np.isnan(stops.damping), 0.0, stops.damping) * rate)

    soft = ~system.stops.is_rigid
    ratio = force(larger.stops, 0.01 * unit_of, 0.3 * unit_of)[soft] / force(system.stops, 0.01, 0.3)[soft]
    np.testing.assert_allclose(ratio, np.where(unit_of == k, k, k**2)[soft], rtol=1e-12)
    assert (larger.stops.is_rigid == ~soft).all()


def test_stops_that_give_way_count_as_stiffness():
    """A study that varies stiffness makes them stiffer, and leaves rigid ones rigid."""
    scene = read_scene_text(SCENE)
    stiffer, before = compile_system(with_stiffness(scene, 3.0)).stops, compile_system(scene).stops
    np.testing.assert_array_equal(stiffer.stiffness, 3.0 * before.stiffness)
    for kept in ("forces:", "rail:\n    type: cylindrical"):  # the joints' alone, then that of the hinge alone
        text = SCENE[: SCENE.index(kept)]
        assert compile_system(with_stiffness(read_scene_text(text), 3.0)).stops.stiffness[0] == 12.0
    with pytest.raises(InputError, match="no force of the scene has a 'stiffness' to vary"):
        with_stiffness(read_scene_text(SCENE[: SCENE.index("    limits: {angle")]), 3.0)
