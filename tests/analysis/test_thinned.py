"""A line of very many points looks the same without most of them."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from mbproj.results.analysis.tables import COLUMNS, MANY, thinned
from mbproj.show.figures.panels import thin

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
