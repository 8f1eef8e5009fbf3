"""Figures on which a designer decides: the designs that a search found, the profile of a cam, the sensitivities of
measures, and the loads of actuators. Each part takes the numbers that a command has computed, and draws one page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import degrees, inf
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mbproj.base.arrays import Array
from mbproj.results.design_file import Drawn, Matched
from mbproj.results.largest_loads import Cycle
from mbproj.results.views import Table
from mbproj.scene.blocks.curve_sheet import Sheet
from mbproj.show.figures import panels
from mbproj.show.figures.fitted_text import fitted
from mbproj.show.figures.panels import by_turns, in_degrees, label_of
from mbproj.show.figures.style import AXIS_HEIGHT, line, page_width, styled, tick_degrees

# --- A design: data that it matches, the course of the searches, correlations of its numbers, fronts of goals ---------

#: The height of a row of panels and the room for a name beside a matrix, inches; the most numbers whose correlations
#: are written into the cells.
ROW, NAME, WRITTEN = 2.3, 1.0, 8
#: The room for the legend of a front, inches.
ABOVE = 0.5


def whole_page(drawn: Drawn) -> Figure:
    """Draw a design on one page: its front, or a row for each match, then searches and correlations."""
    return _front(drawn) if drawn.front is not None else _page(drawn)


def why_not(kind: str, drawn: Drawn) -> str | None:
    """The reason why the picture of this kind, one of PICTURES, does not apply to a design; None where it does."""
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
    """Draw a row for each match, and a last one with the searches and the correlations."""
    rows = len(drawn.matches) + 1
    figure = Figure(figsize=(page_width(), ROW * rows), layout="constrained")
    grid = figure.add_gridspec(rows, 2)
    for row, match in enumerate(drawn.matches):
        _match(figure.add_subplot(grid[row, 0]), match)
        _residuals(figure.add_subplot(grid[row, 1]), match)
    last = grid[rows - 1, 0] if drawn.correlation is not None else grid[rows - 1, :]
    _searches(figure.add_subplot(last), drawn.traces, drawn.value)
    if drawn.correlation is not None:
        _matrix(figure.add_subplot(grid[rows - 1, 1]), drawn.names, drawn.correlation)
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
    """Draw the course of the searches alone."""
    figure = Figure(figsize=(page_width(), 1.3 * ROW), layout="constrained")
    _searches(figure.add_subplot(), drawn.traces, drawn.value)
    return panels.finish(figure, remark=drawn.remark, with_legend=False)


@styled
def _correlations(drawn: Drawn) -> Figure:
    """Draw the matrix of correlations alone."""
    assert drawn.correlation is not None
    side = min(page_width(), 2.2 + 0.35 * len(drawn.names))
    figure = Figure(figsize=(side, 0.8 * side), layout="constrained")
    _matrix(figure.add_subplot(), drawn.names, drawn.correlation)
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
    """Draw what a design reaches beside the data that it has to match: as a path in the plane, or over the abscissa."""
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
    """Draw the differences of each component from the data."""
    over = np.arange(len(match.given)) if match.abscissa is None else match.abscissa
    for index, component in enumerate(match.components):
        residual = match.reached[:, index] - match.given[:, index]
        axis.plot(over, residual, ".", color=line(index)["color"], markersize=4, label=component or None)
    axis.axhline(0.0, color="#888888", linewidth=0.6)
    axis.set_xlabel("point" if match.abscissa is None else match.along)
    axis.set_ylabel(f"design - given ({match.unit})" if match.unit else "design - given")
    axis.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3), useMathText=True)
    if len(match.components) > 1:
        axis.legend(loc="best")


def _searches(axis: Axes, traces: Sequence[Array], value: str) -> None:
    """Draw the course of all searches, traces (n, 2) of runs and the best `value` so far, with the best in front."""
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


def _matrix(axis: Axes, names: Sequence[str], correlation: Array) -> None:
    """Draw the correlations (d, d) of d numbers, with their values where there are few."""
    image = axis.imshow(correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
    short = [fitted(name, NAME, 7.0) for name in names]
    axis.set_xticks(range(len(names)), short, rotation=90, fontsize=7)
    axis.set_yticks(range(len(names)), short, fontsize=7)
    axis.grid(visible=False)
    if len(names) <= WRITTEN:
        for (row, column), value in np.ndenumerate(correlation):
            colour = "white" if abs(value) > 0.6 else "#222222"
            axis.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=6, color=colour)
    axis.figure.colorbar(image, ax=axis, label="correlation", shrink=0.9)


#: The pictures by kind, for `mbproj plot`.
PICTURES: Mapping[str, Callable[[Drawn], Figure]] = {
    "fit": _fit,
    "convergence": _convergence,
    "correlation": _correlations,
    "front": _front,
}


# --- The profile of a cam for the workshop, beside its radius, pressure angle and curvature ---------------------------

#: The relative widths of the profile and of the panels beside it.
WIDTHS = (1.15, 1.0)
HEIGHT = 1.35
#: The pressure angle in degrees above which a sliding follower may jam (Norton 2009, Cam Design, ch. 7).
JAMS = 30.0
#: The numbers of the styles of lines.
OUTLINE, GUIDE, LIMIT = 0, 1, 2


@styled
def draw_profile(sheet: Sheet) -> Figure:
    """Draw the profile with equal scales on the left, and its numbers along it on the right: over the angle about the
    origin where the profile goes once round it, else over its arc length."""
    words = ["radius", *(["pressure angle"] if sheet.closed else []), "curvature"]
    figure = Figure(figsize=(page_width(), max(3, len(words)) * HEIGHT + AXIS_HEIGHT), layout="constrained")
    grid = figure.add_gridspec(len(words), 2, width_ratios=WIDTHS, height_ratios=[HEIGHT] * len(words))
    _outline(figure.add_subplot(grid[:, 0]), sheet)
    turns = sheet.closed and abs(abs(sheet.angle[-1] - sheet.angle[0]) - 2.0 * np.pi) < 1e-6
    at = np.degrees(sheet.angle) if turns else 1e3 * sheet.arc
    values = {
        "radius": (1e3 * sheet.radius, "mm"),
        "pressure angle": (np.degrees(sheet.pressure), "degrees"),
        "curvature": (1e-3 * sheet.curvature, "1/mm"),
    }
    axes: list[Axes] = []
    for row, word in enumerate(words):
        axis = figure.add_subplot(grid[row, 1], sharex=axes[0] if axes else None)
        shown, unit = values[word]
        panels.plot(axis, at, shown, "", OUTLINE)
        panels.name(axis, word, unit)
        axis.tick_params(labelbottom=row + 1 == len(words))
        axes.append(axis)
    if sheet.closed and np.degrees(sheet.pressure).max() > 0.5 * JAMS:
        axes[1].axhline(JAMS, label="usual limit of the pressure angle", **line(LIMIT))
    panels.hold_still(axes[:1], 1e3 * float(sheet.radius.max()))
    axes[-1].set_xlabel("angle about the origin (degrees)" if turns else "arc length (mm)")
    if turns:
        tick_degrees(axes[-1], along_x=True)
    return panels.finish(
        figure, remark=remark(sheet), with_legend=any(axis.get_legend_handles_labels()[0] for axis in figure.axes)
    )


def _outline(axis: Axes, sheet: Sheet) -> None:
    """Draw the profile, the path of the roller's centre, and the roller at its first place."""
    panels.plot(axis, 1e3 * sheet.x, 1e3 * sheet.y, "profile" if sheet.roller else "", OUTLINE)
    if sheet.roller:
        panels.plot(axis, 1e3 * sheet.line_x, 1e3 * sheet.line_y, "centre of the roller", GUIDE)
        place = (1e3 * sheet.line_x[0], 1e3 * sheet.line_y[0])
        axis.add_patch(Circle(place, 1e3 * sheet.roller, fill=False, edgecolor="#808080", linewidth=0.8))
    axis.plot([0.0], [0.0], "+", color="#404040")
    axis.set_aspect("equal", adjustable="box")
    axis.margins(0.08)
    axis.set(xlabel="x (mm)", ylabel="y (mm)")


