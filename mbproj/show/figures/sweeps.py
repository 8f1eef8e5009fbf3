"""Pictures of a sweep: its measures over one quantity, over two, as distributions, and by their sensitivity to each
quantity.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mbproj.base.arrays import Array
from mbproj.base.registry import SAMPLED
from mbproj.results.analysis.sensitivity import Indices, rank_correlation, rank_interval, sobol_indices
from mbproj.results.sweep_table import GRID, Column
from mbproj.show.figures import panels
from mbproj.show.figures.fitted_text import MAX_LINES, fitted, literal
from mbproj.show.figures.panels import put_legend, small_print
from mbproj.show.figures.style import (
    AXIS_HEIGHT,
    PANEL_HEIGHT,
    label_size,
    line,
    page_height,
    page_width,
    print_size,
    styled,
)
from mbproj.show.figures.sweep_axes import (
    SALTELLI,
    Cases,
    Chosen,
    crosses,
    crosses_below,
    few_ticks,
    middle_of_others,
    name,
    scale_of,
    spread_out,
)

# --- Measures over one varied quantity, with a line for each value of a second one ------------------------------------

#: Lines with fewer points than this mark them.
FEW = 60
MARKS = "osD^vP<"


def no_lines(chosen: Chosen) -> str | None:
    """The reason why no lines can be drawn; None where they can. Lines join the cases of a grid, or of a single
    quantity."""
    if not chosen.over:
        return "nothing varies in this sweep"
    if chosen.table.combine not in (GRID, "zip") and len(chosen.over) > 1:
        return f"'{chosen.table.combine}' varies {len(chosen.over)} quantities at once, and no line joins its cases"
    return None


@styled
def draw_lines(chosen: Chosen) -> Figure:
    """Draw a row for each measure."""
    first, second = _axes(chosen)
    at_middle, said = middle_of_others(chosen, [column for column in (first, second) if column is not None])
    figure, axes = panels.panels(
        len(chosen.measures), height=max(PANEL_HEIGHT, 2.6 if len(chosen.measures) == 1 else 0)
    )
    places, ticks = _places(first)
    lines, cut = _lines(chosen, second)
    for axis, measure in zip(axes[:, 0], chosen.measures, strict=True):
        _, values = chosen.scaled(measure)
        for index, (label, cases) in enumerate(lines):
            shown = at_middle & cases
            _line(axis, places[shown], values[shown], label, index)
        crosses_below(axis, places[at_middle & chosen.table.failed])
        axis.margins(x=0.02)
        panels.name(axis, measure.name, scale_of(measure).unit)
        if ticks:
            axis.set_xticks(range(len(ticks)), [literal(tick) for tick in ticks])
        elif first.is_number:
            spread_out(axis, "x", places)
    axes[-1, 0].set_xlabel(name(first, page_width() - 1.0, 1))
    return panels.finish(
        figure, remark=chosen.remark(said, cut), with_legend=second is not None or _any_bad(chosen, at_middle)
    )


def _any_bad(chosen: Chosen, at_middle: Cases) -> bool:
    return bool(np.any(chosen.table.failed & at_middle))


def _axes(chosen: Chosen) -> tuple[Column, Column | None]:
    """The quantity along the axis, a number where there is one, and the quantity of the lines, or None."""
    first = chosen.over[0] if chosen.over[0].is_number else next(iter(chosen.numbers), chosen.over[0])
    others = [column for column in chosen.over if column is not first]
    return first, others[0] if others and chosen.table.combine == GRID else None


def _places(column: Column) -> tuple[Array, list[str]]:
    """The place of each case along the axis, and ticks where the values are words."""
    if column.is_number:
        return scale_of(column).factor * column.values, []
    words = list(dict.fromkeys(column.values.tolist()))
    return np.array([float(words.index(value)) for value in column.values]), words


def _lines(chosen: Chosen, column: Column | None) -> tuple[Sequence[tuple[str, Cases]], str]:
    """The label and the cases of each line, and a remark where not all are drawn."""
    if column is None:
        return [("", np.ones(len(chosen.table.status), dtype=bool))], ""
    values = list(dict.fromkeys(column.values.tolist()))
    taken = np.unique(np.linspace(0, len(values) - 1, min(len(values), MAX_LINES)).round().astype(int))
    scale = scale_of(column)
    lines = [(f"{column.name} = {scale.reads(values[k])}", column.values == values[k]) for k in taken]
    return lines, "" if len(taken) == len(values) else f"{len(taken)} of {len(values)} values of {column.name}"


def _line(axis: Axes, x: Array, y: Array, label: str, index: int) -> None:
    order = np.argsort(x, kind="stable")
    marks = {"marker": MARKS[index % len(MARKS)], "markersize": 3.0} if len(x) < FEW else {}
    axis.plot(x[order], y[order], label=literal(label) or "_", **(line(index) | marks))


# --- Measures over two quantities of a grid ---------------------------------------------------------------------------
# Heat maps with contours.


#: The height of a single map, and of two side by side, inches.
WIDE, NARROW = 3.6, 2.4
#: A colour scale with evenly rising lightness, also for the colour-blind.
COLOURS = "cividis"
#: The part of the range from which on the colours are light.
LIGHT = 0.55
#: The colour where no case was run, or the case failed.
EMPTY = "#DDDDDD"


def no_map(chosen: Chosen) -> str | None:
    """The reason why no map can be drawn; None where one can. A map needs two numbers of a grid."""
    if chosen.table.combine != GRID:
        return f"it is of a grid, and the sweep combines by '{chosen.table.combine}'"
    if len(chosen.numbers) < 2:
        return "it takes two numbers that vary"
    return None


@styled
def draw_map(chosen: Chosen) -> Figure:
    """Draw a map for each measure, two in a row."""
    over = chosen.numbers[:2]
    at_middle, said = middle_of_others(chosen, over)
    count = len(chosen.measures)
    columns = min(count, 2)
    rows = ceil(count / columns)
    height = rows * (WIDE if columns == 1 else NARROW) + AXIS_HEIGHT
    figure = Figure(figsize=(page_width(), height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).reshape(-1)
    for axis, measure in zip(axes, chosen.measures, strict=False):
        _map(figure, axis, chosen, measure, over, at_middle)
    for axis in axes[count:]:
        axis.set_visible(False)
    put_legend(figure, panels.legend_entries(list(axes)))
    small_print(figure, chosen.remark(said))
    return figure


def _map(
    figure: Figure, axis: Axes, chosen: Chosen, measure: Column, over: tuple[Column, ...], at_middle: Cases
) -> None:
    x, y = (chosen.scaled(column)[1][at_middle] for column in over)
    values = chosen.scaled(measure)[1]
    (across, columns), (up, rows) = (np.unique(each, return_inverse=True) for each in (x, y))
    grid = np.full((len(up), len(across)), np.nan)
    grid[rows.reshape(-1), columns.reshape(-1)] = values[at_middle]
    for which, each in (("x", across), ("y", up)):
        spread_out(axis, which, each)  # type: ignore[arg-type]
    axis.set_facecolor(EMPTY)
    axis.grid(visible=False)
    known = np.ma.masked_invalid(grid)
    edges = (_edges(across, axis.get_xscale()), _edges(up, axis.get_yscale()))
    mesh = axis.pcolormesh(*edges, known, cmap=COLOURS, rasterized=True)
    if min(grid.shape) > 1 and np.ptp(known.compressed()) > 0.0:
        _contours(axis, across, up, known)
    bad = chosen.table.failed[at_middle]
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


# --- The distribution of each measure ---------------------------------------------------------------------------------
# A histogram with its mean, deviation and quantiles.


#: The height of a single panel, and of one of several, inches.
TALL, LOW = 2.9, 2.1
#: The quantiles that are drawn.
QUANTILES = (0.05, 0.5, 0.95)
#: The fewest and the most bars of a histogram.
BARS = (8, 60)
FILL = "#A9CBE4"


def no_distribution(chosen: Chosen) -> str | None:
    """The reason why no distribution can be drawn: too few values. None where one can."""
    if all(np.count_nonzero(np.isfinite(measure.values)) < 2 for measure in chosen.measures):
        return "fewer than two cases have values"
    return None


@styled
def draw_distribution(chosen: Chosen) -> Figure:
    """Draw a row for each measure."""
    count = len(chosen.measures)
    figure = Figure(
        figsize=(page_width(), min(count * (TALL if count == 1 else LOW), page_height())), layout="constrained"
    )
    for axis, measure in zip(figure.subplots(count, 1, squeeze=False)[:, 0], chosen.measures, strict=True):
        _histogram(axis, chosen, measure)
    remark = chosen.remark(f"lines: {', '.join(f'{100 * share:g} %' for share in QUANTILES)} quantiles")
    return panels.finish(figure, remark=remark, with_legend=False)


def _histogram(axis: Axes, chosen: Chosen, measure: Column) -> None:
    scale, values = chosen.scaled(measure)
    values = values[chosen.independent]
    values = values[np.isfinite(values)]
    axis.set_xlabel(name(measure, page_width() - 1.0, 1))
    axis.set_ylabel("cases")
    if len(values) < 2 or np.ptp(values) == 0.0:
        said = f"all cases: {values[0]:.6g}" if len(values) else "no case has a value"
        axis.text(0.5, 0.5, said, ha="center", transform=axis.transAxes, fontsize=print_size())
        return
    axis.hist(values, bins=bars(values), color=FILL, edgecolor="#FFFFFF", linewidth=0.4)
    at = np.quantile(values, QUANTILES)
    for index, value in enumerate(at):
        axis.axvline(value, **(line(2) if index == 1 else line(1)) | {"linewidth": 1.0})
    numbers = ", ".join(_digits(value, values) for value in at)
    said = (
        f"mean {_digits(values.mean(), values)}, deviation {values.std(ddof=1):.3g}; quantiles {numbers} {scale.unit}"
    )
    axis.set_title(said, loc="left", fontsize=print_size(), pad=3)


def bars(values: Array) -> int:
    """The number of bars of a histogram, by Freedman and Diaconis' width."""
    quarter = np.subtract(*np.quantile(values, [0.75, 0.25]))
    width = 2.0 * quarter / len(values) ** (1.0 / 3.0)
    return int(np.clip(np.ptp(values) / width if width > 0.0 else BARS[0], *BARS))


