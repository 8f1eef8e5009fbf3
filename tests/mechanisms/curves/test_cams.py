"""Followers on cams, by rollers and by flat faces: the law, the torque, lift-off and landing."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import CAM, FLAT, scene
from tests.stops.runs import run

pytestmark = needs_kernel


# Flat faces on cams: the law comes back, its torque, lift-off and landing, and what is refused.

BASE, LIFT, RISE, DWELL = 0.05, 0.02, np.radians(120.0), np.radians(60.0)


def law(angle, of="cycloidal"):
    """s, s' and s'' by the angle; the cam turns by the law from its beginning."""
    angle = np.mod(angle, 2.0 * np.pi)
    falls = angle >= RISE + DWELL
    u = np.where(falls, angle - RISE - DWELL, angle) / RISE
    if of == "cycloidal":
        y = [u - np.sin(2 * np.pi * u) / (2 * np.pi), 1 - np.cos(2 * np.pi * u), 2 * np.pi * np.sin(2 * np.pi * u)]
    else:
        y = [
            10 * u**3 - 15 * u**4 + 6 * u**5,
            30 * u**2 - 60 * u**3 + 30 * u**4,
            60 * u - 180 * u**2 + 120 * u**3,
        ]
    moves = u <= 1.0
    s = np.where(moves, y[0], 1.0)
    s = LIFT * np.where(falls, 1.0 - s, s)
    sign = np.where(falls, -1.0, 1.0)
    return s, np.where(moves, sign * LIFT * y[1] / RISE, 0.0), np.where(moves, sign * LIFT * y[2] / RISE**2, 0.0)


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
@pytest.mark.parametrize("of", ["cycloidal", "polynomial_345"])
def test_a_flat_follower_moves_by_its_law_and_takes_its_torque(of, formulation):
    """The profile is that of the law: so s, its force and the torque F s' are those of the law; and the face is touched
    s' beside the axis."""
    time = (0.02, "5 ms") if formulation == "full" else (0.2, "4 ms")
    text = scene(FLAT.replace("LAW", of).replace("SPEED", "30"), formulation, *time)
    _, found = run(text)
    s, slope, bend = law(30.0 * found["time"], of)
    lift, place = found["joints/coordinate"][:, 1], found["joints/coordinate"][:, 2]
    np.testing.assert_allclose(lift, s, atol=1e-14)
    np.testing.assert_allclose(place, 0.013 - slope, atol=1e-13)
    force = 0.5 * (bend * 900.0 + 9.81) + 2000.0 * (s + 0.005)
    np.testing.assert_allclose(found["joints/reaction_force"][:, 2, 2], force, rtol=1e-11)
    torque = found["motions/force"][:, 0]
    np.testing.assert_allclose(torque, force * slope, atol=1e-12 * np.abs(force * slope).max())


LIFTS = FLAT.replace("flat_follower,", "flat_contact, limits: {gap: {range: [0, null], rigid: true, restitution: 0}},")


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_face_lifts_off_and_lands(formulation):
    """It leaves where the force of the held one changes its sign, flies on its spring, and lands on its law."""
    fast, ω = 110.0, np.sqrt(2000.0 / 0.5)
    text = scene(LIFTS.replace("LAW", "cycloidal").replace("SPEED", f"{fast}"), formulation, 0.1, "1 ms")
    _, found = run(text)
    release = found.of("release")[0].time
    angle = fast * release
    s, slope, bend = law(angle)
    assert abs(0.5 * (bend * fast**2 + 9.81) + 2000.0 * (s + 0.005)) <= 1e-8 * 0.5 * abs(bend) * fast**2
    touch = next(event.time for event in found.of("contact") if event.time > release)
    rest = -0.005 - 9.81 / ω**2
    flown = rest + (s - rest) * np.cos(ω * (touch - release)) + slope * fast / ω * np.sin(ω * (touch - release))
    assert abs(flown - law(fast * touch)[0]) <= 1e-12
    gap = found["stops/gap"][:, 0]
    in_flight = (found["time"] > release) & (found["time"] < touch)
    assert gap[in_flight].min() > 0.0
    assert np.abs(gap[found["time"] < release]).max() <= 1e-14


