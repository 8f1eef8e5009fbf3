"""Quick-return mechanisms: the ratio of the times of both strokes in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from tests.mechanisms.driven.linkages import block, run

PERIOD = 1.0


def scene(crank: float, offset: float) -> str:
    """A crank of this length about (0, offset) whose pin slides in the slot of a lever about the origin."""
    bodies = {
        "crank": f"{{mass: 1, inertia: [1e-3, 1e-3, 1e-3], position: [{0.5 * crank}, 0, {offset}]}}",
        "lever": f"{{mass: 2, inertia: [0.04, 0.04, 0.04], position: [{0.5 * crank}, 0, {0.5 * offset}]}}",
    }
    joints = {
        "pivot": "{type: revolute, bodies: [ground, lever], location: [0, 0, 0], axis: [0, -1, 0]}",
        "main": f"{{type: revolute, bodies: [ground, crank], location: [0, 0, {offset}], axis: [0, -1, 0]}}",
        "slot": f"{{type: point_on_line, bodies: [lever, crank], location: [{crank}, 0, {offset}], "
        f"axis: [{crank}, 0, {offset}]}}",
    }
    head = "mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {duration: 2 s, output_step: 1 ms, kinematic: true}\n"
    motion = f"motions: {{drive: {{joint: main, angle: {{constant_speed: {2.0 * np.pi / PERIOD!r}}}}}}}\n"
    return head + block("bodies", bodies) + block("joints", joints) + motion


def turns(time, values):
    """When a smooth curve crosses zero: on the polynomial through six samples around each change of its sign."""
    found = []
    for k in np.flatnonzero(np.sign(values[2:-4]) * np.sign(values[3:-3]) < 0) + 2:
        near = slice(k - 2, k + 4)
        x, lagrange = values[near], 0.0
        for i in range(6):  # t as a polynomial of the value, at 0
            others = np.delete(x, i)
            lagrange += time[near][i] * np.prod(others / (others - x[i]))
        found.append(lagrange)
    return np.array(found)


@pytest.mark.parametrize(("crank", "offset"), [(0.1, 0.2), (0.06, 0.25)])
def test_a_crank_shaper_cuts_slowly_and_returns_fast(crank, offset):
    """The lever turns back where it is across the crank: (π + 2 α) / (π - 2 α) with sin α = r/d."""
    _, recorder, _ = run(scene(crank, offset))
    times = turns(recorder["time"], recorder["joints/speed"][:, 0])
    assert len(times) == 4
    strokes = np.diff(times)
    alpha = np.arcsin(crank / offset)
    expected = (np.pi + 2.0 * alpha) / (np.pi - 2.0 * alpha)
    assert max(strokes[0], strokes[1]) / min(strokes[0], strokes[1]) == pytest.approx(expected, rel=1e-9)
    assert strokes[0] + strokes[1] == pytest.approx(PERIOD, abs=1e-10)
    lever = recorder["joints/coordinate"][:, 0]
    assert np.ptp(lever) == pytest.approx(2.0 * alpha, abs=1e-5)


@pytest.mark.parametrize(("crank", "offset"), [(0.2, 0.08), (0.1, 0.06)])
def test_a_whitworth_lever_turns_right_round_with_unequal_halves(crank, offset):
    """The lever is level where the crank's pin is at its pivot's height: 2 (π - φ) and 2 φ with cos φ = d/r."""
    _, recorder, _ = run(scene(crank, offset))
    start = np.arctan2(offset, crank)  # of the lever, from level
    half = np.unwrap(recorder["joints/coordinate"][:, 0]) + start
    times = turns(recorder["time"], np.sin(half))
    strokes = np.diff(times[:3])
    phi = np.arccos(offset / crank)
    assert max(strokes) / min(strokes) == pytest.approx((np.pi - phi) / phi, rel=1e-9)
    assert np.ptp(half) == pytest.approx(4.0 * np.pi, abs=1e-9)
