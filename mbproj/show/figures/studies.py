"""Pictures of studies: methods compared, the figures of the paper, stability maps, thresholds, trade-offs, and
expectations.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import EngFormatter, LogLocator, NullFormatter

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.show.figures import panels
from mbproj.show.figures.fitted_text import fitted, literal
from mbproj.show.figures.panels import put_legend, small_print
from mbproj.show.figures.style import AXIS_HEIGHT, SHADE, label_size, line, page_width, styled

# --- Methods compared: violations, errors, the two parts of the energy drift, and costs -------------------------------

#: The height of a row of panels, and the room for a method's name beside its costs, inches.
METHOD_ROW, METHOD_NAME = 1.65, 1.2
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
    heights = [METHOD_ROW, METHOD_ROW, METHOD_ROW, 0.9 + 0.16 * len(methods)]
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
        if not in_time or axis is axes[1]:  # thousands of counts; milliseconds have their prefix already
            axis.xaxis.set_major_formatter(EngFormatter(sep=""))
        axis.set_yticks(rows)
        axis.grid(visible=False, axis="y")
    axes[0].set_yticklabels([fitted(method.label, METHOD_NAME, 7.0, 2) for method in methods], fontsize=7)
    axes[1].set_yticklabels([])


# --- The figures of Zhang, Liu & Liu (2015), sect. 5 ------------------------------------------------------------------
# Position and velocity of a point (2, 3, 7, 8), and the constraint errors of several methods (4, 5, 9, 10). Arrays
# in, a Figure out; `save` writes it.


PANEL_HEIGHT = 3.0
COMPONENTS = "xyz"
#: The times (T) in s and the violations (T) of a method.
Series = tuple[Array, Array]


@styled
def position_history(
    time: Array,
    position: Array,
    *,
    components: str = COMPONENTS,
    unconverged_from: float | None = None,
    unconverged_error: str = "1 mm",
) -> Figure:
    """Draws the position (T, 3) in m of a point over time (T) in s (Figs. 2, 7), only the `components` named."""
    figure = _history(time, position, components, "{}", "position (m)")
    return _finished(figure, time, unconverged_from, unconverged_error)


@styled
def velocity_history(
    time: Array,
    velocity: Array,
    *,
    components: str = COMPONENTS,
    unconverged_from: float | None = None,
    unconverged_error: str = "1 mm",
) -> Figure:
    """Draws the velocity (T, 3) in m/s of a point over time (T) in s (Figs. 3, 8), only the `components` named."""
    figure = _history(time, velocity, components, "$v_{}$", "velocity (m/s)")
    return _finished(figure, time, unconverged_from, unconverged_error)


@styled
def position_errors(
    series: Mapping[str, Series], *, unconverged_from: float | None = None, unconverged_error: str = "1 mm"
) -> Figure:
    """Draws the violation |C|∞ of several methods, by name, over time on a logarithmic axis (Figs. 4, 9)."""
    figure = _error_figure(series, r"position error $|C|_\infty$ (m or rad)")
    return _finished(figure, _longest(series), unconverged_from, unconverged_error)


@styled
def velocity_errors(
    series: Mapping[str, Series], *, unconverged_from: float | None = None, unconverged_error: str = "1 mm"
) -> Figure:
    """Draws the violation |Ċ|∞ of several methods, by name, over time on a logarithmic axis (Figs. 5, 10)."""
    figure = _error_figure(series, r"velocity error $|\dot{C}|_\infty$ (m/s or rad/s)")
    return _finished(figure, _longest(series), unconverged_from, unconverged_error)


def _history(time: Array, values: Array, components: str, reads: str, name: str) -> Figure:
    figure, axes = panels.panels(1, height=PANEL_HEIGHT)
    for component in components:
        index = COMPONENTS.index(component)
        panels.plot(axes[0, 0], time, values[:, index], "", index)
        axes[0, 0].lines[-1].set_label(reads.format(component))
    axes[0, 0].set_ylabel(name)
    return figure


def _error_figure(series: Mapping[str, Series], name: str) -> Figure:
    figure, axes = panels.panels(1, height=PANEL_HEIGHT)
    for index, (method, (time, values)) in enumerate(series.items()):
        panels.plot_log(axes[0, 0], time, values, method, index)
    axes[0, 0].set_ylabel(name)
    return figure


def _longest(series: Mapping[str, Series]) -> Array:
    return max((time for time, _ in series.values()), key=lambda time: float(time[-1]))


def _finished(figure: Figure, time: Array, unconverged_from: float | None, error: str) -> Figure:
    """Add the legend, and shade the times from which on the step has not converged."""
    axis: Axes = figure.axes[0]
    if unconverged_from is not None and unconverged_from < time[-1]:
        text = f"step not converged from t = {unconverged_from:.3g} s on (error > {error})"
        axis.axvspan(unconverged_from, float(time[-1]), color=SHADE, linewidth=0, zorder=0)
        axis.set_title(text, loc="right", fontsize=7.5, color="#555555")
    return panels.finish(figure)


# --- A stability map --------------------------------------------------------------------------------------------------
# Bands where each method holds, degrades and fails, and the largest violations and energy errors.


#: The colours of the states, from light to dark, so that they can be told apart without colour.
FILLS = {"holds": "#CFE8DC", "degrades": "#EDB44B", "fails": "#A33B1F"}
BAND, BAND = 0.26, 1.55
#: The room for a method's name, inches.
NAMES = 1.2
#: Violations and energy errors above this are not drawn: nothing is left of the motion.
HIGHEST = 1e2


@dataclass(frozen=True, eq=False)
class Strip:
    """The points of one method: values (N,) with their states (N,). `closure` is the largest opening of joints
    (lengths, rad), `energy` the relative energy error, (N,); NaN where there is none."""

    name: str
    value: Array
    state: tuple[str, ...]
    closure: Array
    energy: Array


@dataclass(frozen=True, eq=False)
class Map:
    """The strips of all methods over the quantity that `label` names. `preset` is the scene's value, `analytic` the
    limit of theory. A run holds while the opening of its joints is below `closed` and its energy error below `off`.
    Each is None where it does not apply."""

    strips: Sequence[Strip]
    label: str
    preset: float | None
    analytic: float | None
    closed: float | None
    off: float | None


@styled
def stability_page(shown: Map, remark: str) -> Figure:
    """Draw the bands above, the largest violation and the energy error below, as far as there are any."""
    has_energy = any(np.any(np.isfinite(strip.energy)) for strip in shown.strips)
    heights = [0.3 + BAND * len(shown.strips), *([BAND] * (1 + has_energy))]
    figure = Figure(figsize=(page_width(), sum(heights) + AXIS_HEIGHT), layout="constrained")
    axes = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    _bands(axes[0], shown)
    _strips(axes[1], shown, "closure", shown.closed)
    axes[1].set_ylabel("$|C|$ (lengths, rad)")
    if has_energy:
        _strips(axes[2], shown, "energy", shown.off)
        axes[2].set_ylabel("energy off by (1)")
    axes[-1].set(xscale="log", xlabel=literal(shown.label))
    for axis in axes:
        if shown.analytic is not None:
            axis.axvline(shown.analytic, color="#000000", linewidth=1.0, linestyle=(0, (5, 2)), label="theory")
        if shown.preset is not None:
            axis.axvline(shown.preset, color="#000000", linewidth=0.9, linestyle=(0, (1, 1.5)), label="the scene's own")
    return _with_legend(figure, axes, remark)


def _bands(axis: Axes, shown: Map) -> None:
    for row, strip in enumerate(shown.strips):
        middles = np.sqrt(strip.value[1:] * strip.value[:-1])
        edges = np.concatenate([strip.value[:1], middles, strip.value[-1:]])
        for first, last, state in _runs(strip.state):
            left, right = edges[first], edges[last + 1]
            axis.barh(row, right - left, left=left, height=0.74, color=FILLS[state], linewidth=0)
    axis.set_yticks(range(len(shown.strips)), [fitted(strip.name, NAMES, 8.0, 2) for strip in shown.strips])
    axis.set_ylim(len(shown.strips) - 0.5, -0.5)
    axis.set_xscale("log")
    axis.grid(visible=False, axis="y")
    axis.tick_params(axis="y", length=0)


def _runs(states: Sequence[str]) -> list[tuple[int, int, str]]:
    """The runs of equal states: first index, last index, state."""
    runs: list[tuple[int, int, str]] = []
    for index, state in enumerate(states):
        if runs and runs[-1][2] == state:
            runs[-1] = (runs[-1][0], index, state)
        else:
            runs.append((index, index, state))
    return runs


def _strips(axis: Axes, shown: Map, name: str, limit: float | None) -> None:
    for index, strip in enumerate(shown.strips):
        values = np.asarray(getattr(strip, name))
        inside = np.where(values <= HIGHEST, values, np.nan)
        panels.plot_log(axis, strip.value, inside, strip.name, index)
    if limit is not None:
        axis.axhline(limit, color="#777777", linewidth=0.9, linestyle=(0, (4, 2)), label="limit of what holds")


def _with_legend(figure: Figure, axes: Iterable[Axes], remark: str) -> Figure:
    """Add one legend of states and lines above, and the small print below."""
    figure = panels.finish(figure, remark=remark, with_legend=False)
    states = {state: Patch(facecolor=fill, edgecolor="#555555", linewidth=0.4) for state, fill in FILLS.items()}
    put_legend(figure, {**states, **panels.legend_entries(list(axes))})
    return figure


# --- The effect of a projection's threshold on error and violation, projections, and cost -----------------------------


THRESHOLD_HEIGHT = 1.6
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
    figure = Figure(figsize=(page_width(), 3 * THRESHOLD_HEIGHT + AXIS_HEIGHT), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    axes[0].set_xscale("log")  # before the lines: around a single threshold, linear limits would be negative
    _curve(axes[0], shown.threshold, shown.error, "error (m)", 0)
    _curve(axes[0], shown.threshold, shown.position_violation, "$|C|_\\infty$ (m or rad)", 1)
    _curve(axes[0], shown.threshold, shown.velocity_violation, "$|\\dot{C}|_\\infty$ (per s)", 3)
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


def _curve(axis: Axes, threshold: Array, values: Array, label: str, index: int) -> None:
    shown = np.where(values < panels.FLOOR, panels.FLOOR, values)
    axis.plot(threshold, shown, label=label, marker="o", markersize=3, **line(index))


def _level(axis: Axes, value: float, label: str, dashes: tuple[int, tuple[int, ...]]) -> None:
    """Draw a horizontal line for a value that does not depend on the threshold."""
    if np.isfinite(value):
        axis.axhline(value, color="#777777", linewidth=0.9, linestyle=dashes, label=label, zorder=1.0)


# --- Work-precision diagrams of a trade-off ---------------------------------------------------------------------------
# Error over cost, and the violation on an axis of its own.


#: The height of a row of panels, inches.
DIAGRAM_HEIGHT = 2.4
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
    all timed settings, `by_projection` those of one `integrator`. `front` (F, 2) and `scene_setting` are
    (seconds, error). `floor` is the uncertainty of the reference in m; `points` names where the error is measured."""

    by_integrator: Mapping[str, Cloud]
    timed: Cloud
    by_projection: Mapping[str, Cloud]
    integrator: str
    front: Array
    scene_setting: tuple[float, float] | None
    floor: float
    points: str