def test_a_face_on_an_ellipse_is_as_high_as_its_support():
    """h = √(a² cos² + b² sin²), and the contact is h' beside the axis."""
    text = (
        FLAT.partition("curves:")[0]
        + "curves: {lift: {ellipse: [50 mm, 30 mm]}}\nbodies:"
        + FLAT.partition("bodies:")[2]
    )
    _, found = run(scene(text.replace("SPEED", "30"), "planar", 0.2, "10 ms"))
    angle = -30.0 * found["time"]
    h = np.sqrt((0.05 * np.cos(angle)) ** 2 + (0.03 * np.sin(angle)) ** 2)
    np.testing.assert_allclose(found["joints/coordinate"][:, 1], h - 0.05, atol=1e-15)
    slope = (0.03**2 - 0.05**2) * np.cos(angle) * np.sin(angle) / h
    place = found["joints/coordinate"][:, 2]
    np.testing.assert_allclose(place - place[0], slope, atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_friction_of_the_guide_turns_where_the_cam_turns_the_follower(angle):
    """An eccentric of 6 mm, h = 6 mm cos θ: at both dead centres the rows of contact and friction are one, and the
    follower does not stick, for the cam moves it on. The motion is that of the joint that holds both ways."""
    head = FLAT.partition("bodies:")[2].partition("motions:")[0]
    below, falls = float(0.006 * np.cos(np.radians(angle))), float(-0.12 * np.sin(np.radians(angle)))
    text = "\ncurves: {disc: {circle: 25 mm}}\nbodies:" + head.replace("curve: lift", "curve: disc")
    text = text.replace("axis: [0, -1, 0]}", f"axis: [0, -1, 0], angle: {angle} deg, speed: 20 rad/s}}", 1)
    text = text.replace("[[0, 0, 0], [0.013, 0, 0.05]]", "[[0, 0, 0.006], [0, 0, 0.031]]")
    text = text.replace(
        "axis: [0, 0, 1]}", f"axis: [0, 0, 1], displacement: {below - 0.006!r} m, speed: {falls!r}}}", 1
    )
    text = text.replace("0.445 m", "0.48 m") + "  rubs: {type: friction, joint: P, coulomb: {force: 4 N}}\n"
    lifts = text.replace("flat_follower,", "flat_contact, limits: {gap: {range: [0, null], rigid: true}},")
    (_, held), (_, pressed) = (run(scene(each, "planar", 0.5)) for each in (text, lifts))
    np.testing.assert_allclose(pressed["joints/coordinate"][:, :2], held["joints/coordinate"][:, :2], atol=1e-9)
    np.testing.assert_allclose(pressed["friction/dissipation"], held["friction/dissipation"], rtol=1e-9)
    moved = np.abs(np.diff(held["joints/coordinate"][:, 1])).sum()
    assert 0.9 * 4.0 * moved < held["friction/dissipation"][-1, 0] < 1.1 * 4.0 * moved
    assert len(pressed.of("turn")) == len(held.of("turn")) >= 3
    assert not pressed.of("stick")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("base: 50 mm", "base: 5 mm", "is undercut at"),
        ("flat: true", "roller: 8 mm", "curve 'lift' was made for a roller, not for a flat face"),
        ("curve: lift,", "curve: bean,", "curve 'bean' is not convex at"),
        ("curve: lift,", "curve: open,", "curve 'open' is open: a flat face may pass its end"),
        ("normal: [0, 0, 1]", "normal: [0, 0.1, 1]", "the face leans by 5.71 deg out of the plane of the curve"),
        ("normal: [0, 0, 1]", "normal: {valve: [0, 0, 1]}", "the normal is not given as the axis is"),
        (", normal: [0, 0, 1]", "", "missing key 'normal'"),
        ("drive: {joint: A, angle: {constant_speed: SPEED rad/s}", "drive: {joint: K, gap: 1 mm", "acts along a gap"),
    ],
)
def test_what_is_refused(old, new, message):
    text = LIFTS.replace("LAW", "cycloidal").replace(old, new).replace("SPEED", "30")
    bean = "bean: {points: [[0.05, 0], [0, 0.05], [-0.05, 0], [0, -0.01]], closed: true}"
    text = text.replace("curves:\n", f"curves:\n  {bean}\n  open: {{points: [[0, 0.05], [0.1, 0.06], [0.2, 0.05]]}}\n")
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(text))
    assert message in str(caught.value)


