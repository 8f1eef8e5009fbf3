"""A page on a design: the matched data beside the best design, the course of the searches, and the correlations of its
numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.figures.fitted_text import fitted
from mbproj.figures.style import line, page_width, styled
from mbproj.results.design_file import Drawn, Matched

#: The height of a row of panels and the room for a name beside a matrix, inches; the most numbers whose correlations
#: are written into the cells.
ROW, NAME, WRITTEN = 2.3, 1.0, 8
#: The room for the legend of a front, inches.
ABOVE = 0.5


def whole_page(drawn: Drawn) -> Figure:
    """Draw a design on one page: its front, or a row for each match, then searches and correlations."""
    return _front(drawn) if drawn.front is not None else _page(drawn)


def why_not(kind: str, drawn: Drawn) -> str | None:
    """The reason why a picture does not apply; None where it does."""
    missing: Mapping[str, tuple[bool, str]] = {
        "fit": (not drawn.matches, "the design matches nothing"),
        "convergence": (not any(len(trace) for trace in drawn.traces), "no search has a course to draw"),
        "correlation": (drawn.correlation is None, "correlations follow only from data that is matched"),
        "front": (drawn.front is None, "the design has one goal alone"),
    }
    is_missing, reason = missing[kind]
    return reason if is_missing else None


@styled
def _page(drawn: Drawn) -> Figure:
    rows = len(drawn.matches) + 1
    figure = Figure(figsize=(page_width(), ROW * rows), layout="constrained")
    grid = figure.add_gridspec(rows, 2)
    for row, match in enumerate(drawn.matches):
        _match(figure.add_subplot(grid[row, 0]), match)
        _residuals(figure.add_subplot(grid[row, 1]), match)
    last = grid[rows - 1, 0] if drawn.correlation is not None else grid[rows - 1, :]
    _searches(figure.add_subplot(last), drawn.traces, drawn.value)
    if drawn.correlation is not None:
        _correlation(figure.add_subplot(grid[rows - 1, 1]), drawn.names, drawn.correlation)
    return panels.finish(figure, remark=drawn.remark, with_legend=False)


@styled
def _fit(drawn: Drawn) -> Figure:
    """Draw a row for each match, with its residuals."""
    figure = Figure(figsize=(page_width(), ROW * len(drawn.matches)), layout="constrained")
    for (left, right), match in zip(figure.subplots(len(drawn.matches), 2, squeeze=False), drawn.matches, strict=True):
        _match(left, match)
        _residuals(right, match)
    return panels.finish(figure, remark=drawn.remark, with_legend=False)


@styled
def _convergence(drawn: Drawn) -> Figure:
    figure = Figure(figsize=(page_width(), 1.3 * ROW), layout="constrained")
    _searches(figure.add_subplot(), drawn.traces, drawn.value)
    return panels.finish(figure, remark=drawn.remark, with_legend=False)


@styled
def _dependence(drawn: Drawn) -> Figure:
    assert drawn.correlation is not None
    side = min(page_width(), 2.2 + 0.35 * len(drawn.names))
    figure = Figure(figsize=(side, 0.8 * side), layout="constrained")
    _correlation(figure.add_subplot(), drawn.names, drawn.correlation)
    return panels.finish(figure, remark=drawn.remark, with_legend=False)


@styled
def _front(drawn: Drawn) -> Figure:
    """Draw each further goal over the first goal. The first design is the chosen one."""
    assert drawn.front is not None
    names, goals = drawn.goals, drawn.front
    figure = Figure(figsize=(page_width(), ROW * (len(names) - 1) + ABOVE), layout="constrained")
    axes = figure.subplots(len(names) - 1, 1, sharex=True, squeeze=False)[:, 0]
    for axis, goal, name in zip(axes, goals.T[1:], names[1:], strict=True):
        axis.plot(goals[:, 0], goal, "o", color=line(0)["color"], markersize=3.5, label="front")
        axis.plot(goals[:1, 0], goal[:1], "D", color=line(1)["color"], markersize=6, label="the most balanced")
        axis.set_ylabel(name)
        axis.margins(x=0.03)
    axes[-1].set_xlabel(names[0])
    return panels.finish(figure, remark=drawn.remark)


def _match(axis: Axes, match: Matched) -> None:
    if match.abscissa is None or (len(match.components) == 2 and match.unit == "m"):
        axis.plot(match.reached[:, 0], match.reached[:, -1], color=line(0)["color"], linewidth=1.2, label="design")
        axis.plot(match.given[:, 0], match.given[:, -1], "o", color="#222222", markersize=2.6, label="given")
        axis.set_aspect("equal", adjustable="datalim")
        axis.set_xlabel(f"{match.name}: {match.components[0]} ({match.unit})")
        axis.set_ylabel(f"{match.components[-1]} ({match.unit})")
    else:
        for index, component in enumerate(match.components):
            style = line(index)
            label = f"design, {component}" if component else "design"
            axis.plot(match.abscissa, match.reached[:, index], color=style["color"], linewidth=1.2, label=label)
            colour = style["color"] if len(match.components) > 1 else "#222222"
            axis.plot(
                match.abscissa,
                match.given[:, index],
                "o",
                color=colour,
                markersize=2.6,
                label=None if index else "given",
            )
        axis.set_xlabel(match.along)
        axis.set_ylabel(f"{match.name} ({match.unit})" if match.unit else match.name)
    axis.legend(loc="best")


def _residuals(axis: Axes, match: Matched) -> None:
    over = np.arange(len(match.given)) if match.abscissa is None else match.abscissa
    for index, component in enumerate(match.components):
        off = match.reached[:, index] - match.given[:, index]
        axis.plot(over, off, ".", color=line(index)["color"], markersize=4, label=component or None)
    axis.axhline(0.0, color="#888888", linewidth=0.6)
    axis.set_xlabel("point" if match.abscissa is None else match.along)
    axis.set_ylabel(f"design - given ({match.unit})" if match.unit else "design - given")
    axis.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3), useMathText=True)
    if len(match.components) > 1:
        axis.legend(loc="best")


def _searches(axis: Axes, traces: Sequence[Array], value: str) -> None:
    """Draw the course of all searches, with the best in front."""
    low = min((float(trace[:, 1].min()) for trace in traces if len(trace)), default=1.0)
    logarithmic = low > 0.0 and value.startswith("rms")
    for index, trace in reversed(list(enumerate(traces))):
        if len(trace):
            colour, width, label = ("#AAAAAA", 0.7, None) if index else (line(0)["color"], 1.4, "best")
            axis.step(trace[:, 0], trace[:, 1], where="post", color=colour, linewidth=width, label=label)
    if logarithmic:
        axis.set_yscale("log")
    axis.set_xlabel("runs of a search")
    axis.set_ylabel(value)
    axis.legend(loc="best")


def _correlation(axis: Axes, names: Sequence[str], correlation: Array) -> None:
    drawn = axis.imshow(correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
    short = [fitted(name, NAME, 7.0) for name in names]
    axis.set_xticks(range(len(names)), short, rotation=90, fontsize=7)
    axis.set_yticks(range(len(names)), short, fontsize=7)
    axis.grid(visible=False)
    if len(names) <= WRITTEN:
        for (row, column), share in np.ndenumerate(correlation):
            colour = "white" if abs(share) > 0.6 else "#222222"
            axis.text(column, row, f"{share:.2f}", ha="center", va="center", fontsize=6, color=colour)
    axis.figure.colorbar(drawn, ax=axis, label="correlation", shrink=0.9)


#: The pictures by kind, for `mbproj plot`.
PICTURES: Mapping[str, Callable[[Drawn], Figure]] = {
    "fit": _fit,
    "convergence": _convergence,
    "correlation": _dependence,
    "front": _front,
}
