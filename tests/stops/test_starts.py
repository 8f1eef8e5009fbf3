"""Stops as scenes give them, and where a run with them may begin."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import InputError, assemble, compile_system, initial_guess, read_scene_text
from mbproj.equations.contacts import refuse_driven_beyond
from mbproj.equations.kinematics import attached, pose_of, slots_of
from mbproj.motion.contacts import gaps_at_start, refuse_penetration
from mbproj.scene.blocks.oversights import oversights
from mbproj.scene.fields.rotations import to_matrix, unit
from mbproj.studies.variants import RigidMotion, rescaled, with_stiffness
from mbproj.studies.verify.invariance import renumbered
from tests.stops.scenes import SCENE
from tests.support import assembled

# Where a run with stops may begin: inside them, and where it may not the amount is said at the stop's line.

#: A block on a slide, driven where MOTION says so.
BLOCK = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2, step: 1 ms}
bodies:
  block: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  slide:
    type: cylindrical
    bodies: [ground, block]
    location: [0, 0, 0]
    axis: [1, 0, 0]
    START
    limits:
      displacement: {range: [-0.1, 0.25], LAW}
      angle: {range: [null, 370 deg], rigid: true}
MOTION
"""
#: A four-bar linkage whose rocker follows its crank.
FOUR_BAR = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {duration: 1, step: 1 ms}
bodies:
  crank: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0.1, 0]}
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0.2, 0]}
  rocker: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0.1, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1],
    limits: {angle: {range: CRANK, rigid: true}}}
  B: {type: revolute, bodies: [crank, rod], location: [0, 0.2, 0], axis: [0, 0, 1]}
  C: {type: revolute, bodies: [rod, rocker], location: [1, 0.2, 0], axis: [0, 0, 1]}
  D: {type: revolute, bodies: [ground, rocker], location: [1, 0, 0], axis: [0, 0, 1],
    limits: {angle: {range: ROCKER, rigid: true}}}
"""
#: A wheel under a falling body hangs on a stop, against which a spring presses it; it begins to leave it.
HANGING = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 20 ms, output_step: 10 ms, tolerance: 1e-9}
bodies:
  body: {mass: 3, inertia: [1, 1, 1], position: [0, 0, 0.953]}
  hub: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.453]}
joints:
  guide: {type: prismatic, bodies: [ground, body], location: [0, 0, 0.8], axis: z}
  strut: {type: prismatic, bodies: [body, hub], location: [0, 0, 0.453], axis: z, speed: SPEED m/s,
          limits: {displacement: {range: [0, 0.16], LAW}}}
forces:
  coil: {type: linear_spring_damper, joint: strut, stiffness: 400 N/m, free_displacement: -20 mm}
"""


def started(text, **words):
    for word, given in words.items():
        text = text.replace(word, given)
    scene = read_scene_text(text, "f.yaml")
    return *assembled(scene), scene


def block(start="", law="rigid: true", motion=""):
    return started(BLOCK, START=start, LAW=law, MOTION=motion)


def said(run):
    """The problems, each with its line."""
    with pytest.raises(InputError) as raised:
        run()
    return [str(problem).splitlines()[0] for problem in raised.value.problems]


@pytest.mark.parametrize("law", ["rigid: true", "stiffness: 1e4 N/m"])
def test_a_start_beyond_a_stop_is_an_error_with_the_amount(law):
    for at, place, stop, amount, bound in (
        (0.3, "15:36", "high", "0.05", "above the most, 0.25"),
        (-0.4, "15:30", "low", "0.3", "below the least, -0.1"),
    ):
        system, state, _ = block(f"displacement: {at}", law)
        assert said(lambda: refuse_penetration(system, state)) == [  # noqa: B023
            f"f.yaml:{place}: error: the start is beyond the stop 'slide.displacement.{stop}' by {amount} m: "
            f"at {at} m, {bound} m; start inside, or widen the range"
        ]


