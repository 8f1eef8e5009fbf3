"""Figures of panels over a common time axis, with the legend above them, where it covers no data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.plot.style import LEGEND_HEIGHT, PANEL_HEIGHT, WIDTH, line

TIME = "time (s)"
#: Below this a violation is drawn as this: a logarithm has no zero, and nothing below says more than zero does.
FLOOR = 1e-17
ON_THE_FLOOR = "zero and what is below $10^{-17}$ is drawn at $10^{-17}$"
#: A motion smaller than this part of the largest is drawn as standing still, not blown up to fill its panel.
STILL = 1e-6
#: What the largest motion counts as where there is hardly any: 1e-12 m or rad is round-off.
LEAST = 1e-6


def panels(rows: int, columns: int = 1, *, height: float = PANEL_HEIGHT, share: Any = False) -> tuple[Figure, Any]:
    """A figure and its axes (rows, columns) with one time axis; `share` is matplotlib's `sharey`."""
    width = max(WIDTH, 2.6 * columns)
    figure = Figure(figsize=(width, rows * height + LEGEND_HEIGHT), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=share, squeeze=False)
    for axis in axes[-1]:
        axis.set_xlabel(TIME)
    return figure, axes


def plot(axis: Axes, time: npt.NDArray[Any], values: npt.NDArray[Any], label: str, index: int, **options: Any) -> None:
    """A line; a single sample is a dot, because a line of one point cannot be seen."""
    dot: dict[str, Any] = {"marker": "o", "markersize": 3} if len(time) == 1 else {}
    axis.plot(time, values, label=literal(label), **(line(index) | dot | options))


def literal(text: str) -> str:
    """`text` as matplotlib shows it letter by letter: `$` begins mathematics, and a label with `_` first is hidden."""
    return (" " if text.startswith("_") else "") + text.replace("$", r"\$")


def plot_log(axis: Axes, time: npt.NDArray[Any], values: npt.NDArray[Any], label: str, index: int) -> None:
    """A line of absolute values over a logarithmic axis, what is below `FLOOR` on the floor."""
    size = np.abs(np.where(np.isfinite(values), values, np.nan))
    axis.set_yscale("log")
    plot(axis, time, np.where(size < FLOOR, FLOOR, size), label, index)


def finish(figure: Figure, *, remark: str = "", with_legend: bool = True) -> Figure:
    """The figure with one legend above all panels, each label once, and small print below them: `remark`, and what is
    on the floor of a logarithmic axis."""
    found: dict[str, Any] = {}
    for axis in figure.axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    if found and with_legend:
        columns = int(np.clip(95 // (max(map(len, found)) + 9), 1, len(found)))
        figure.legend(list(found.values()), list(found), loc="outside upper center", ncols=columns)
    drawn = (np.asarray(shown.get_ydata()) for axis in figure.axes for shown in axis.lines)
    on_the_floor = ON_THE_FLOOR if any(np.any(values == FLOOR) for values in drawn) else ""
    text = "; ".join(part for part in (remark, on_the_floor) if part)
    if text:
        small_print(figure, text)
    return figure


def small_print(figure: Figure, text: str) -> None:
    """Put `text` below the panels, above what stands there."""
    below = figure.get_supxlabel()
    figure.supxlabel("\n".join(part for part in (text, below) if part), fontsize=7, color="#555555")


def hold_still(axes: Sequence[Axes], least: float = LEAST) -> None:
    """Widen the axes whose lines hardly move, so that round-off is not blown up: against the largest range among
    `axes`, which counts as `least` at the least."""
    spans = [span(axis) for axis in axes]
    largest = max(least, *(high - low for low, high in spans))
    for axis, (low, high) in zip(axes, spans, strict=True):
        if high - low < STILL * largest:
            middle = (low + high) / 2
            axis.set_ylim(middle - 0.05 * largest, middle + 0.05 * largest)


def span(axis: Axes) -> tuple[float, float]:
    """The lowest and the highest value that is drawn."""
    values = np.concatenate([np.asarray(drawn.get_ydata(), dtype=float) for drawn in axis.lines] or [np.zeros(1)])
    values = values[np.isfinite(values)]
    return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
