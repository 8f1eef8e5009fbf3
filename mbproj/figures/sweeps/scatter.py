"""All varied quantities and measures over each other: a matrix of scatter plots, with histograms on its diagonal."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.figures.style import line, page_width, styled
from mbproj.figures.sweeps.chosen import Cases, Chosen
from mbproj.figures.sweeps.distribution import FILL, bars
from mbproj.figures.sweeps.marks import crosses
from mbproj.figures.sweeps.scales import few_ticks, name
from mbproj.results.sweep.table import Column

#: The most quantities in the matrix, and the most points in one panel.
MOST, POINTS = 7, 4000


def why_not(chosen: Chosen) -> str | None:
    """The reason why no scatter plot can be drawn; None where one can. A point needs two coordinates."""
    return None if len(chosen.numbers) + len(chosen.measures) > 1 and chosen.numbers else "no number varies"


@styled
def draw(chosen: Chosen) -> Figure:
    """Draw the lower triangle. Failed cases are crosses where both coordinates are known."""
    columns = [*chosen.numbers, *chosen.measures]
    said = f"{MOST} of {len(columns)} quantities: choose with --over and --of" if len(columns) > MOST else ""
    measures = chosen.measures[: MOST - 1]
    columns = [*chosen.numbers[: MOST - len(measures)], *measures]
    size, count = page_width() / len(columns), len(columns)
    figure = Figure(figsize=(page_width(), count * min(size, 1.6) + 0.4), layout="constrained")
    axes = figure.subplots(count, count, squeeze=False, sharex="col")
    values = [chosen.scaled(column)[1][chosen.independent] for column in columns]
    failed = chosen.table.failed[chosen.independent]
    drawn = _thinned(len(failed))
    for row, column in np.ndindex(count, count):
        axis = axes[row, column]
        if column > row:
            axis.set_visible(False)
        elif column == row:
            _alone(axis, values[row])
        else:
            _pair(axis, values[column], values[row], failed, drawn)
        few_ticks(axis, 2 if count > 4 else 4, 3)
        axis.tick_params(labelsize=6.5)
    for axis in axes.diagonal():
        axis.set_yticks([])
    _name(axes, columns, size)
    thin = f"every {drawn.step}th case" if drawn.step and drawn.step > 1 else ""
    return panels.finish(figure, remark=chosen.remark(said, thin), with_legend=bool(failed.any()))


def _thinned(count: int) -> slice:
    return slice(None, None, -(-count // POINTS) or 1)


def _alone(axis: Axes, values: Array) -> None:
    known = values[np.isfinite(values)]
    if len(known) > 1 and np.ptp(known) > 0.0:
        axis.hist(known, bins=min(bars(known), 20), color=FILL, edgecolor="#FFFFFF", linewidth=0.3)
    axis.grid(visible=False)


def _pair(axis: Axes, x: Array, y: Array, failed: Cases, drawn: slice) -> None:
    dots = {"linestyle": "none", "marker": "o", "markersize": 1.6, "markeredgewidth": 0.0, "alpha": 0.6}
    good = ~failed
    axis.plot(x[good][drawn], y[good][drawn], **{**line(0), **dots})
    known = failed & np.isfinite(x) & np.isfinite(y)
    crosses(axis, x[known], y[known])
    axis.margins(0.06)


def _name(axes: Array, columns: list[Column], size: float) -> None:
    for number, column in enumerate(columns):
        axes[-1, number].set_xlabel(name(column, size - 0.2), fontsize=7.5)
        axes[number, 0].set_ylabel(name(column, min(size, 1.6) - 0.1), fontsize=7.5)
        if number:
            for inner in axes[number, 1:number]:
                inner.set_yticklabels([])
