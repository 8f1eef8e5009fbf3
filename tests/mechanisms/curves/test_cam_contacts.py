"""Followers that lift off their cams and land: against the closed form, in flight and on the cam."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import CAM, scene
from tests.stops.runs import run

pytestmark = needs_kernel
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
def test_what_is_refused(old, new, message):
    text = scene(CONTACT).replace(old, new)
    with pytest.raises(InputError) as caught:
        read_scene_text(text.replace("curves:\n", "curves:\n  open: {points: [[0, 0.05], [0.1, 0.06], [0.2, 0.05]]}\n"))
    assert message in str(caught.value)