# Followers that lift off their cams and land: against the closed form, in flight and on the cam.

#: 1.2 times the speed at which the roller of CAM first loses its cam, in rad/s.
FAST = 100.793695699
#: Of the closed form: where it lifts off and touches again, in rad from the beginning of the rise. Its own angles are
#: 150 deg larger. The impulse with which it lands, in N s.
OTHER_START = np.radians(150.0)
LIFT_OFF, TOUCH, IMPULSE = 3.897575112113 - OTHER_START, 5.10001224446 - OTHER_START, 0.392332956126
CONTACT = (
    CAM.replace("LAW", "cycloidal")
    .replace("type: cam,", "type: cam_contact, limits: {gap: {range: [0, null], rigid: true, restitution: 0}},")
    .replace("x_axis: [1, 0, 0]", "x_axis: [0, 0, 1]")
    .replace("0.06]", "0.05]")
    .replace("roller: 12 mm}", "roller: 12 mm, clockwise: true}")
    .replace("30 rad/s", f"{FAST} rad/s")
)


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_follower_lifts_off_and_lands(formulation):
    """At 1.2 times the critical speed, without bounce: times to 1e-9 s, and the impulse with which it lands."""
    _, found = run(scene(CONTACT, formulation, 0.03, "1 ms"))
    (release,) = found.of("release")
    _, touch = found.of("contact")
    assert abs(release.time - LIFT_OFF / FAST) <= 1e-11
    assert abs(touch.time - TOUCH / FAST) <= 1e-11
    gap = found["stops/gap"][:, 0]
    in_flight = (found["time"] > release.time) & (found["time"] < touch.time)
    assert np.abs(gap[~in_flight]).max() <= 1e-14
    assert gap[in_flight].min() > 0.0
    (impact,) = found.of("impact")
    np.testing.assert_allclose(found.unbalanced, 0.0, atol=1e-8)
    assert impact.time == touch.time
    np.testing.assert_allclose(impact.impulse, IMPULSE, rtol=1e-9)


def test_a_slow_follower_stays_on_its_cam():
    """There the contact presses as the closed form of the joint that holds both ways says."""
    slow = CONTACT.replace(f"{FAST} rad/s", "30 rad/s")
    held = slow.replace("cam_contact, limits: {gap: {range: [0, null], rigid: true, restitution: 0}},", "cam,")
    (_, stop), (_, joint) = run(scene(slow, "planar", 0.2)), run(scene(held, "planar", 0.2))
    assert not stop.of("release")
    push = np.linalg.norm(joint["joints/reaction_force"][:, 2], axis=1)
    np.testing.assert_allclose(stop["stops/force"][:, 0], push, rtol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "range: [0, null]",
            "range: [null, 1 mm]",
            "nothing keeps joint 'K' from passing through its curve; give limits",
        ),
        (
            "limits: {gap: {range: [0, null], rigid: true, restitution: 0}},",
            "",
            "nothing keeps joint 'K' from passing through its curve",
        ),
        ("curve: lift,", "curve: lift, roller: 60 mm, side: inside,", "does not fit curve 'lift'"),
        ("curve: lift,", "curve: open, side: left,", "curve 'open' is open: what lifts off may pass its end"),
        (
            "drive: {joint: A, angle: {constant_speed: 100.793695699 rad/s}",
            "drive: {joint: K, gap: 1",
            "acts along a gap",
        ),
    ],
)
def test_what_is_refused_of_lift_off(old, new, message):
    text = scene(CONTACT).replace(old, new)
    with pytest.raises(InputError) as caught:
        read_scene_text(text.replace("curves:\n", "curves:\n  open: {points: [[0, 0.05], [0.1, 0.06], [0.2, 0.05]]}\n"))
    assert message in str(caught.value)
