"""Where a run with stops may begin: inside them, and where it may not the amount is said at the stop's line."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import InputError, assemble, compile_system, initial_guess, read_scene_text
from mbproj.equations.contacts import refuse_driven_beyond
from mbproj.motion.contacts import gaps_at_start, refuse_penetration

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
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system)), scene


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