def remark(sheet: Sheet) -> str:
    """The small print: the name of the curve, the largest pressure angle, and the largest rollers."""
    said = [f"curve '{sheet.name}'"]
    if sheet.closed:
        worst = float(np.max(sheet.pressure))
        said.append(f"largest pressure angle {degrees(worst):.1f} degrees")
    return "; ".join([*said, *rollers_said(sheet)])


def rollers_said(sheet: Sheet) -> list[str]:
    """The largest roller on each side, in words."""
    return [
        f"any roller fits {side}" if radius == inf else f"largest roller {side}: {1e3 * radius:.4g} mm"
        for side, radius in sheet.rollers.items()
    ]


# --- Sensitivities: the change in percent of each measure where a number of the scene changes by one percent ----------

#: The height of a bar and of the rest of a panel, and the room for the name of a number, inches; the most bars.
BAR, AROUND, BAR_NAME, MOST = 0.22, 0.75, 1.6, 20


@styled
def draw_sensitivities(table: Table) -> Figure:
    """Draw a panel for each measure of the table of `mbproj sensitivity`, its largest elasticity on top. A measure of 0
    has no elasticity; its panel tells so."""
    measures = list(dict.fromkeys(row[0] for row in table.rows))
    rows_of = {name: [row for row in table.rows if row[0] == name] for name in measures}
    heights = [AROUND + BAR * min(len(rows), MOST) for rows in rows_of.values()]
    figure = Figure(figsize=(page_width(), sum(heights)), layout="constrained")
    axes = figure.subplots(len(measures), 1, squeeze=False, height_ratios=heights)[:, 0]
    for axis, (name, rows) in zip(axes, rows_of.items(), strict=True):
        _bars(axis, name, rows)
    axes[-1].set_xlabel("elasticity: change in percent where the number changes by one percent")
    cut = max(map(len, rows_of.values())) - MOST
    remark = f"without the {cut} smallest of a measure" if cut > 0 else ""
    return panels.finish(figure, remark=remark, with_legend=False)


