"""Figures of panels over a common time axis, with the legend above them, where it covers no data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import NullFormatter

from mbproj.base.arrays import Array
from mbproj.results.analysis.tables import MANY, thinned
from mbproj.results.record import Results
from mbproj.show.figures.fitted_text import fitted, literal, width
from mbproj.show.figures.style import (
    AXIS_HEIGHT,
    PANEL_HEIGHT,
    SHADE,
    STYLE,
    label_size,
    legend_size,
    line,
    page_height,
    page_width,
    print_size,
    styled,
    tick_degrees,
)

# --- The legend above the panels and the small print below them -------------------------------------------------------
# The figure grows by their height.


#: The free width at both sides of the page together, inches.
SIDES = 0.3
#: The height of a line of text, in font sizes.
LINE = 1.3
#: The most lines of one remark, and of one label in the legend.
MOST_LINES, MOST_LEGEND_LINES = 4, 2
#: The width beside the text of a legend's entry, in font sizes: the line sample, its gap, and the gap of columns.
BESIDE = STYLE["legend.handlelength"] + 0.8 + STYLE["legend.columnspacing"]


@styled
def small_print(figure: Figure, text: str) -> None:
    """Put `text` below the panels, above earlier small print. An empty text does nothing."""
    if not text:
        return
    lines = fitted(text, figure.get_figwidth() - SIDES, print_size(), MOST_LINES)
    below = figure.get_supxlabel()
    figure.supxlabel(f"{lines}\n{below}" if below else lines, fontsize=print_size(), color="#555555")
    _grow(figure, len(lines.split("\n")) * LINE * print_size() / 72.0)


@styled
def put_legend(figure: Figure | SubFigure, entries: Mapping[str, Any]) -> None:
    """Put a legend above the panels, from handles by label, in as many columns as fit."""
    if not entries:
        return
    whole = figure.get_figure(root=True) if isinstance(figure, SubFigure) else figure
    assert whole is not None
    room, beside = whole.get_figwidth() - SIDES, BESIDE * legend_size() / 72.0
    texts = [_entry(label, room - beside) for label in entries]
    widest = max(width(line, legend_size()) for text in texts for line in text.split("\n"))
    columns = max(1, min(len(texts), int(room / (widest + beside))))
    columns = ceil(len(texts) / ceil(len(texts) / columns))
    figure.legend(list(entries.values()), texts, loc="outside upper center", ncols=columns)
    lines = max(text.count("\n") + 1 for text in texts) * ceil(len(texts) / columns)
    _grow(whole, (1.5 * lines + 0.5) * legend_size() / 72.0)


def _entry(label: str, room: float) -> str:
    """The label as the legend shows it. A label with mathematics is one of mbproj's and short, so that it is not
    wrapped."""
    plain = label.replace(r"\$", "")
    return label if "$" in plain else fitted(label.replace(r"\$", "$"), room, legend_size(), MOST_LEGEND_LINES)


def _grow(figure: Figure, height: float) -> None:
    figure.set_figheight(figure.get_figheight() + height)


# --- Panels over a common time axis -----------------------------------------------------------------------------------


TIME = "time (s)"
#: Smaller violations are drawn at this value: a logarithm has no zero, and smaller values tell nothing more.
FLOOR = 1e-17
ON_THE_FLOOR = "zero and what is below 10⁻¹⁷ is drawn at 10⁻¹⁷"
#: A movement below this part of the largest one is drawn as rest, not enlarged to fill its panel.
STILL = 1e-9
#: A movement below this part of the mechanism's size is round-off, and is drawn as rest too.
ROUND_OFF = 1e-12
#: The label of grey lines, which redundant joints share arbitrarily.
NOT_UNIQUE = "not unique"
#: The part of a panel's height that its axis and the gap to the next take, inches.
GAP = 0.18
#: The width of a label below the panels, as a part of the page's width.
ROOM = 0.8
#: An angle modulo a turn that jumps by more than this between two samples, in degrees, begins a new turn.
JUMP = 180.0
#: An axis with a larger range than this, in degrees, shows the whole turn.
MOST_OF_A_TURN = 330.0


def panels(
    rows: int, columns: int = 1, *, height: float = PANEL_HEIGHT, share: Any = False, parts: Sequence[float] = ()
) -> tuple[Figure, Any]:
    """A figure and its axes (rows, columns) with one time axis. `share` is matplotlib's `sharey`. Rows have these
    `parts` of `height`, or less where the page is full. The grid's height ratios are in inches, as `name` needs
    them."""
    ratios = np.array(parts or [1.0] * rows, dtype=float)
    heights = ratios * min(height, (page_height() - AXIS_HEIGHT) / ratios.sum())
    figure = Figure(figsize=(page_width(), heights.sum() + AXIS_HEIGHT), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=share, squeeze=False, height_ratios=heights.tolist())
    for axis in axes[-1]:
        axis.set_xlabel(TIME)
    return figure, axes


def name(axis: Axes, words: str, unit: str = "") -> None:
    """Name the vertical axis in at most two lines, not longer than the panel is high."""
    place = axis.get_subplotspec()
    assert place is not None
    heights = np.array(place.get_gridspec().get_height_ratios(), dtype=float)
    room = float(heights[list(place.rowspan)].sum()) - GAP
    whole = f"({unit})".replace(" ", "\u00a0") if unit else ""
    axis.set_ylabel(fitted(f"{words} {whole}", room, label_size(), 2))


def plot(axis: Axes, time: npt.NDArray[Any], values: npt.NDArray[Any], label: str, index: int, **options: Any) -> None:
    """Draw a line, or a dot for a single sample. A very long line over time is thinned."""
    if len(time) >= MANY and np.ndim(values) == 1 and np.all(np.diff(time) >= 0.0):
        time, values = thinned(np.asarray(time, dtype=float), np.asarray(values, dtype=float))
    dot: dict[str, Any] = {"marker": "o", "markersize": 3} if len(time) == 1 else {}
    axis.plot(time, values, label=literal(label), **(line(index) | dot | options))


def plot_log(axis: Axes, time: npt.NDArray[Any], values: npt.NDArray[Any], label: str, index: int) -> None:
    """Draw a line of absolute values on a logarithmic axis; values below `FLOOR` are drawn at `FLOOR`."""
    size = np.abs(np.where(np.isfinite(values), values, np.nan))
    axis.set_yscale("log")
    plot(axis, time, np.where(size < FLOOR, FLOOR, size), label, index)


def finish(figure: Figure, *, remark: str = "", with_legend: bool = True) -> Figure:
    """Add one legend above all panels, with each label once, and small print below them: `remark`, and a note on values
    at the floor."""
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
    """Thin very long lines, without a visible change. A million points take minutes, and make files that no program
    opens."""
    for axis in figure.axes:
        for shown in axis.lines:
            x, y = (np.asarray(values) for values in shown.get_data())
            if len(x) >= MANY:
                shown.set_data(*thinned(x.astype(float), y.astype(float)))


def _whole_decades(axis: Axes) -> None:
    """Show at least two powers of ten, and no labels between them, which would overlap."""
    low, high = (np.log10(limit) for limit in axis.get_ylim())
    if np.floor(high) - np.ceil(low) < 1:
        axis.set_ylim(10.0 ** np.floor(low), 10.0 ** max(np.ceil(high), np.floor(low) + 1))
    axis.yaxis.set_minor_formatter(NullFormatter())


def legend_entries(axes: Sequence[Axes]) -> dict[str, Any]:
    """The handles of these axes by label, each label once."""
    entries: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    return entries


def hold_still(axes: Sequence[Axes], size: float) -> None:
    """Widen the limits of axes whose lines hardly move, so that round-off is not enlarged. The new range follows the
    largest movement among `axes`, or the mechanism's `size` in their unit."""
    spans = [span(axis) for axis in axes]
    largest = max(high - low for low, high in spans)
    shown = (largest if largest > ROUND_OFF * size else size) or 1.0  # 1 where nothing moves and the size is zero
    for axis, (low, high) in zip(axes, spans, strict=True):
        if high - low <= max(STILL * largest, ROUND_OFF * max(size, abs(low), abs(high))):
            middle = (low + high) / 2
            around = 0.05 * max(shown, abs(middle))
            axis.set_ylim(middle - around, middle + around)


