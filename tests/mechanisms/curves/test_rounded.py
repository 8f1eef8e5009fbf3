"""Points of a cam that were rounded: `check` says by how much accelerations are uncertain, and is silent of others."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import read_scene_text
from mbproj.scene.blocks.oversights import grain, notes_on
from tests.mechanisms.curves.scenes import CAM, scene


def notes(count, digits, key="table"):
    """Those on a cycloidal cam of 20 mm lift, by points of so many digits in m."""
    angle = 2.0 * np.pi * np.arange(count) / count
    x = np.minimum(angle, 2.0 * np.pi - angle) / np.pi
    radius = 0.05 + 0.02 * (x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi))
    rows = [(each, round(r, digits)) for each, r in zip(angle.tolist(), radius.tolist(), strict=True)]
    rows = [*rows, (2.0 * np.pi, rows[0][1])]
    if key == "points":
        rows = [(round(r * np.cos(a), digits), round(r * np.sin(a), digits)) for a, r in rows[:-1]]
    curve = f"  drawn: {{{key}: {[[float(a), float(b)] for a, b in rows]}{', closed: true' * (key == 'points')}}}\n"
    text = scene(CAM.replace("LAW", "cycloidal")).replace("curves:\n", f"curves:\n{curve}")
    return [note.message for note in notes_on(read_scene_text(text)) if "rounded" in note.message]


@pytest.mark.parametrize("key", ["table", "points"])
def test_a_table_rounded_to_a_micrometre(key):
    """12 r (N/2π)² with r = 0.5 µm and N = 720: 70.9 m/s² at 30 rad/s."""
    (message,) = notes(720, 6, key)
    assert "curve 'drawn' are rounded to 1 µm: accelerations are uncertain by 0.079 m times the square" in message
    assert 12.0 * 0.5e-6 * (720 / (2.0 * np.pi)) ** 2 * 30.0**2 == pytest.approx(70.9, rel=1e-3)


@pytest.mark.parametrize(("count", "digits"), [(36, 6), (720, 10), (12, 3)])
def test_points_that_do_no_harm_have_no_note(count, digits):
    """Few points, points with all their digits, and those that a designer has drawn."""
    assert notes(count, digits) == []


def test_half_of_the_last_digit():
    assert grain([0.25, 0.1]) == pytest.approx(0.005)
    assert grain([1.0 / 3.0]) == 0.0
    assert grain([0.05, 0.012345]) == pytest.approx(0.5e-6)
