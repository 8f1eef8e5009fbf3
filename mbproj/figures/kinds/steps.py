"""The steps of a run: their size, and the iterations of the projection in each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array, Flags
from mbproj.figures import panels
from mbproj.figures.style import styled
from mbproj.results import Results

ITERATIONS = (
    ("diagnostics/projection_iterations", "position iterations a step"),
    ("diagnostics/velocity_iterations", "velocity iterations a step"),
)
REJECTED = "×: steps were rejected since the sample before"
#: The ratio of the largest to the smallest step from which on the axis is logarithmic.
WIDE = 20.0


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw three panels with a line for each result. Iterations are averages over the steps between two samples.
    Samples inside one step share that step's value."""
    figure, axes = panels.panels(3)
    sizes, remark = [result["diagnostics/step_size"] for result in results], ""
    for index, (result, label) in enumerate(zip(results, labels, strict=True)):
        panels.plot(axes[0, 0], result.time, sizes[index], label, index, drawstyle="steps-pre")
        after = rejected(result)
        if after.any():
            crosses = {"linestyle": "none", "marker": "x", "markersize": 4}
            panels.plot(axes[0, 0], result.time[after], sizes[index][after], "", index, **crosses)
            remark = REJECTED
        for axis, (path, _) in zip(axes[1:, 0], ITERATIONS, strict=True):
            panels.plot(axis, result.time, _filled_forward(per_step(result, path)), label, index, drawstyle="steps-pre")
    for axis, (_, name) in zip(axes[1:, 0], ITERATIONS, strict=True):
        panels.name(axis, name)
        _from_zero(axis)
    panels.name(axes[0, 0], "step size", "s")
    _scale(axes[0, 0], np.concatenate(sizes))
    return panels.finish(figure, remark=remark, with_legend=len(results) > 1)


def rejected(result: Results) -> Flags:
    """Mark the samples (T,) that have rejected steps between the sample before and themselves."""
    count = result["diagnostics/rejected_steps"]
    is_rejected: Flags = np.diff(count, prepend=count[:1]) > 0
    return is_rejected


def per_step(result: Results, path: str) -> Array:
    """The increase of a counter over that of the steps since the sample before (T); NaN where no step ended."""
    growth, steps = (np.diff(result[name], prepend=np.nan) for name in (path, "diagnostics/steps"))
    rate: Array = np.divide(growth, steps, out=np.full(len(steps), np.nan), where=steps > 0)
    return rate


def _filled_forward(rates: Array) -> Array:
    """Replace each NaN by the last number before it, where there is one."""
    last = np.maximum.accumulate(np.where(np.isnan(rates), 0, np.arange(len(rates))))
    return rates[last]


def _scale(axis: Axes, sizes: Array) -> None:
    positive = sizes[sizes > 0]
    if len(positive) and positive.max() > WIDE * positive.min():
        axis.set_yscale("log")
    else:
        _from_zero(axis)


def _from_zero(axis: Axes) -> None:
    """Set the limits a little beyond zero and the top, so that lines there are fully visible."""
    high = 1.05 * axis.get_ylim()[1]
    axis.set_ylim(-0.04 * high, high)
