"""Bars, one for each varied quantity, with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures.fitted_text import fitted
from mbproj.figures.style import AXIS_HEIGHT, page_height, page_width

#: The most bars in a panel; the height of a bar and of the rest of a panel, and the room for a name, inches.
MOST, BAR, AROUND, NAME = 12, 0.22, 0.34, 1.7
WHISKER: dict[str, Any] = {"fmt": "none", "ecolor": "#222222", "elinewidth": 0.9, "capsize": 2.0, "zorder": 3}


def stacked(count: int, names: int, width: float = 1.0) -> tuple[Figure, Any]:
    """A figure of `count` panels below each other, each with room for this number of `names`, whose bars are `width`
    bars thick."""
    each = min(names, MOST) * BAR * width + AROUND
    height = min(count * each, page_height()) + AXIS_HEIGHT
    figure = Figure(figsize=(page_width(), height), layout="constrained")
    return figure, figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]


def largest(sizes: Array) -> npt.NDArray[np.intp]:
    """The numbers of the bars to draw, the largest first and NaN last."""
    return np.argsort(-np.nan_to_num(np.abs(sizes), nan=-1.0), kind="stable")[:MOST]


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