def _bars(axis: Axes, name: str, rows: list[tuple[Any, ...]]) -> None:
    """Draw the bars of one measure. The columns of `rows` are measure, number, value, slope, uncertainty, elasticity,
    unit."""
    drawn = [row for row in rows if np.isfinite(row[5])][:MOST]
    axis.set_title(f"{name} = {rows[0][2]:.6g}", loc="left", fontsize=8)
    if not drawn:
        axis.text(0.5, 0.5, "its value is 0: no elasticity", ha="center", va="center", transform=axis.transAxes)
        axis.set_yticks([])
        return
    values = np.array([row[5] for row in drawn], dtype=float)
    colours = [line(0)["color"] if value >= 0.0 else line(1)["color"] for value in values]
    axis.barh(range(len(drawn)), values, color=colours, height=0.7)
    axis.axvline(0.0, color="#444444", linewidth=0.6)
    axis.set_yticks(range(len(drawn)), [fitted(row[1], BAR_NAME, 8.0) for row in drawn])
    axis.invert_yaxis()
    axis.margins(x=0.05)
    axis.grid(visible=False, axis="y")


# --- The forces, torques and power of actuators along a motion --------------------------------------------------------

#: The words on the panels, by unit.
WORDS = {"N": "force", "N m": "torque"}


@styled
def draw_actuators(
    time: Array, names: Sequence[str], units: Sequence[str], force: Array, power: Array, over: Cycle | None, remark: str
) -> Figure:
    """Draw a panel of forces, one of torques and one of power, as far as there are any. `force` (T, k) are those of k
    actuators with these names and units, in N or N m, `power` (T, k) theirs in W. The axis is `time` (T,) in s, or the
    coordinate `over`; an angle is in degrees modulo a turn."""
    kinds = [unit for unit in WORDS if unit in units]
    figure, axes = panels.panels(len(kinds) + 1, height=2.1)
    at = time if over is None else in_degrees(over.values, over.unit)
    for place, name in enumerate(names):
        for axis, values in ((axes[kinds.index(units[place]), 0], force), (axes[-1, 0], power)):
            curve = (at, values[:, place]) if over is None else by_turns(at, values[:, place])
            panels.plot(axis, *curve, name, place)
    for axis, unit in zip(axes[:, 0], [*kinds, "W"], strict=True):
        panels.name(axis, WORDS.get(unit, "power"), unit)
    if over is not None:
        axes[-1, 0].set_xlabel(label_of(over.name, over.unit))
        if over.unit == "rad":
            tick_degrees(axes[-1, 0], along_x=True)
    return panels.finish(figure, remark=remark)
