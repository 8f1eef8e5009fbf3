"""Two curves that touch: where, in pictures too, and where they overlap."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import InputError, SimulationError, compile_system, initial_guess, read_scene_text
from mbproj.base.mechanisms_folder import mechanism
from mbproj.equations.curve_checks import overlapping
from mbproj.equations.kinematics import pose_of
from mbproj.results.analysis.expectations import datasets
from mbproj.show.figures import kinds
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import DISC, DISCS, FLAT, ROLLER, SLOT, TOUCH, WIRE, scene
from tests.stops.runs import run

pytestmark = needs_kernel


# Two curves that touch: discs and a rod, a cam and its roller, involutes and a gear, contacts, messages.


@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_two_discs_are_a_rod_between_their_middles(formulation):
    time = (0.03, "10 ms") if formulation == "full" else (0.4, "20 ms")
    _, found = run(scene(DISCS.replace("JOINT", TOUCH), formulation, *time))
    start = float(np.hypot(0.0, 0.13))
    rod = DISCS.replace("JOINT", f"type: distance, bodies: [shaft, arm], length: {start!r}")
    _, expected = run(scene(rod, formulation, *time))
    np.testing.assert_allclose(found["joints/coordinate"][:, :2], expected["joints/coordinate"][:, :2], atol=1e-11)
    np.testing.assert_allclose(
        found["joints/reaction_force"][:, 2], expected["joints/reaction_force"][:, 2], rtol=1e-9, atol=1e-9
    )
    # the line of their middles makes the same angle with both discs, but for how these have turned
    turned = found["joints/coordinate"][:, 2] / 0.04 - found["joints/coordinate"][:, 3] / 0.09
    difference = turned - turned[0] - (found["joints/coordinate"][:, 1] - found["joints/coordinate"][:, 0])
    np.testing.assert_allclose(np.cos(difference), 1.0, atol=1e-12)


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_disc_on_a_cam_is_its_roller(formulation):
    """The way of the roller's centre is that of the disc's; the knots of the law are located as those of the cam."""
    (_, expected), (_, found) = (run(scene(each, formulation, 0.2, "4 ms")) for each in (ROLLER, DISC))
    # at the start, where the curve begins and ends
    one, other = found["joints/coordinate"][1:, :3], expected["joints/coordinate"][1:, :3]
    np.testing.assert_allclose(one, other, atol=1e-14)
    np.testing.assert_allclose(
        found["joints/reaction_force"][:, 2], expected["joints/reaction_force"][:, 2], rtol=1e-9, atol=1e-9
    )
    torque = expected["motions/force"]
    np.testing.assert_allclose(found["motions/force"], torque, atol=1e-11 * np.abs(torque).max())
    assert len(found.of("knot of its curve")) == len(expected.of("knot of its curve")) > 2


#: Two teeth: base circles of 40 and 60 mm at a distance of 110 mm.
FIRST, SECOND, APART = 0.04, 0.06, 0.11
TEETH = """
curves:
  flank: {involute: {base: 40 mm, from: 5 deg, to: 60 deg}}
  other: {involute: {base: 60 mm, from: 3 deg, to: 45 deg}}
bodies:
  pinion: {mass: 1, inertia: [0.01, 0.01, 0.001], position: [0, 0, 0], orientation: {axis: [0, 0, 1], angle: FIRST rad}}
  wheel: {mass: 2, inertia: [0.01, 0.01, 0.004], position: [0.11, 0, 0],
          orientation: {axis: [0, 0, 1], angle: SECOND rad}}
joints:
  A: {type: revolute, bodies: [ground, pinion], location: [0, 0, 0], axis: [0, 0, 1], speed: 1 rad/s}
  B: {type: revolute, bodies: [ground, wheel], location: [0.11, 0, 0], axis: [0, 0, 1]}
  K:
    {type: curve_on_curve, bodies: [pinion, wheel], curves: [flank, other], sides: [right, right],
     locations: {pinion: [0, 0, 0], wheel: [0, 0, 0]}, axis: {pinion: [0, 0, 1], wheel: [0, 0, 1]},
     x_axis: {pinion: [1, 0, 0], wheel: [1, 0, 0]},
     limits: {displacement_1: {range: [0, 21 mm], rigid: true}, displacement_2: {range: [0, 18 mm], rigid: true}}}
