"""Energy, violations, comparison and summary against numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbproj.base.errors import InputError
from mbproj.results.analysis.comparison import common_samples, trajectory_difference
from mbproj.results.analysis.summary import energy_drift, peak, summary, worst
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
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
