"""What the run did to get on: step size, and iterations of the projection per step."""

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
#: From this ratio of the largest step to the smallest on, the axis is logarithmic.
WIDE = 20.0


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Three panels, a line a result. Iterations are averages over the steps between two samples; where no step ended
    between them, those of the step before, in which they lie."""
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
            panels.plot(axis, result.time, _held(per_step(result, path)), label, index, drawstyle="steps-pre")
    for axis, (_, name) in zip(axes[1:, 0], ITERATIONS, strict=True):
        panels.name(axis, name)
        _from_zero(axis)
    panels.name(axes[0, 0], "step size", "s")
    _scale(axes[0, 0], np.concatenate(sizes))
    return panels.finish(figure, remark=remark, with_legend=len(results) > 1)


def rejected(result: Results) -> Flags:
    """At which samples steps had been rejected since the sample before, (T,)."""
    count = result["diagnostics/rejected_steps"]
    found: Flags = np.diff(count, prepend=count[:1]) > 0
    return found


def per_step(result: Results, path: str) -> Array:
    """The counter's growth over the steps' since the sample before (T); NaN where there was no step."""
    growth, steps = (np.diff(result[name], prepend=np.nan) for name in (path, "diagnostics/steps"))
    rate: Array = np.divide(growth, steps, out=np.full(len(steps), np.nan), where=steps > 0)
    return rate


def _held(rates: Array) -> Array:
    """Each rate that is not a number replaced by the last one before it that is, where there is one."""
    last = np.maximum.accumulate(np.where(np.isnan(rates), 0, np.arange(len(rates))))
    return rates[last]


def _scale(axis: Axes, sizes: Array) -> None:
    positive = sizes[sizes > 0]
    if len(positive) and positive.max() > WIDE * positive.min():
        axis.set_yscale("log")
    else:
        _from_zero(axis)


def _from_zero(axis: Axes) -> None:
    """Show zero and the top a little inside the edges, so that lines there are whole."""
    high = 1.05 * axis.get_ylim()[1]
    axis.set_ylim(-0.04 * high, high)