def _digits(value: float, values: Array) -> str:
    """A value with enough digits to tell it apart: three of the values' deviation."""
    places = int(max(0, 2 - np.floor(np.log10(values.std(ddof=1)))))
    return f"{value:.{min(places, 12)}f}"


# --- All varied quantities and measures over each other ---------------------------------------------------------------
# A matrix of scatter plots, with histograms on its diagonal.


#: The most quantities in the matrix, and the most points in one panel.
MOST, POINTS = 7, 4000


def no_scatter(chosen: Chosen) -> str | None:
    """The reason why no scatter plot can be drawn; None where one can. A point needs two coordinates."""
    return None if len(chosen.numbers) + len(chosen.measures) > 1 and chosen.numbers else "no number varies"


@styled
def draw_scatter(chosen: Chosen) -> Figure:
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


# --- Bars, one for each varied quantity, with their intervals ---------------------------------------------------------


#: The most bars in a panel; the height of a bar and of the rest of a panel, and the room for a name, inches.
MOST_BARS, BAR, AROUND, NAME = 12, 0.22, 0.34, 1.7
WHISKER: dict[str, Any] = {"fmt": "none", "ecolor": "#222222", "elinewidth": 0.9, "capsize": 2.0, "zorder": 3}


def stacked(count: int, names: int, width: float = 1.0) -> tuple[Figure, Any]:
    """A figure of `count` panels below each other, each with room for this number of `names`, whose bars are `width`
    bars thick."""
    each = min(names, MOST_BARS) * BAR * width + AROUND
    height = min(count * each, page_height()) + AXIS_HEIGHT
    figure = Figure(figsize=(page_width(), height), layout="constrained")
    return figure, figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]


