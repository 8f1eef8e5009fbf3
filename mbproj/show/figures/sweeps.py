"""Measures over two quantities of a grid: heat maps with contours."""

from __future__ import annotations

from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.figures.margins import put_legend, small_print
from mbproj.figures.style import AXIS_HEIGHT, label_size, page_width, styled
from mbproj.figures.sweeps.chosen import Cases, Chosen, middle_of_others
from mbproj.figures.sweeps.marks import crosses
from mbproj.figures.sweeps.scales import few_ticks, name, spread_out
from mbproj.results.sweep.table import GRID, Column

#: The height of a single map, and of two side by side, inches.
WIDE, NARROW = 3.6, 2.4
#: A colour scale with evenly rising lightness, also for the colour-blind.
COLOURS = "cividis"
#: The part of the range from which on the colours are light.
LIGHT = 0.55
#: The colour where no case was run, or the case failed.
EMPTY = "#DDDDDD"


def why_not(chosen: Chosen) -> str | None:
    """The reason why no map can be drawn; None where one can. A map needs two numbers of a grid."""
    if chosen.table.combine != GRID:
        return f"it is of a grid, and the sweep combines by '{chosen.table.combine}'"
    if len(chosen.numbers) < 2:
        return "it takes two numbers that vary"
    return None


@styled
def draw(chosen: Chosen) -> Figure:
    """Draw a map for each measure, two in a row."""
    over = chosen.numbers[:2]
    kept, said = middle_of_others(chosen, over)
    count = len(chosen.measures)
    columns = min(count, 2)
    rows = ceil(count / columns)
    height = rows * (WIDE if columns == 1 else NARROW) + AXIS_HEIGHT
    figure = Figure(figsize=(page_width(), height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).reshape(-1)
    for axis, measure in zip(axes, chosen.measures, strict=False):
        _map(figure, axis, chosen, measure, over, kept)
    for axis in axes[count:]:
        axis.set_visible(False)
    put_legend(figure, panels.legend_entries(list(axes)))
    small_print(figure, chosen.remark(said))
    return figure


def _map(figure: Figure, axis: Axes, chosen: Chosen, measure: Column, over: tuple[Column, ...], kept: Cases) -> None:
    x, y = (chosen.scaled(column)[1][kept] for column in over)
    values = chosen.scaled(measure)[1]
    (across, columns), (up, rows) = (np.unique(each, return_inverse=True) for each in (x, y))
    grid = np.full((len(up), len(across)), np.nan)
    grid[rows.reshape(-1), columns.reshape(-1)] = values[kept]
    for which, each in (("x", across), ("y", up)):
        spread_out(axis, which, each)  # type: ignore[arg-type]
    axis.set_facecolor(EMPTY)
    axis.grid(visible=False)
    known = np.ma.masked_invalid(grid)
    edges = (_edges(across, axis.get_xscale()), _edges(up, axis.get_yscale()))
    mesh = axis.pcolormesh(*edges, known, cmap=COLOURS, rasterized=True)
    if min(grid.shape) > 1 and np.ptp(known.compressed()) > 0.0:
        _contours(axis, across, up, known)
    bad = chosen.table.failed[kept]
    crosses(axis, x[bad], y[bad])
    room = page_width() / 2 - 1.0 if len(chosen.measures) > 1 else page_width() - 2.0
    axis.set(xlabel=name(over[0], room), ylabel=name(over[1], NARROW - 0.6))
    few_ticks(axis, 5, 6)
    bar = figure.colorbar(mesh, ax=axis, fraction=0.08, pad=0.02)
    bar.set_label(name(measure, NARROW - 0.4), fontsize=label_size())
    bar.outline.set_linewidth(0.5)


def _contours(axis: Axes, across: Array, up: Array, known: Array) -> None:
    """Draw contours with their values, white where the map is dark, black where it is light."""
    low, high = float(known.min()), float(known.max())
    levels = np.asarray(MaxNLocator(7).tick_values(low, high))
    levels = levels[(levels > low) & (levels < high)]
    colours = ["#FFFFFF" if level < low + LIGHT * (high - low) else "#000000" for level in levels]
    if len(levels):
        lines = axis.contour(across, up, known, levels=levels, colors=colours, linestyles="-", linewidths=0.7)
        axis.clabel(lines, fontsize=6.5, fmt="%.6g")


def _edges(values: Array, scale: str) -> Array:
    """The edges of the cells: midway between the values, and as far outside of the first and the last."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    along = np.log(values) if scale == "log" else values
    middle = (along[1:] + along[:-1]) / 2.0
    edges: Array = np.concatenate([[2.0 * along[0] - middle[0]], middle, [2.0 * along[-1] - middle[-1]]])
    return np.exp(edges) if scale == "log" else edges
