"""Work-precision diagrams of a trade-off: error over cost, and the violation on an axis of its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, LogLocator, NullFormatter

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.figures import panels
from mbproj.figures.fitted_text import fitted, literal
from mbproj.figures.margins import put_legend, small_print
from mbproj.figures.style import SHADE, label_size, line, page_width, styled

#: The height of a row of panels, inches.
ROW = 2.4
MARKS = "osD^vPX<>*h"
#: An axis with a smaller ratio of its limits has labels between the powers of ten.
NARROW = 50.0


@dataclass(frozen=True, eq=False)
class Cloud:
    """Settings (N,): evaluations of the accelerations, CPU time in s (NaN where not timed alone), error in m,
    violation."""

    evaluations: Array
    seconds: Array
    error: Array
    violation: Array


@dataclass(frozen=True, eq=False)
class Diagram:
    """The data of the diagrams. `by_integrator` has clouds by integrator and kind of step ("rk4, fixed steps"), `timed`
    all timed settings, `by_projection` those of one `integrator`. `front` (F, 2) and the scene's `own` setting are
    (seconds, error). `floor` is the uncertainty of the reference in m; `points` names where the error is measured."""

    by_integrator: Mapping[str, Cloud]
    timed: Cloud
    by_projection: Mapping[str, Cloud]
    integrator: str
    front: Array
    own: tuple[float, float] | None
    floor: float
    points: str


@styled
def work_precision(shown: Diagram, remark: str) -> Figure:
    """Draw two rows: integrators over evaluations and over CPU time; then error and violation of one integrator's
    projections."""
    figure = Figure(figsize=(page_width(), 2 * ROW), layout="constrained")
    error = fitted(f"error of {shown.points} (m)", ROW - 0.6, label_size(), 2)
    parts = figure.subfigures(2, 1, squeeze=False)
    upper, lower = parts[0, 0], parts[1, 0]
    (left, right), (errors, violations) = upper.subplots(1, 2, sharey=True), lower.subplots(1, 2, sharex=True)
    _front(right, shown)
    names = list(dict.fromkeys(label.partition(",")[0] for label in shown.by_integrator))
    for label, cloud in shown.by_integrator.items():
        name, _, kind = label.partition(", ")
        index = names.index(name)
        look = {**_look(index), "linestyle": "-"}
        look |= {"linestyle": "--", "markerfacecolor": "white"} if kind == "fixed steps" else {}
        _cloud(left, cloud.evaluations, cloud.error, label, look)
        _cloud(right, 1e3 * cloud.seconds, cloud.error, label, {**look, "linestyle": "none"})
    for index, (label, cloud) in enumerate(shown.by_projection.items()):
        _cloud(errors, cloud.evaluations, cloud.error, label, _look(index))
        _cloud(violations, cloud.evaluations, cloud.violation, label, _look(index))
    for axis in (left, right, errors):
        _floor(axis, shown.floor)
    left.set(xlabel="evaluations", ylabel=error)
    right.set(xlabel="CPU time of the steps (ms)")
    errors.set(xlabel=f"evaluations, {shown.integrator}", ylabel=error)
    violations.set(xlabel=f"evaluations, {shown.integrator}", ylabel="violation $|C|_\\infty$ (m or rad)")
    for axis in (left, right, errors, violations):
        _decades(axis)
    for part, axes in ((upper, (left, right)), (lower, (errors,))):
        put_legend(part, panels.legend_entries(axes))
    small_print(figure, remark)
    return figure


@styled
def search_page(
    families: Mapping[str, Array], best: tuple[float, float], goal: float, floor: float, remark: str
) -> Figure:
    """Draw what a search has measured: error in m over evaluations of settings (N, 2) by integrator and kind of step.
    A line is at the error that was asked for, and a star at the `best` setting."""
    figure = Figure(figsize=(page_width(), 1.5 * ROW), layout="constrained")
    axis = figure.subplots()
    for index, (label, settings) in enumerate(families.items()):
        fixed = {"markerfacecolor": "white"} if label.endswith("fixed steps") else {}
        _cloud(axis, settings[:, 0], settings[:, 1], label, {**_look(index), "linestyle": "none", **fixed})
    axis.axhline(goal, color="#555555", linewidth=0.9, linestyle=(0, (4, 2)), label="asked for", zorder=1.5)
    _star(axis, best, "recommended")
    _floor(axis, floor)
    axis.set(xlabel="evaluations", ylabel="error (m)")
    _decades(axis)
    put_legend(figure, panels.legend_entries((axis,)))
    small_print(figure, remark)
    return figure


def _look(index: int) -> dict[str, Any]:
    """The colour, dashes and mark of the line number `index`."""
    return {**line(index), "marker": MARKS[index % len(MARKS)], "markersize": 3.2, "linewidth": 0.9}


def _cloud(axis: Axes, cost: Array, value: Array, label: str, look: dict[str, Any]) -> None:
    """Draw settings in the order of their cost."""
    kept = np.isfinite(cost) & np.isfinite(value)
    order = np.argsort(cost[kept], kind="stable")
    values = np.where(value[kept] < panels.FLOOR, panels.FLOOR, value[kept])
    axis.plot(cost[kept][order], values[order], label=literal(label), **look)
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.margins(0.04)


def _front(axis: Axes, shown: Diagram) -> None:
    """Draw all timed settings, a staircase along the front, and a star for the scene's own setting."""
    grey = {"color": "#B0B0B0", "marker": "o", "markersize": 2.0, "linestyle": "none", "zorder": 1.4}
    _cloud(axis, 1e3 * shown.timed.seconds, shown.timed.error, "timed, other projections", grey)
    if len(shown.front):
        steps: dict[str, Any] = {"color": "#555555", "linewidth": 0.9, "zorder": 1.5}
        axis.plot(1e3 * shown.front[:, 0], shown.front[:, 1], drawstyle="steps-post", label="front", **steps)
    if shown.own is not None:
        _star(axis, (1e3 * shown.own[0], shown.own[1]), "the scene's own")


def _star(axis: Axes, place: tuple[float, float], label: str) -> None:
    star: dict[str, Any] = {"marker": "*", "markersize": 10, "markeredgecolor": "black", "linestyle": "none"}
    axis.plot(*place, label=label, zorder=3, color="#E69F00", **star)


def _decades(axis: Axes) -> None:
    """Label only powers of ten; where there are few of them, also 2 and 5 times as much."""
    low, high = axis.get_xlim()
    axis.xaxis.set_minor_formatter(NullFormatter())
    if high < NARROW * low:
        axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.xaxis.set_major_formatter(EngFormatter(sep=""))


def _floor(axis: Axes, floor: float) -> None:
    """Shade the errors below the uncertainty of the reference, if there is any."""
    if floor == 0.0:
        return
    low = min(axis.get_ylim()[0], floor / 3.0)
    axis.axhspan(low / 10.0, floor, color=SHADE, linewidth=0, zorder=0)
    axis.set_ylim(bottom=low)
    place: dict[str, Any] = {"transform": axis.transAxes, "fontsize": 7, "color": "#555555"}
    axis.text(0.02, 0.04, "uncertainty of the reference", **place)
