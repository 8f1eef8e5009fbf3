"""Measures over one varied quantity, with a line for each value of a second one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.figures.fitted_text import literal
from mbproj.figures.fitting_names import MAX_LINES
from mbproj.figures.style import PANEL_HEIGHT, line, page_width, styled
from mbproj.figures.sweeps.chosen import Cases, Chosen, middle_of_others
from mbproj.figures.sweeps.marks import crosses_below
from mbproj.figures.sweeps.scales import name, scale_of, spread_out
from mbproj.results.sweep.table import GRID, Column

#: Lines with fewer points than this mark them.
FEW = 60
MARKS = "osD^vP<"


def why_not(chosen: Chosen) -> str | None:
    """The reason why no lines can be drawn; None where they can. Lines join the cases of a grid, or of a single
    quantity."""
    if not chosen.over:
        return "nothing varies in this sweep"
    if chosen.table.combine not in (GRID, "zip") and len(chosen.over) > 1:
        return f"'{chosen.table.combine}' varies {len(chosen.over)} quantities at once, and no line joins its cases"
    return None


@styled
def draw(chosen: Chosen) -> Figure:
    """Draw a row for each measure."""
    first, second = _axes(chosen)
    kept, said = middle_of_others(chosen, [column for column in (first, second) if column is not None])
    figure, axes = panels.panels(
        len(chosen.measures), height=max(PANEL_HEIGHT, 2.6 if len(chosen.measures) == 1 else 0)
    )
    places, ticks = _places(first)
    lines, cut = _lines(chosen, second)
    for axis, measure in zip(axes[:, 0], chosen.measures, strict=True):
        _, values = chosen.scaled(measure)
        for index, (label, cases) in enumerate(lines):
            shown = kept & cases
            _line(axis, places[shown], values[shown], label, index)
        crosses_below(axis, places[kept & chosen.table.failed])
        axis.margins(x=0.02)
        panels.name(axis, measure.name, scale_of(measure).unit)
        if ticks:
            axis.set_xticks(range(len(ticks)), [literal(tick) for tick in ticks])
        elif first.is_number:
            spread_out(axis, "x", places)
    axes[-1, 0].set_xlabel(name(first, page_width() - 1.0, 1))
    return panels.finish(
        figure, remark=chosen.remark(said, cut), with_legend=second is not None or _any_bad(chosen, kept)
    )


def _any_bad(chosen: Chosen, kept: Cases) -> bool:
    return bool(np.any(chosen.table.failed & kept))


def _axes(chosen: Chosen) -> tuple[Column, Column | None]:
    """The quantity along the axis, a number where there is one, and the quantity of the lines, or None."""
    first = chosen.over[0] if chosen.over[0].is_number else next(iter(chosen.numbers), chosen.over[0])
    others = [column for column in chosen.over if column is not first]
    return first, others[0] if others and chosen.table.combine == GRID else None


def _places(column: Column) -> tuple[Array, list[str]]:
    """The place of each case along the axis, and ticks where the values are words."""
    if column.is_number:
        return scale_of(column).factor * column.values, []
    words = list(dict.fromkeys(column.values.tolist()))
    return np.array([float(words.index(value)) for value in column.values]), words


def _lines(chosen: Chosen, column: Column | None) -> tuple[Sequence[tuple[str, Cases]], str]:
    """The label and the cases of each line, and a remark where not all are drawn."""
    if column is None:
        return [("", np.ones(len(chosen.table.status), dtype=bool))], ""
    values = list(dict.fromkeys(column.values.tolist()))
    taken = np.unique(np.linspace(0, len(values) - 1, min(len(values), MAX_LINES)).round().astype(int))
    scale = scale_of(column)
    lines = [(f"{column.name} = {scale.reads(values[k])}", column.values == values[k]) for k in taken]
    return lines, "" if len(taken) == len(values) else f"{len(taken)} of {len(values)} values of {column.name}"


def _line(axis: Axes, x: Array, y: Array, label: str, index: int) -> None:
    order = np.argsort(x, kind="stable")
    marks = {"marker": MARKS[index % len(MARKS)], "markersize": 3.0} if len(x) < FEW else {}
    axis.plot(x[order], y[order], label=literal(label) or "_", **(line(index) | marks))
