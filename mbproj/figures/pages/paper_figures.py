"""The figures of Zhang, Liu & Liu (2015), sect. 5: position and velocity of a point (2, 3, 7, 8), and the constraint
errors of several methods (4, 5, 9, 10). Arrays in, a Figure out; `save` writes it."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.figures.style import SHADE, styled

HEIGHT = 3.0
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
    figure = _errors(series, r"position error $|C|_\infty$ (m or rad)")
    return _finished(figure, _longest(series), unconverged_from, unconverged_error)


@styled
def velocity_errors(
    series: Mapping[str, Series], *, unconverged_from: float | None = None, unconverged_error: str = "1 mm"
) -> Figure:
    """Draws the violation |Ċ|∞ of several methods, by name, over time on a logarithmic axis (Figs. 5, 10)."""
    figure = _errors(series, r"velocity error $|\dot{C}|_\infty$ (m/s or rad/s)")
    return _finished(figure, _longest(series), unconverged_from, unconverged_error)


def _history(time: Array, values: Array, components: str, reads: str, name: str) -> Figure:
    figure, axes = panels.panels(1, height=HEIGHT)
    for component in components:
        index = COMPONENTS.index(component)
        panels.plot(axes[0, 0], time, values[:, index], "", index)
        axes[0, 0].lines[-1].set_label(reads.format(component))
    axes[0, 0].set_ylabel(name)
    return figure


def _errors(series: Mapping[str, Series], name: str) -> Figure:
    figure, axes = panels.panels(1, height=HEIGHT)
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
