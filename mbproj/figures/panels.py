"""Figures of panels over a common time axis, with the legend above them, where it covers no data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from mbproj.analysis.thinned import MANY, thinned
from mbproj.arrays import Array
from mbproj.figures.fitted_text import fitted, literal
from mbproj.figures.margins import put_legend, small_print
from mbproj.figures.style import AXIS_HEIGHT, PANEL_HEIGHT, label_size, line, page_height, page_width
from mbproj.figures.units import tick_degrees

TIME = "time (s)"
#: Below this a violation is drawn as this: a logarithm has no zero, and nothing below says more than zero does.
FLOOR = 1e-17
ON_THE_FLOOR = "zero and what is below 10⁻¹⁷ is drawn at 10⁻¹⁷"
#: A motion smaller than this part of the largest is drawn as standing still, not blown up to fill its panel.
STILL = 1e-9
#: So is one that is smaller than this part of what the mechanism is large: it is round-off.
ROUND_OFF = 1e-12
#: What the legend says of the grey lines of what redundant joints share at will.
NOT_UNIQUE = "not unique"
#: What a panel's height in the grid leaves for its axis and the gap to the next, inches.
GAP = 0.18
#: Of a label below the panels, as a part of the width.
ROOM = 0.8
#: Between two samples an angle modulo a turn jumps by more than this where a new turn begins, in degrees.
JUMP = 180.0
#: An axis of more than so many degrees shows the whole turn.
MOST_OF_A_TURN = 330.0


def panels(
    rows: int, columns: int = 1, *, height: float = PANEL_HEIGHT, share: Any = False, parts: Sequence[float] = ()
) -> tuple[Figure, Any]:
    """A figure and its axes (rows, columns) with one time axis; `share` is matplotlib's `sharey`, and rows have these
    `parts` of `height`, or less where the page is full. Height ratios of the grid are inches: see `name`."""
    ratios = np.array(parts or [1.0] * rows, dtype=float)
    heights = ratios * min(height, (page_height() - AXIS_HEIGHT) / ratios.sum())
    figure = Figure(figsize=(page_width(), heights.sum() + AXIS_HEIGHT), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=share, squeeze=False, height_ratios=heights.tolist())
    for axis in axes[-1]:
        axis.set_xlabel(TIME)
    return figure, axes


def name(axis: Axes, words: str, unit: str = "") -> None:
    """Name the vertical axis in two lines at most that are no longer than the panel is high."""
    place = axis.get_subplotspec()
    assert place is not None
    heights = np.array(place.get_gridspec().get_height_ratios(), dtype=float)
    room = float(heights[list(place.rowspan)].sum()) - GAP
    whole = f"({unit})".replace(" ", "\u00a0") if unit else ""
    axis.set_ylabel(fitted(f"{words} {whole}", room, label_size(), 2))


def plot(axis: Axes, time: npt.NDArray[Any], values: npt.NDArray[Any], label: str, index: int, **options: Any) -> None:
    """A line; a single sample is a dot, because a line of one point cannot be seen. Of a very long one over time only
    what its picture needs is kept."""
    if len(time) >= MANY and np.ndim(values) == 1 and np.all(np.diff(time) >= 0.0):
        time, values = thinned(np.asarray(time, dtype=float), np.asarray(values, dtype=float))
    dot: dict[str, Any] = {"marker": "o", "markersize": 3} if len(time) == 1 else {}
    axis.plot(time, values, label=literal(label), **(line(index) | dot | options))


def plot_log(axis: Axes, time: npt.NDArray[Any], values: npt.NDArray[Any], label: str, index: int) -> None:
    """A line of absolute values over a logarithmic axis, what is below `FLOOR` on the floor."""
    size = np.abs(np.where(np.isfinite(values), values, np.nan))
    axis.set_yscale("log")
    plot(axis, time, np.where(size < FLOOR, FLOOR, size), label, index)


def finish(figure: Figure, *, remark: str = "", with_legend: bool = True) -> Figure:
    """The figure with one legend above all panels, each label once, and small print below them: `remark`, and what is
    on the floor of a logarithmic axis."""
    figure.align_ylabels()
    for axis in figure.axes:
        if axis.get_yscale() == "log" and axis.get_visible():
            _whole_decades(axis)
    if with_legend:
        put_legend(figure, legend_entries(figure.axes))
    drawn = (np.asarray(shown.get_ydata()) for axis in figure.axes for shown in axis.lines)
    on_the_floor = ON_THE_FLOOR if any(np.any(values == FLOOR) for values in drawn) else ""
    small_print(figure, "; ".join(part for part in (remark, on_the_floor) if part))
    return figure


def thin(figure: Figure) -> None:
    """Leave out what nobody can see of very long lines: a million points take minutes, and make files that no program
    opens."""
    for axis in figure.axes:
        for shown in axis.lines:
            x, y = (np.asarray(values) for values in shown.get_data())
            if len(x) >= MANY:
                shown.set_data(*thinned(x.astype(float), y.astype(float)))


def _whole_decades(axis: Axes) -> None:
    """Show two powers of ten at least, and label nothing between them, where labels would lie over each other."""
    low, high = (np.log10(limit) for limit in axis.get_ylim())
    if np.floor(high) - np.ceil(low) < 1:
        axis.set_ylim(10.0 ** np.floor(low), 10.0 ** max(np.ceil(high), np.floor(low) + 1))
    axis.yaxis.set_minor_formatter(NullFormatter())


def legend_entries(axes: Sequence[Axes]) -> dict[str, Any]:
    """What the legend of these axes shows by its label, each once."""
    found: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    return found


def hold_still(axes: Sequence[Axes], size: float) -> None:
    """Widen the axes whose lines hardly move, so that round-off is not blown up: beside what moves most among `axes`,
    or beside the mechanism's own `size` in their unit."""
    spans = [span(axis) for axis in axes]
    largest = max(high - low for low, high in spans)
    shown = (largest if largest > ROUND_OFF * size else size) or 1.0  # where nothing moves and nothing has a size
    for axis, (low, high) in zip(axes, spans, strict=True):
        if high - low <= max(STILL * largest, ROUND_OFF * max(size, abs(low), abs(high))):
            middle = (low + high) / 2
            around = 0.05 * max(shown, abs(middle))
            axis.set_ylim(middle - around, middle + around)