def test_a_start_at_a_stop_touches_it():
    """Up to round-off of typed numbers; and it may not move into a rigid one."""
    for speed, law in ((0.3, "rigid: true"), (0.0, "rigid: true"), (-2.0, "stiffness: 1e4")):
        system, state, _ = block(f"displacement: -0.1000000000001\n    speed: {{displacement: {speed}}}", law)
        refuse_penetration(system, state)
        found = gaps_at_start(system, state)
        assert [name for name, entry in found.items() if entry["touches"]] == ["slide.displacement.low"]
        assert found["slide.displacement.low"]["rate"] == pytest.approx(speed, abs=1e-15)
    system, state, _ = block("displacement: -0.1\n    speed: {displacement: -2}")
    assert said(lambda: refuse_penetration(system, state)) == [
        "f.yaml:16:30: error: the start touches the stop 'slide.displacement.low' and moves into it at 2 m/s; "
        "start before the stop, or with a speed that leads away from it"
    ]


def test_an_angle_counts_its_turns():
    """380° is beyond 370°, though -350° and 10° are not."""
    system, state, _ = block("angle: 380 deg")
    (message,) = said(lambda: refuse_penetration(system, state))
    assert "beyond the stop 'slide.angle.high' by 0.174533 rad: at 6.63225 rad, above the most, 6.45772 rad" in message
    refuse_penetration(*block("angle: 10 deg")[:2])


def test_limits_of_a_loop_that_exclude_each_other():
    """The rocker of a parallelogram turns as its crank does: one at least 10° and the other at most -5°, or inside both
    elsewhere."""
    system, state, _ = started(FOUR_BAR, CRANK="[10 deg, null]", ROCKER="[null, -5 deg]")
    found = said(lambda: refuse_penetration(system, state))
    for message, place in zip(found, ("11:30", "15:36"), strict=True):
        assert message.startswith(
            f"f.yaml:{place}: error: the limits 'A.angle.low' and 'D.angle.high' exclude each other"
        )
    amounts = [float(word) for word in found[0].split("beyond by ")[1].replace(" rad", "").split(";")[0].split(" and ")]
    np.testing.assert_allclose(sum(amounts), np.radians(15.0), rtol=0.02)
    system, state, _ = started(FOUR_BAR, CRANK="[10 deg, null]", ROCKER="[null, 15 deg]")
    (message,) = said(lambda: refuse_penetration(system, state))
    assert "beyond the stop 'A.angle.low' by 0.174533 rad" in message


def test_a_motion_beyond_a_rigid_stop_of_its_coordinate_is_found_before_the_run():
    """x = 0.3 sin(π t) passes 0.25 at asin(5/6)/π; a stop that gives way is pushed, not an error."""
    motion = "motions: {push: {joint: slide, displacement: 0.3*sin(pi*t)}}"
    system, state, _ = block(motion=motion)
    refuse_driven_beyond(system, state.t, 0.3)
    assert said(lambda: refuse_driven_beyond(system, state.t, 0.9)) == [
        f"f.yaml:15:36: error: motion 'push' drives slide.displacement beyond this rigid stop from t = "
        f"{np.arcsin(5 / 6) / np.pi:.6g} s on, by up to 0.05 m; end the motion inside, widen the range, or let the "
        "stop give way with 'stiffness'"
    ]
    low, high = said(lambda: refuse_driven_beyond(system, state.t, 2.0))
    assert "by up to 0.2 m" in low and f"t = {1 + np.arcsin(1 / 3) / np.pi:.6g} s" in low
    assert "by up to 0.05 m" in high
    soft, _, _ = block(law="stiffness: 10", motion=motion)
    refuse_driven_beyond(soft, 0.0, 2.0)
    touching, _, _ = block(motion="motions: {push: {joint: slide, displacement: 0.25*sin(t)**2 }}")
    refuse_driven_beyond(touching, 0.0, 20.0)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["full", "auto"])
@pytest.mark.parametrize("law", ["rigid: true, restitution: 0.5", "stiffness: 1e4 N/m, restitution: 0.5"])
@pytest.mark.parametrize("speed", [1e-9, 1e-12])
def test_what_leaves_a_stop_by_less_than_gaps_are_known_to_stays(speed, law, formulation):
    """The spring pushes with 8 N: the gap would open by 5e-20 m for 2e-10 s, and coordinates are known to 1e-16 m."""
    results = mbproj.run(HANGING.replace("SPEED", str(speed)).replace("LAW", law), formulation=formulation)
    assert [(event.time, event.kind) for event in results.events] == [(0.0, "contact")]
    gap = results.stop("strut.displacement.low").gap
    assert np.abs(gap).max() < 1e-12 if "rigid" in law else -1.6e-3 < gap[-1] < -1e-4


# Stops as a scene gives them and as arrays: gaps at known poses, and what a change of the scene does to them.


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
