"""A page that compares methods: violations, errors, the two parts of the energy drift, and costs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.figures import panels
from mbproj.figures.fitted_text import fitted
from mbproj.figures.style import SHADE, line, page_width, styled

#: The height of a row of panels, and the room for a method's name beside its costs, inches.
ROW, NAME = 1.65, 1.2
VIOLATIONS = (
    ("position_violation", r"$|C|_\infty$ (m or rad)"),
    ("velocity_violation", r"$|\dot{C}|_\infty$ (per s)"),
    ("acceleration_violation", r"$|\ddot{C}|_\infty$ (per s²)"),
)


@dataclass(frozen=True, eq=False)
class Compared:
    """The results of one method. Series over `time` (T,) are violations, error in m, and the cumulated parts of the
    energy drift in J (None after a failure). `seconds` are the median, smallest and largest, or None where costs are
    not compared in time. The rest are counters of the run."""

    label: str
    time: Array
    position_violation: Array
    velocity_violation: Array
    acceleration_violation: Array
    error: Array
    integrator: Array | None
    projection: Array | None
    seconds: tuple[float, float, float] | None
    factorisations: int
    iterations: int


@styled
def comparison_page(methods: Sequence[Compared], uncertainty: Array, remark: str) -> Figure:
    """Draw four rows of two panels. `uncertainty` (T,) in m is that of the reference, a floor for the errors."""
    heights = [ROW, ROW, ROW, 0.9 + 0.16 * len(methods)]
    figure = Figure(figsize=(page_width(), sum(heights)), layout="constrained")
    grid = figure.add_gridspec(4, 2, height_ratios=heights)
    axes = np.array([[figure.add_subplot(grid[row, column]) for column in (0, 1)] for row in range(4)])
    for axis, (name, title) in zip(axes.ravel(), VIOLATIONS, strict=False):
        for index, method in enumerate(methods):
            panels.plot_log(axis, method.time, getattr(method, name), method.label, index)
        axis.set_ylabel(title)
    _errors(axes[1, 1], methods, uncertainty)
    _energies(axes[2], methods)
    _costs(axes[3], methods)
    for axis in axes[:3].ravel():
        axis.set_xlabel(panels.TIME)
        axis.set_xlim(float(methods[0].time[0]), float(methods[0].time[-1]))
    return panels.finish(figure, remark=remark)


def _errors(axis: Axes, methods: Sequence[Compared], uncertainty: Array) -> None:
    """Draw the errors above the uncertainty of the reference."""
    for index, method in enumerate(methods):
        panels.plot_log(axis, method.time, method.error, method.label, index)
    floor = np.where(np.isfinite(uncertainty), uncertainty, np.nan).clip(panels.FLOOR)
    low = min(float(np.nanmin(floor[1:], initial=1.0)), axis.get_ylim()[1]) / 3.0
    axis.fill_between(methods[0].time, low, floor, color=SHADE, linewidth=0)
    place: dict[str, Any] = {"transform": axis.transAxes, "ha": "right", "fontsize": 7, "color": "#555555"}
    axis.text(0.98, 0.03, "uncertainty of the reference", **place)
    axis.set_ylim(bottom=low)
    axis.set_ylabel("error (m)")


def _energies(axes: Sequence[Axes], methods: Sequence[Compared]) -> None:
    """Draw the two parts of the drift on the same scale."""
    largest = 0.0
    parts = {"integrator": "|drift by the\nintegrator| (J)", "projection": "|work of the\nprojection| (J)"}
    for axis, (part, title) in zip(axes, parts.items(), strict=True):
        for index, method in enumerate(methods):
            values = getattr(method, part)
            if values is not None and (part == "integrator" or np.nanmax(np.abs(values)) > 0.0):
                panels.plot_log(axis, method.time[1:], values[1:], method.label, index)
                largest = max(largest, float(np.nanmax(np.abs(values))))
        axis.set_ylabel(title)
    for axis in axes:
        axis.set_yscale("log")
        top = 3.0 * max(largest, 1e-12)
        axis.set_ylim(max(1e-9 * top, panels.FLOOR), top)


def _costs(axes: Sequence[Axes], methods: Sequence[Compared]) -> None:
    """Draw a row for each method, the first on top: seconds with their spread, or factorisations; then iterations."""
    in_time = any(method.seconds for method in methods)
    rows = -np.arange(len(methods))
    for row, (index, method) in zip(rows, enumerate(methods), strict=True):
        colour = line(index)["color"]
        if in_time and method.seconds:
            middle, low, high = (1e3 * value for value in method.seconds)
            axes[0].plot([low, high], [row, row], color=colour, linewidth=3.0, alpha=0.35, solid_capstyle="butt")
            axes[0].plot([middle], [row], marker="o", markersize=4, color=colour)
        elif not in_time and method.factorisations:
            axes[0].plot([method.factorisations], [row], marker="s", markersize=4, color=colour)
        if method.factorisations and in_time:
            axes[1].plot([method.factorisations], [row], marker="s", markersize=4, color=colour)
        if method.iterations:
            axes[1].plot([method.iterations], [row], marker="x", markersize=4.5, color=colour)
    axes[0].set_xlabel("CPU time (ms): median and spread" if in_time else "factorisations\n(several formulations)")
    axes[1].set_xlabel("factorisations (■)\nprojection iterations (×)" if in_time else "projection iterations")
    for axis in axes:
        axis.set_ylim(rows[-1] - 0.6, 0.6)
        axis.set_xlim(left=0.0, right=1.08 * max(axis.get_xlim()[1], 1e-9))
        axis.xaxis.set_major_formatter(EngFormatter(sep=""))
        axis.set_yticks(rows)
        axis.grid(visible=False, axis="y")
    axes[0].set_yticklabels([fitted(method.label, NAME, 7.0, 2) for method in methods], fontsize=7)
    axes[1].set_yticklabels([])