forces: {load: {type: torsion_spring_damper, joint: B, torque: 3}}
"""


def teeth():
    """The scene where the pinion's tooth is unrolled by 0.3 rad."""
    α, s = np.arccos((FIRST + SECOND) / APART), 0.3
    other = (APART * np.sin(α) - FIRST * s) / SECOND
    return TEETH.replace("FIRST", repr(float(α - s))).replace("SECOND", repr(float(α + np.pi - other)))


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_involutes_keep_their_ratio(formulation):
    """The angles are as the base circles; the teeth push along the line of action by torque over base radius."""
    _, found = run(scene(teeth(), formulation, 0.04, "5 ms"))
    first, second = found["joints/coordinate"][:, :2].T
    assert abs(first[-1]) > 0.1
    np.testing.assert_allclose(second, -first * FIRST / SECOND, atol=1e-14)
    # one degree of freedom: I φ'' = torque reduced to the pinion
    inertia = 0.001 + 0.004 * (FIRST / SECOND) ** 2
    expected = found["time"] - 0.5 * 3.0 * FIRST / SECOND / inertia * found["time"] ** 2
    np.testing.assert_allclose(first, expected, atol=1e-12)
    force = np.linalg.norm(found["joints/reaction_force"][:, 2], axis=-1)
    np.testing.assert_allclose(force, 0.001 * 3.0 * FIRST / SECOND / inertia / FIRST, rtol=1e-10)


LIFTS = "type: curve_contact, limits: {gap: {range: [0, null], rigid: true, restitution: 0}}"


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_disc_lifts_off_a_cam_as_a_roller_does(formulation):
    """At 110 rad/s it flies from the falling flank: the events and the motion are those of the cam contact."""
    fast = [each.replace("30 rad/s", "110 rad/s") for each in (ROLLER, DISC)]
    roller, disc = fast[0].replace("type: cam", LIFTS), fast[1].replace("type: curve_on_curve", LIFTS)
    roller = roller.replace("curve_contact", "cam_contact")
    (_, expected), (_, found) = (run(scene(each, formulation, 0.08, "1 ms")) for each in (roller, disc))
    for kind in ("release", "contact"):
        times = [[event.time for event in each.of(kind)] for each in (found, expected)]
        assert len(times[0]) == len(times[1]) >= 1
        np.testing.assert_allclose(*times, atol=1e-9)
    np.testing.assert_allclose(found["stops/gap"], expected["stops/gap"], atol=1e-9)


def test_a_ball_in_a_bowl_swings_as_in_its_circle():
    """A disc of 30 mm inside a ring of 100 mm, without friction: a pendulum of 70 mm."""
    text = """
curves: {ring: {circle: 100 mm}, disc: {circle: 30 mm}}
bodies:
  ball: {mass: 1, inertia: [0.001, 0.001, 0.001], position: [0.07, 0, 0]}
joints:
  P: {type: planar, bodies: [ground, ball], location: [0.07, 0, 0], axis: [0, -1, 0]}
  K: {type: curve_on_curve, bodies: [ground, ball], curves: [ring, disc], sides: [inside, outside],
      locations: [[0, 0, 0], [0.07, 0, 0]], axis: [0, -1, 0], x_axis: [0, 0, 1]}
"""
    _, found = run(scene(text, "planar", 0.3, "10 ms"))
    x, z = found["bodies/position"][:, 0, 0], found["bodies/position"][:, 0, 2]
    np.testing.assert_allclose(np.hypot(x, z), 0.07, atol=1e-14)
    speed2 = (found["bodies/velocity"][:, 0] ** 2).sum(axis=-1)
    np.testing.assert_allclose(speed2, -2.0 * 9.81 * z, atol=1e-10)
    force = np.linalg.norm(found["joints/reaction_force"][:, 1], axis=-1)
    np.testing.assert_allclose(force, 3.0 * 9.81 * -z / 0.07, atol=1e-8)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("sides: [right, right],", "", "curve 'flank' is open: say on which side of it the other curve is"),
        ("sides: [right, right]", "sides: [right, outside]", "curve 'other' is open"),
        ("sides: [right, right]", "sides: [left, left]", "curve 'flank' is hollow at"),
        ("displacement_1: {range: [0, 21 mm]", "displacement_1: {range: [0, 2100 mm]", "may leave curve 'flank'"),
        (", displacement_2: {range: [0, 18 mm], rigid: true}", "", "may leave curve 'other', which ends"),
        ("from: 5 deg", "from: -5 deg", "has a cusp, or ends before it begins"),
        ("curves: [flank, other]", "curves: [flank]", "2 names of curves"),
    ],
)
def test_what_is_refused(old, new, message):
    assert old in teeth()
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(teeth().replace(old, new)))
    assert message in str(caught.value)