def largest(sizes: Array) -> npt.NDArray[np.intp]:
    """The numbers of the bars to draw, the largest first and NaN last."""
    return np.argsort(-np.nan_to_num(np.abs(sizes), nan=-1.0), kind="stable")[:MOST_BARS]


def label(axis: Axes, names: Sequence[str]) -> None:
    """Name the bars, the first at the top."""
    axis.set_yticks(range(len(names)), [fitted(name, NAME, 8.0) for name in names])
    axis.set_ylim(len(names) - 0.4, -0.6)
    axis.grid(visible=False, axis="y")
    axis.tick_params(axis="y", length=0)


def whiskers(axis: Axes, values: Array, between: Array, places: Array) -> None:
    """Draw the intervals of values: (2, n), the lower and the upper ends."""
    known = np.isfinite(values) & np.all(np.isfinite(between), axis=0)
    apart = np.abs(between[:, known] - values[known])
    axis.errorbar(values[known], places[known], xerr=apart, **WHISKER)


# --- Rank correlations of the measures with the varied quantities, as a tornado chart ---------------------------------


#: The fewest cases that tell something.
FEWEST = 4


def no_ranks(chosen: Chosen) -> str | None:
    """The reason why no ranks can be drawn; None where they can."""
    if not chosen.numbers:
        return "no number varies"
    if max(np.count_nonzero(np.isfinite(measure.values)) for measure in chosen.measures) < FEWEST:
        return f"fewer than {FEWEST} cases have values"
    return None