def span(axis: Axes) -> tuple[float, float]:
    """The lowest and the highest value that is drawn."""
    values = np.concatenate([np.asarray(drawn.get_ydata(), dtype=float) for drawn in axis.lines] or [np.zeros(1)])
    values = values[np.isfinite(values)]
    return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)


def in_degrees(values: Array, unit: str, *, modulo: bool = True) -> Array:
    """A coordinate as its axis shows it: an angle in degrees, modulo a turn unless all turns are to be seen."""
    if unit != "rad":
        return values
    found = np.degrees(values)
    return np.asarray(found % 360.0) if modulo else found


def by_turns(at: Array, values: Array) -> tuple[Array, Array]:
    """A line over an angle in degrees modulo a turn, with a gap where a new turn begins."""
    gaps = np.flatnonzero(np.abs(np.diff(at)) > JUMP) + 1
    return np.insert(at, gaps, np.nan), np.insert(np.asarray(values, dtype=float), gaps, np.nan)


def relabel(figure: Figure, name: str, unit: str, *, modulo: bool) -> None:
    """The panels over time are over a coordinate: their labels say so, and lines have gaps between turns."""
    axes = [axis for axis in figure.axes if axis.get_xlabel() == TIME]
    columns = {axis.get_position().x0 for axis in axes}
    for axis in figure.axes:
        if axis in axes:
            axis.set_xlabel(label_of(name, unit))
        elif axis.get_xlabel() or axis.get_position().x0 not in columns:
            continue
        if modulo:
            _with_gaps(axis)
            low, high = axis.get_xlim()
            axis.set_xlim((0.0, 360.0) if high - low > MOST_OF_A_TURN else (low, high))
        if unit == "rad":
            tick_degrees(axis, along_x=True)


def label_of(name: str, unit: str) -> str:
    """Below an axis over a coordinate."""
    return fitted(f"{name} ({'°' if unit == 'rad' else unit})", ROOM * page_width(), label_size())


def _with_gaps(axis: Axes) -> None:
    for drawn in axis.lines:
        x, y = (np.asarray(values, dtype=float) for values in drawn.get_data())
        drawn.set_data(*by_turns(x, y))