# Where joints touch their curves: between centres, under rollers and faces, at pins; and expectations of it.

EXPECT = "expect: {there: {joint: K, quantity: contact, component: norm, at: end, below: 10 m, source: test}}\n"


def touched(text, formulation="auto"):
    """The places of the first joint that follows a curve, and the run."""
    _, found = run(scene(text, formulation, 0.06, "10 ms"))
    return found["curves/contact"][:, 0], found


def test_discs_touch_on_the_line_of_their_middles():
    place, found = touched(DISCS.replace("JOINT", TOUCH))
    angle = -found["joints/coordinate"][:, :2]
    zero = np.zeros_like(angle[:, 0])
    first = 0.015 * np.stack([np.sin(angle[:, 0]), zero, np.cos(angle[:, 0])], axis=-1)
    arm = np.array([-0.3, 0.0, 0.015])
    cosine, sine = np.cos(angle[:, 1]), np.sin(angle[:, 1])
    second = np.stack([0.3 + arm[0] * cosine + arm[2] * sine, zero, 0.13 - arm[0] * sine + arm[2] * cosine], axis=-1)
    line = second - first
    between = first + 0.04 * line / np.linalg.norm(line, axis=-1)[:, None]
    np.testing.assert_allclose(place, between, atol=1e-12)


def test_a_roller_touches_below_its_middle():
    """At its radius from the middle, against the force."""
    place, found = touched(ROLLER)
    middle = np.array([0.0, 0.0, 0.05]) + found["joints/coordinate"][:, 1, None] * np.array([0.0, 0.0, 1.0])
    force = found["joints/reaction_force"][:, 2]
    np.testing.assert_allclose(place, middle - 0.012 * force / np.linalg.norm(force, axis=-1)[:, None], atol=1e-12)


def test_a_face_is_touched_beside_its_point():
    place, found = touched(FLAT.replace("LAW", "cycloidal").replace("SPEED", "30"))
    np.testing.assert_allclose(place[:, 2], 0.05 + found["joints/coordinate"][:, 1], atol=1e-13)
    np.testing.assert_allclose(place[:, 0], 0.013 - found["joints/coordinate"][:, 2], atol=1e-13)


@pytest.mark.parametrize("text", [SLOT, WIRE])
def test_a_slot_is_touched_at_its_pin(text):
    place, found = touched(text)
    np.testing.assert_allclose(place, found["bodies/position"][:, 1], atol=1e-13)


def test_an_expectation_may_be_about_it():
    given = read_scene_text(scene(ROLLER + EXPECT)).expectations[0]
    assert datasets(given, ()) == ("curves/contact",)
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(ROLLER + EXPECT.replace("joint: K", "joint: A")))
    assert "joint 'A' is revolute and has no 'contact'" in str(caught.value)


# Curves that touch and overlap elsewhere: lobes on lobes, where the next pair meets.

