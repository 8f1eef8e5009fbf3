"""Angles are read in degrees, or in turns where there are many; what is recorded stays in radians."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.results.reader import open_results
from mbproj.show.figures.kinds import draw
from mbproj.show.figures.style import DEGREES, METRES, TURNS, units_of
from tests.figures.drawn import lines, ylabels
from tests.results.pendulum_blocks import NAMES, block, record, times


def turning(tmp_path, turns: float):
    """The pendulum whose coordinate goes round, with its results."""
    values = block(times())
    values["joints/coordinate"][:, 0] = np.linspace(0.0, 2.0 * np.pi * turns, 201)
    values["joints/speed"][:, 0] = np.pi * turns
    return open_results(record(tmp_path / "run.h5", values))


@pytest.mark.parametrize(
    ("turns", "labels", "end", "speed"),
    [
        (1.0, ["A.angle (°)", "speed (°/s)"], 360.0, 180.0),
        (10.0, ["A.angle (°)", "speed (°/s)"], 3600.0, 1800.0),
        (-300.0, ["A.angle (turns)", "speed (rpm)"], -300.0, -9000.0),
    ],
)
def test_degrees_or_turns(tmp_path, turns, labels, end, speed):
    with turning(tmp_path, turns) as results:
        figure = draw("coordinates", [results], ["run"])
        assert ylabels(figure) == labels
        assert lines(figure.axes[0])["run"][-1] == pytest.approx(end)
        assert lines(figure.axes[1])["run"][-1] == pytest.approx(speed)
        assert results["joints/coordinate"][-1, 0] == pytest.approx(2.0 * np.pi * turns)
        assert results.names("coordinate_units") == ("rad",)


@pytest.mark.parametrize(("turns", "step"), [(0.2, 15), (0.6, 45), (2.0, 180), (9.0, 720)])
def test_ticks_stand_at_parts_of_a_turn(tmp_path, turns, step):
    with turning(tmp_path, turns) as results:
        axis = draw("coordinates", [results], ["run"]).axes[0]
    assert set(np.diff(axis.get_yticks()).round(9)) == {step}


def test_lengths_stay_in_metres(tmp_path):
    names = dict(NAMES) | {"coordinate_units": ["m"], "coordinates": ["A.displacement"]}
    with open_results(record(tmp_path / "run.h5", block(times(), names), names=names)) as results:
        figure = draw("coordinates", [results], ["run"])
        assert ylabels(figure) == ["A.displacement (m)", "speed (m/s)"]
        np.testing.assert_array_equal(lines(figure.axes[0])["run"], results["joints/coordinate"][:, 0])


def test_units_are_chosen_by_what_is_finite():
    assert units_of("rad", [np.array([0.0, np.nan, np.inf])]) is DEGREES
    assert units_of("rad", [np.array([0.0]), np.array([100.0])]) is TURNS
    assert units_of("m", [np.array([1e9])]) is METRES