def span(axis: Axes) -> tuple[float, float]:
    """The lowest and the highest value drawn on an axis."""
    values = np.concatenate([np.asarray(drawn.get_ydata(), dtype=float) for drawn in axis.lines] or [np.zeros(1)])
    values = values[np.isfinite(values)]
    return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)


def in_degrees(values: Array, unit: str, *, modulo: bool = True) -> Array:
    """A coordinate as its axis shows it: angles in degrees, by default modulo a turn."""
    if unit != "rad":
        return values
    degrees = np.degrees(values)
    return np.asarray(degrees % 360.0) if modulo else degrees


def by_turns(at: Array, values: Array) -> tuple[Array, Array]:
    """A line over an angle in degrees modulo a turn, with a gap where a new turn begins."""
    gaps = np.flatnonzero(np.abs(np.diff(at)) > JUMP) + 1
    return np.insert(at, gaps, np.nan), np.insert(np.asarray(values, dtype=float), gaps, np.nan)


def relabel(figure: Figure, name: str, unit: str, *, modulo: bool) -> None:
    """Change panels over time to panels over a coordinate: new labels, and gaps between turns."""
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
    """The label below an axis over a coordinate."""
    return fitted(f"{name} ({'°' if unit == 'rad' else unit})", ROOM * page_width(), label_size())


