"""The leg of Jansen's walking machine: the path of its foot from circles that cross."""

from __future__ import annotations

import numpy as np
import pytest

from tests.mechanisms.driven.linkages import block, crossing, pin, place, run

#: T. Jansen's "holy numbers", in his units, cm say: a to m.
a, b, c, d, e, f, g, h, i, j, k, l, m = (38, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49, 50, 61.9, 7.8, 15)
MAIN, HIP = 0.0 + 0.0j, -a - l * 1j


def leg(theta):
    """Pins of the left leg at angles of the crank: that of the crank, those of the thigh's other corners, of the knee,
    of the shank's other corner, and the foot."""
    crank = MAIN + m * np.exp(1j * theta)
    top = crossing(crank, HIP, j, b, -1)
    knee = crossing(crank, HIP, k, c, 1)
    outer = crossing(top, HIP, e, d, -1)
    ankle = crossing(outer, knee, f, g, -1)
    return crank, top, outer, knee, ankle, crossing(ankle, knee, h, i, -1)


def scene(theta):
    crank, top, outer, knee, ankle, foot = (complex(each) for each in leg(np.array(theta)))

    def body(*corners):
        return f"{{mass: 1, inertia: [1, 1, 1], position: {place(sum(corners) / len(corners))}}}"

    bodies = {
        "crank": body(MAIN, crank),
        "upper": body(crank, top),
        "lower": body(crank, knee),
        "thigh": body(top, HIP, outer),
        "shank": body(ankle, knee, foot),
        "front": body(HIP, knee),
        "back": body(outer, ankle),
    }
    joints = {
        "main": pin("ground, crank", MAIN),
        "J": pin("crank, upper", crank),
        "K": pin("crank, lower", crank),
        "top": pin("upper, thigh", top),
        "hip": pin("ground, thigh", HIP),
        "hip2": pin("ground, front", HIP),
        "knee": pin("lower, front", knee),
        "knee2": pin("front, shank", knee),
        "outer": pin("thigh, back", outer),
        "ankle": pin("back, shank", ankle),
    }
    head = "mbproj: 1\ngravity: [0, 0, 0]\nsimulation: {duration: 2 s, output_step: 5 ms, kinematic: true}\n"
    motion = "motions: {drive: {joint: main, angle: {constant_speed: 60 rpm}}}\n"
    marker = f"markers: {{foot: {{body: shank, location: {place(foot)}}}}}\n"
    return head + block("bodies", bodies) + block("joints", joints) + motion + marker


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_the_foot_goes_where_the_circles_cross(formulation):
    pytest.importorskip("mbproj.kernel._core")
    start = 0.3
    _, recorder, _ = run(scene(start), formulation=formulation)
    theta = start + 2.0 * np.pi * recorder["time"]
    expected = leg(theta)[-1]
    found = recorder["markers/position"][:, 0]
    np.testing.assert_allclose(found[:, 0] + 1j * found[:, 2], expected, rtol=0.0, atol=1e-11)


def test_its_foot_is_level_for_a_third_of_a_turn():
    _, recorder, _ = run(scene(0.3), duration="1 s", output_step="1 ms")
    along, height = recorder["markers/position"][:, 0, 0], recorder["markers/position"][:, 0, 2]
    low = height < height.min() + 0.01 * c
    assert np.ptp(along[low]) > 0.6 * np.ptp(along)
    assert low.mean() > 1.0 / 3.0