@styled
def draw_ranks(chosen: Chosen) -> Figure:
    """Draw a panel for each measure, the strongest correlation at the top."""
    figure, axes = stacked(len(chosen.measures), len(chosen.numbers))
    for axis, measure in zip(axes, chosen.measures, strict=True):
        _tornado(axis, chosen, measure)
    axes[-1].set_xlabel("Spearman's rank correlation")
    sampled = chosen.table.combine in SAMPLED
    words = sum(not column.is_number for column in chosen.over)
    return panels.finish(
        figure,
        remark=chosen.remark(
            "whiskers: 95 % confidence" if sampled else "",
            f"left out: {words} that vary and are no numbers" if words else "",
        ),
        with_legend=False,
    )


def _tornado(axis: Axes, chosen: Chosen, measure: Column) -> None:
    known = np.isfinite(measure.values[chosen.independent])
    y = measure.values[chosen.independent][known]
    correlations = np.array([rank_correlation(each.values[chosen.independent][known], y) for each in chosen.numbers])
    order = largest(correlations)
    shown, places = correlations[order], np.arange(len(order), dtype=float)
    colours = [line(0)["color"] if value >= 0.0 else line(1)["color"] for value in shown]
    axis.barh(places, np.nan_to_num(shown), height=0.66, color=colours, linewidth=0)
    if chosen.table.combine in SAMPLED:
        between = np.array([rank_interval(value, len(y)) for value in shown]).T
        whiskers(axis, shown, between, places)
    label(axis, [chosen.numbers[number].name for number in order])
    axis.axvline(0.0, color="#000000", linewidth=0.7)
    axis.set_xlim(-1.05, 1.05)
    axis.set_title(fitted(measure.name, 4.5, 8.5), loc="left", pad=3)


# --- Sobol' indices ---------------------------------------------------------------------------------------------------
# The part of a measure's variance due to each quantity, alone and with its interactions.


ALONE, WITH_OTHERS = "first order: alone", "total: with others too"
LIGHT_ORANGE = "#E69F00"


def no_sobol(chosen: Chosen) -> str | None:
    """The reason why no indices can be drawn; None where they can. They need Saltelli's design."""
    table = chosen.table
    if table.combine != SALTELLI:
        return f"the sweep combines by '{table.combine}': Sobol' indices take 'combine: saltelli'"
    if len(table.status) != table.samples * (len(_varying(chosen)) + 2):
        return "the cases are not those of Saltelli's design"
    return None


def _varying(chosen: Chosen) -> list[Column]:
    """The varied quantities in the order of the design."""
    return [column for column in chosen.table.varied if column.varies]


@styled
def draw_sobol(chosen: Chosen) -> Figure:
    """Draw a panel for each measure, the largest index at the top."""
    table, varying = chosen.table, _varying(chosen)
    figure, axes = stacked(len(chosen.measures), len(varying), 1.6)
    all_indices = [sobol_indices(measure.values, table.samples) for measure in chosen.measures]
    for axis, measure, indices in zip(axes, chosen.measures, all_indices, strict=True):
        _pairs(axis, indices, varying)
        axis.set_title(fitted(measure.name, 4.5, 8.5), loc="left", pad=3)
    axes[-1].set_xlabel("share of the variance")
    fewest = min(indices.samples for indices in all_indices)
    lost = (
        f"{fewest} of {table.samples} samples: those with a failed case are left out" if fewest < table.samples else ""
    )
    return panels.finish(figure, remark=chosen.remark("whiskers: 95 % confidence (bootstrap)", lost))


def _pairs(axis: Axes, sobol: Indices, varying: list[Column]) -> None:
    order = largest(sobol.total)
    places = np.arange(len(order), dtype=float)
    pairs = (
        (sobol.first, sobol.first_between, -0.18, line(0)["color"], ALONE),
        (sobol.total, sobol.total_between, 0.18, LIGHT_ORANGE, WITH_OTHERS),
    )
    for values, between, aside, colour, words in pairs:
        axis.barh(places + aside, np.nan_to_num(values[order]), height=0.34, color=colour, linewidth=0, label=words)
        whiskers(axis, values[order], between[:, order], places + aside)
    label(axis, [varying[number].name for number in order])
    axis.axvline(0.0, color="#000000", linewidth=0.7)
    ends = np.concatenate([sobol.first_between, sobol.total_between])
    axis.set_xlim(min(-0.05, 1.05 * np.nanmin(ends, initial=0.0)), 1.05 * np.nanmax(ends, initial=1.0))