def _with_gaps(axis: Axes) -> None:
    for drawn in axis.lines:
        x, y = (np.asarray(values, dtype=float) for values in drawn.get_data())
        drawn.set_data(*by_turns(x, y))


# --- Events as thin lines across all panels over time, where there are not too many -----------------------------------


#: The most event times that are drawn. More would cover the curves.
MOST = 30


def mark_events(figure: Figure, results: Sequence[Results]) -> None:
    """Draw a line at each event time in the panels over time. Their limits stay."""
    shown = [result.time for result in results if len(result.time)]
    times = {event.time for result in results for event in result.events}
    if not shown or not 0 < len(times) <= MOST:
        return
    first, last = min(time[0] for time in shown), max(time[-1] for time in shown)
    over_time = {id(axis) for axis in figure.axes if axis.get_xlabel() == TIME}
    columns = {axis.get_position().x0 for axis in figure.axes if id(axis) in over_time}
    for axis in figure.axes:
        if id(axis) in over_time or (axis.get_position().x0 in columns and not axis.get_xlabel()):
            limits = axis.get_xlim()
            for time in sorted(times):
                if first <= time <= last:
                    axis.axvline(time, color="#000000", linewidth=0.4, alpha=0.35, zorder=0.5)
            axis.set_xlim(limits)


# --- Marks for the untrusted part of a certified run ------------------------------------------------------------------
# From the time on at which its error may exceed a limit.


def since(result: Results, limit: float, name: str | None = None) -> float | None:
    """The time (s) from which on the error of a marker, or of any marker, may exceed the limit. None where it never
    does, or the run was not certified."""
    trust = result.trust
    return None if trust is None else trust.untrusted_from(limit, name)


def mark_untrusted(figure: Figure, results: Sequence[Results], limit: float) -> str:
    """Shade all panels from the first time on at which a marker of a run is not trusted. Return a text on it."""
    return shade({"": figure.axes}, results, limit)


def shade(axes: Mapping[str, Sequence[Axes]], results: Sequence[Results], limit: float) -> str:
    """Shade the axes of each marker ("": of all) from its first untrusted time in any run. Return a text on it, or
    ""."""
    shaded = False
    end = max(float(result.time[-1]) for result in results)
    for name, of_marker in axes.items():
        times = [time for result in results if (time := since(result, limit, name)) is not None]
        for axis in of_marker if times and min(times) < end else ():
            left, right = axis.get_xlim()
            axis.axvspan(max(min(times), left), end, color=SHADE, linewidth=0, zorder=0)
            axis.set_xlim(left, right)
            shaded = True
    return f"shaded: {exceeds(limit)}" if shaded else ""


def exceeds(limit: float) -> str:
    """The text for untrusted parts."""
    return f"the error may exceed {limit:g} m"


def explain(figure: Figure, text: str) -> None:
    """Put the text on marks below the panels."""
    if text:
        small_print(figure, text)
