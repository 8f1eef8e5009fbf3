"""The effect of a projection's threshold on error and violation, projections, and cost."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.figures import panels
from mbproj.figures.style import AXIS_HEIGHT, SHADE, line, page_width, styled

HEIGHT = 1.6
#: Where the error is above this multiple of the reference's uncertainty, the uncertainty is not drawn: violations are
#: in its place.
NEAR_FLOOR = 1e4


@dataclass(frozen=True, eq=False)
class ThresholdSeries:
    """Series over `threshold` (N,): error in m, violations, projections, CPU time in s with its spread (N, 2). `always`
    and `never` are a run with a projection after every step, and one without, each as (error, |C|, projections,
    seconds). `floor` is the uncertainty of the reference in m."""

    threshold: Array
    error: Array
    position_violation: Array
    velocity_violation: Array
    projections: Array
    seconds: Array
    spread: Array
    always: tuple[float, float, float, float]
    never: tuple[float, float, float, float]
    recommended: float | None
    floor: float


@styled
def threshold_page(shown: ThresholdSeries, remark: str) -> Figure:
    """Draw three panels over the threshold."""
    figure = Figure(figsize=(page_width(), 3 * HEIGHT + AXIS_HEIGHT), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    axes[0].set_xscale("log")  # before the lines: around a single threshold, linear limits would be negative
    _series(axes[0], shown.threshold, shown.error, "error (m)", 0)
    _series(axes[0], shown.threshold, shown.position_violation, "$|C|_\\infty$ (m or rad)", 1)
    _series(axes[0], shown.threshold, shown.velocity_violation, "$|\\dot{C}|_\\infty$ (per s)", 3)
    axes[0].set_yscale("log")
    if np.nanmin(shown.error) < NEAR_FLOOR * shown.floor:
        axes[0].axhspan(axes[0].get_ylim()[0], shown.floor, color=SHADE, linewidth=0, zorder=0)
        place: dict[str, Any] = {"transform": axes[0].transAxes, "fontsize": 7, "color": "#555555"}
        axes[0].text(0.01, 0.03, "uncertainty of the reference (error)", **place)
    axes[0].set_ylabel("error, violation")
    axes[1].plot(shown.threshold, shown.projections, marker="o", markersize=3, **line(0))
    axes[1].set_ylabel("projections")
    axes[1].set_ylim(bottom=0)
    low, high = (1e3 * shown.spread[:, column] for column in (0, 1))
    axes[2].fill_between(shown.threshold, low, high, color=line(0)["color"], alpha=0.2, linewidth=0)
    axes[2].plot(shown.threshold, 1e3 * shown.seconds, marker="o", markersize=3, **line(0))
    axes[2].set_ylabel("CPU time (ms)")
    for axis, column, factor in zip(axes, (0, 2, 3), (1.0, 1.0, 1e3), strict=True):
        least = panels.FLOOR if axis is axes[0] else 0.0
        _level(axis, max(factor * shown.always[column], least), "after every step", (0, (4, 2)))
        _level(axis, max(factor * shown.never[column], least), "never", (0, (1, 2)))
        if shown.recommended is not None:
            axis.axvline(shown.recommended, color="#E69F00", linewidth=1.5, label="recommended", zorder=0.5)
    axes[2].set(xlabel="threshold (m or rad, and per s)")
    axes[2].set_ylim(bottom=0)
    return panels.finish(figure, remark=remark)


def _series(axis: Axes, threshold: Array, values: Array, label: str, index: int) -> None:
    shown = np.where(values < panels.FLOOR, panels.FLOOR, values)
    axis.plot(threshold, shown, label=label, marker="o", markersize=3, **line(index))


def _level(axis: Axes, value: float, label: str, dashes: tuple[int, tuple[int, ...]]) -> None:
    """Draw a horizontal line for a value that does not depend on the threshold."""
    if np.isfinite(value):
        axis.axhline(value, color="#777777", linewidth=0.9, linestyle=dashes, label=label, zorder=1.0)
