"""Energy, violations, comparison and summary against numbers worked out by hand; lines without most of their points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from mbproj.base.errors import InputError
from mbproj.results.analysis.comparison import common_samples, trajectory_difference
from mbproj.results.analysis.summary import energy_drift, peak, summary, worst
from mbproj.results.analysis.tables import COLUMNS, MANY, thinned
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from mbproj.show.figures.panels import thin
from tests.results.pendulum_blocks import AMPLITUDE, GRAVITY, LENGTH, MASS, NAMES, NO_NAMES, block, record, scene, times


def test_energy_drift_is_over_the_energy_exchanged():
    drift = energy_drift(np.array([0.0, -3.0, 2.0]), np.array([0.0, 4.0, 1.0]), np.array([7.0, 5.0, 1.0]))
    assert (drift.absolute, drift.relative) == (3.0, 0.3)


def test_energy_drift_of_rest_and_of_nan():
    rest = np.zeros(3)
    assert energy_drift(rest, rest, rest + 9.0).relative == 0.0
    assert energy_drift(rest + 1e-9, rest, rest).relative == math.inf
    assert math.isnan(energy_drift(np.array([0.0, math.nan]), rest[:2], rest[:2]).absolute)


def test_peaks():
    time, values = np.array([0.0, 0.5, 1.0]), np.array([[1.0, 2.0], [5.0, 0.0], [4.0, 5.0]])
    found = worst(time, values, ["A", "B"])
    assert (found.value, found.time, found.name) == (5.0, 0.5, "A")
    assert peak(time, values[:, 1], "B").time == 1.0
    assert worst(time, values[:, :0], []) is None
    values[1, 1] = math.nan
    assert worst(time, values, ["A", "B"]).name == "B"


def test_common_samples_of_two_output_steps():
    coarse, fine = np.cumsum(np.full(100, 0.01)), np.arange(401) * 0.0025
    first, second = common_samples(coarse, fine)
    assert np.array_equal(first, np.arange(100))
    assert np.array_equal(second, 4 * np.arange(1, 101))
    back = common_samples(fine, coarse)
    assert np.array_equal(back[0], second)
    assert np.array_equal(back[1], first)


def test_common_samples_where_there_are_none():
    assert len(common_samples(np.arange(5.0), np.arange(5.0) + 0.3)[0]) == 0
    assert len(common_samples(np.zeros(0), np.arange(5.0))[0]) == 0
    assert len(common_samples(np.array([1.0]), np.array([1.0]))[0]) == 1


@given(st.sets(st.integers(0, 60), min_size=2), st.sets(st.integers(0, 60), min_size=2))
def test_common_samples_are_the_intersection(first, second):
    one, two = (np.array(sorted(numbers)) * 0.1 for numbers in (first, second))
    rows = common_samples(one, two + 1e-12)
    assert [round(time / 0.1) for time in one[rows[0]]] == sorted(first & second)
    assert [round(time / 0.1) for time in two[rows[1]]] == sorted(first & second)


def test_difference_of_two_trajectories(tmp_path):
    slow = block(times(101, 0.02))
    slow["markers/position"] = slow["markers/position"] + 1e-3 * slow["time"][:, None, None] * np.array([0.6, 0.0, 0.8])
    with open_results(record(tmp_path / "a.h5")) as first, open_results(record(tmp_path / "b.h5", slow)) as second:
        difference = trajectory_difference(first, second, "Mitte")
        assert np.allclose(difference.time, times(101, 0.02), atol=1e-15)
        assert np.allclose(difference.distance, 1e-3 * difference.time, atol=1e-15)
        assert difference.largest == pytest.approx(2e-3, abs=1e-14)
        with pytest.raises(InputError, match="no marker 'end'"):
            trajectory_difference(first, second, "end")


def test_the_largest_distance_is_not_a_number_where_a_path_is_none(tmp_path):
    broken = block(times())
    broken["markers/position"][120:] = np.nan
    with open_results(record(tmp_path / "a.h5")) as first, open_results(record(tmp_path / "b.h5", broken)) as second:
        assert np.isnan(trajectory_difference(first, second, "tip").largest)


def test_no_time_in_common(tmp_path):
    with (
        open_results(record(tmp_path / "a.h5")) as first,
        open_results(record(tmp_path / "b.h5", block(times() + 0.003))) as second,
        pytest.raises(InputError) as caught,
    ):
        trajectory_difference(first, second, "tip")
    assert str(caught.value) == (
        f"error: '{first.path}' and '{second.path}' have no sample time in common; run both with the same --output-step"
    )


def test_summary_of_the_pendulum(tmp_path):
    with open_results(record(tmp_path / "a.h5")) as results:
        found = summary(results)
    swing = MASS * GRAVITY * LENGTH * (1 - math.cos(AMPLITUDE))
    assert found["energy_drift"] == pytest.approx(2e-6)
    # The small swing of the block exchanges ½ m (l φ₀ ω)² for m g l (1 - cos φ₀).
    assert found["energy_drift_relative"] == pytest.approx(1e-6 / swing, rel=5e-3)
    assert (found["steps"], found["projection_iterations"], found["samples"], found["end"]) == (200, 400, 201, 2.0)
    assert (found["worst_joint"], found["position_violation_max"]) == ("A", pytest.approx(2e-15, rel=1e-4))
    assert found["worst_angle"]["value"] == pytest.approx(found["worst_length"]["value"] / 3)
    assert found["velocity_violation_max"] == 4 * found["position_violation_max"]


def test_summary_without_joints_and_without_samples(tmp_path):
    with open_results(record(tmp_path / "a.h5", block(times(9), NO_NAMES), names=NO_NAMES)) as results:
        found = summary(results)
        assert (found["worst_joint"], found["worst_length"], found["joints"]) == (None, None, 0)
    with ResultsWriter(tmp_path / "b.h5", scene(), NAMES):
        pass
    with open_results(tmp_path / "b.h5") as results:
        assert summary(results)["samples"] == 0
        assert "energy_drift" not in summary(results)


# A line of very many points looks the same without most of them.

COUNT = 300_000
TIME = np.linspace(0.0, 10.0, COUNT)
NOISE = np.random.default_rng(5).normal(size=COUNT)
#: Where samples are that come with ever longer steps.
LOGARITHMIC = np.geomspace(1e-6, 10.0, COUNT)


@pytest.mark.parametrize("x", [TIME, LOGARITHMIC], ids=["even", "ever longer"])
@pytest.mark.parametrize("y", [np.sin(300.0 * TIME), NOISE, np.cumsum(NOISE)], ids=["fast", "noise", "walk"])
def test_in_each_column_a_line_goes_from_where_it_went_to_where_it_went(x, y) -> None:
    """Its first, lowest, highest and last value there are its own."""
    at, value = thinned(x, y)
    assert len(at) <= 4 * (COLUMNS + 1)
    assert (np.diff(at) >= 0.0).all()
    width = (x[-1] - x[0]) / COLUMNS
    for column in range(0, COLUMNS, 97):
        inside, shown = (values[((t - x[0]) / width).astype(int) == column] for t, values in ((x, y), (at, value)))
        if len(inside):
            assert (shown[0], shown.min(), shown.max(), shown[-1]) == (
                inside[0],
                inside.min(),
                inside.max(),
                inside[-1],
            )


def test_a_gap_stays_a_gap() -> None:
    y = np.where((TIME > 4.0) & (TIME < 4.5), np.nan, TIME)
    at, value = thinned(TIME, y)
    gap = np.isnan(value)
    assert at[gap].min() == pytest.approx(4.0, abs=2e-3)
    assert at[gap].max() == pytest.approx(4.5, abs=3e-3)


def test_what_goes_round_and_round_is_drawn_once() -> None:
    """Twenty times round a circle: all of it is there, at no more than a dot's distance."""
    angle = 2.0 * np.pi * 20.3 * TIME / TIME[-1]
    x, y = thinned(np.cos(angle), np.sin(angle))
    drawn = np.isfinite(x)
    assert len(x) < 0.2 * COUNT
    assert x[0] == 1.0
    assert np.diff(np.sort(np.arctan2(y[drawn], x[drawn]))).max() < 4.0 / COLUMNS
    apart = np.hypot(np.diff(x), np.diff(y))
    assert np.nanmax(apart) < 8.0 / COLUMNS  # no line across the circle


def test_where_nothing_is_finite_a_path_is_empty() -> None:
    nothing = np.full(MANY, np.nan)
    assert np.isnan(thinned(nothing, nothing)[0]).all()


def test_few_points_stay_as_they_are() -> None:
    figure = Figure()
    axis = figure.subplots()
    axis.plot(TIME[: MANY - 1], NOISE[: MANY - 1])
    axis.plot(TIME, NOISE)
    before = axis.dataLim.bounds
    thin(figure)
    few, many = (np.asarray(line.get_ydata()) for line in axis.lines)
    assert np.array_equal(few, NOISE[: MANY - 1])
    assert len(many) < len(NOISE) / 10
    axis.relim()
    assert axis.dataLim.bounds == before