@styled
def work_precision(shown: Diagram, remark: str) -> Figure:
    """Draw two rows: integrators over evaluations and over CPU time; then error and violation of one integrator's
    projections."""
    figure = Figure(figsize=(page_width(), 2 * DIAGRAM_HEIGHT), layout="constrained")
    error = fitted(f"error of {shown.points} (m)", DIAGRAM_HEIGHT - 0.6, label_size(), 2)
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
    figure = Figure(figsize=(page_width(), 1.5 * DIAGRAM_HEIGHT), layout="constrained")
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
    finite = np.isfinite(cost) & np.isfinite(value)
    order = np.argsort(cost[finite], kind="stable")
    values = np.where(value[finite] < panels.FLOOR, panels.FLOOR, value[finite])
    axis.plot(cost[finite][order], values[order], label=literal(label), **look)
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
    if shown.scene_setting is not None:
        _star(axis, (1e3 * shown.scene_setting[0], shown.scene_setting[1]), "the scene's own")


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


# --- A picture of many expectations -----------------------------------------------------------------------------------
# The part of its allowed error that each uses, the largest on top.


#: The height of a row and of the rest, and the room for a name, inches; the most rows.
EXPECTATION_ROW, AROUND, EXPECTATION_NAME, MOST = 0.2, 0.75, 2.6, 40
#: Smaller and larger parts are drawn at these.
LEAST, LARGEST = 1e-9, 1e6


@styled
def draw_expectations(shares: Mapping[str, float]) -> Figure:
    """Draw a dot for each expectation by its name, at the part of its allowed error that it uses. An expectation beyond
    the line at 1 is not met. A part below 1e-9, or none at all, is drawn at 1e-9; a missing sample is drawn at 1e6."""
    shown = sorted(shares.items(), key=lambda item: -item[1])[:MOST]
    figure = Figure(figsize=(page_width(), AROUND + EXPECTATION_ROW * len(shown)), layout="constrained")
    axis = figure.subplots()
    axis.set_xscale("log")
    for place, (_, share) in enumerate(shown):
        axis.plot([min(max(share, LEAST), LARGEST)], [place], "o", markersize=4, color=line(share > 1.0)["color"])
    axis.axvline(1.0, color="#444444", linewidth=1.0)
    axis.margins(x=0.05)
    axis.set_yticks(range(len(shown)), [fitted(name, EXPECTATION_NAME, 8.0) for name, _ in shown])
    axis.invert_yaxis()
    axis.set_xlabel("error / allowed error")
    cut = len(shares) - len(shown)
    remark = f"without the {cut} expectations that use the smallest parts" if cut else ""
    return panels.finish(figure, remark=remark, with_legend=False)