ANGLES = 2.0 * np.pi * np.arange(64) / 64
RADII = 0.1 + 0.004 * np.cos(8.0 * ANGLES)
POINTS = [[float(r * np.cos(a)), float(r * np.sin(a))] for r, a in zip(RADII, ANGLES, strict=True)]
#: Two wheels of eight lobes each.
LOBES = f"""
curves: {{lobes: {{points: {POINTS}, closed: true}}, others: {{points: {POINTS}, closed: true}}}}
bodies:
  a: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}}
  b: {{mass: 2, inertia: [0.08, 0.08, 0.08], position: [0, 0, 0.2035], orientation: {{axis: [0, -1, 0], angle: TURN}}}}
joints:
  A: {{type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, -1, 0]}}
  B: {{type: revolute, bodies: [ground, b], location: [0, 0, 0.2035], axis: [0, -1, 0]}}
  T: {{type: curve_on_curve, bodies: [a, b], curves: [lobes, others], sides: [outside, outside],
      locations: {{a: [0, 0, 0], b: [0, 0, 0]}}, axis: {{a: [0, -1, 0], b: [0, -1, 0]}},
      x_axis: {{a: [1, 0, 0], b: [1, 0, 0]}}}}
"""


@pytest.mark.parametrize(("turn", "overlaps"), [(0.2, True), (0.3, False), (0.4, False), (0.6, True)])
def test_poses_that_overlap(turn, overlaps):
    """A hollow before a lobe leaves them apart; a turn by a quarter of a pitch makes them meet."""
    parsed = read_scene_text(scene(LOBES.replace("TURN", f"{turn}")))
    system = compile_system(parsed)
    found = overlapping(system, pose_of(initial_guess(parsed, system).q))
    assert found == ("T" if overlaps else None)


#: A flat bar that lies on a wheel of eight lobes, and is lifted by it.
BAR = f"""
curves: {{lobes: {{points: {POINTS}, closed: true}}, bar: {{ellipse: [0.15, 0.02]}}}}
bodies:
  wheel: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}}
  bar: {{mass: 2, inertia: [0.08, 0.08, 0.08], position: [0, 0, 0.124]}}
joints:
  A: {{type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, -1, 0]}}
  B: {{type: prismatic, bodies: [ground, bar], location: [0, 0, 0.124], axis: z}}
  T: {{type: curve_on_curve, bodies: [wheel, bar], curves: [lobes, bar], sides: [outside, outside],
      locations: [[0, 0, 0], [0, 0, 0.124]], axis: [0, -1, 0], x_axis: [1, 0, 0]}}
motions: {{spin: {{joint: A, angle: {{expression: SPEED*t}}}}}}
"""


@pytest.mark.parametrize(("formulation", "speed"), [("planar", 1.0), ("reduced", -1.0), full("full", 6.0)])
def test_a_run_stops_where_the_next_lobe_meets_the_bar(formulation, speed):
    """At half a pitch two lobes bear the bar; beyond, the one that bore it at first would draw the other into it."""
    with pytest.raises(SimulationError, match="joint 'T': its curves overlap away from where they touch") as caught:
        run(scene(BAR.replace("SPEED", f"{speed}"), formulation, 1.0, "0.1 s"))
    assert 1.0 < caught.value.time * abs(speed) / (np.pi / 8.0) < 1.25


# The picture of the places where curves are touched: one panel in a plane, three in space, each path as recorded.


@pytest.mark.parametrize(
    ("text", "formulation", "axes"),
    [
        (FLAT.replace("LAW", "cycloidal").replace("SPEED", "30"), "planar", [(0, 2)]),
        (WIRE, "reduced", [(0, 1), (0, 2), (1, 2)]),
    ],
)
def test_each_place_of_contact_has_its_path(text, formulation, axes):
    results = mbproj.run(mbproj.read_scene_text(scene(text, formulation, 0.1, "5 ms")))
    figure = kinds.draw("contacts", [results], ["run"])
    path = results["curves/contact"][:, 0]
    assert len(figure.axes) == len(axes)
    for axis, (first, second) in zip(figure.axes, axes, strict=True):
        np.testing.assert_array_equal(axis.lines[0].get_xdata(), path[:, first])
        np.testing.assert_array_equal(axis.lines[0].get_ydata(), path[:, second])
        assert axis.get_xlabel() == f"{'xyz'[first]} (m)"


def test_without_curves_there_is_no_such_picture():
    results = mbproj.run(mechanism("five_bar"), duration=0.01)
    assert kinds.why_not("contacts", [results]) == "the results have no joints that follow curves"
