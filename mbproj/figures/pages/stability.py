"""A stability map: bands where each method holds, degrades and fails, and the largest violations and energy errors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.figures import panels
from mbproj.figures.fitted_text import fitted, literal
from mbproj.figures.margins import put_legend
from mbproj.figures.style import AXIS_HEIGHT, page_width, styled

#: The colours of the states, from light to dark, so that they can be told apart without colour.
FILLS = {"holds": "#CFE8DC", "degrades": "#EDB44B", "fails": "#A33B1F"}
BAND, HEIGHT = 0.26, 1.55
#: The room for a method's name, inches.
NAME = 1.2
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
    """The strips of all methods over the quantity that `label` names. `own` is the scene's value, `analytic` the limit
    of theory. A run holds while the opening of its joints is below `closed` and its energy error below `off`. Each is
    None where it does not apply."""

    strips: Sequence[Strip]
    label: str
    own: float | None
    analytic: float | None
    closed: float | None
    off: float | None


@styled
def stability_page(shown: Map, remark: str) -> Figure:
    """Draw the bands above, the largest violation and the energy error below, as far as there are any."""
    has_energy = any(np.any(np.isfinite(strip.energy)) for strip in shown.strips)
    heights = [0.3 + BAND * len(shown.strips), *([HEIGHT] * (1 + has_energy))]
    figure = Figure(figsize=(page_width(), sum(heights) + AXIS_HEIGHT), layout="constrained")
    axes = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    _bands(axes[0], shown)
    _series(axes[1], shown, "closure", shown.closed)
    axes[1].set_ylabel("$|C|$ (lengths, rad)")
    if has_energy:
        _series(axes[2], shown, "energy", shown.off)
        axes[2].set_ylabel("energy off by (1)")
    axes[-1].set(xscale="log", xlabel=literal(shown.label))
    for axis in axes:
        if shown.analytic is not None:
            axis.axvline(shown.analytic, color="#000000", linewidth=1.0, linestyle=(0, (5, 2)), label="theory")
        if shown.own is not None:
            axis.axvline(shown.own, color="#000000", linewidth=0.9, linestyle=(0, (1, 1.5)), label="the scene's own")
    return _with_legend(figure, axes, remark)


def _bands(axis: Axes, shown: Map) -> None:
    for row, strip in enumerate(shown.strips):
        middles = np.sqrt(strip.value[1:] * strip.value[:-1])
        edges = np.concatenate([strip.value[:1], middles, strip.value[-1:]])
        for first, last, state in _runs(strip.state):
            left, right = edges[first], edges[last + 1]
            axis.barh(row, right - left, left=left, height=0.74, color=FILLS[state], linewidth=0)
    axis.set_yticks(range(len(shown.strips)), [fitted(strip.name, NAME, 8.0, 2) for strip in shown.strips])
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


def _series(axis: Axes, shown: Map, name: str, limit: float | None) -> None:
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
