"""Rows of panels: the quantities of one result, or of several overlaid, with rows of their differences below."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.dataclass import dataclass
from mbproj.figures import differences, panels
from mbproj.figures.differences import Read
from mbproj.figures.style import OPEN
from mbproj.figures.units import AxisUnit, sizes, tick_degrees
from mbproj.results import Results

#: The most rows on a page, and the height of a row of differences in parts of the others'.
MAX_ROWS, LOWER = 8, 0.75


@dataclass(frozen=True, eq=False)
class PanelQuantity:
    """The quantity of a panel: the words on its axis, its unit, and a function that reads its values in SI. They are
    (T), (T, 1), or (T, k) with a name and a line number for each of the `parts`. `not_unique` values are grey. `held`:
    the panel keeps the scale of others where it hardly moves."""

    words: str
    unit: AxisUnit
    read: Read
    parts: tuple[tuple[str, int], ...] = ()
    not_unique: bool = False
    held: bool = True


Row = tuple[PanelQuantity | None, ...]


@dataclass(frozen=True, eq=False)
class PanelGroup:
    """Rows of panels that belong together; None is an empty place. `compared` are the quantities whose differences are
    drawn below where results are overlaid. `name` is the label of their axes."""

    rows: tuple[Row, ...]
    compared: Row = ()
    name: str = ""


def fitting(groups: Sequence[PanelGroup], results: Sequence[Results]) -> list[PanelGroup]:
    """The first groups, at least one, that fit on a page."""
    kept: list[PanelGroup] = []
    for group in groups:
        kept.append(group)
        if len(kept) > 1 and len(_all_rows(kept, results)) > MAX_ROWS:
            return kept[:-1]
    return kept


def draw(results: Sequence[Results], labels: Sequence[str], groups: Sequence[PanelGroup], remark: str = "") -> Figure:
    """Draw the groups below each other: a line for each part of a quantity, or for each of several results."""
    listed = _all_rows(groups, results)
    heights = [LOWER if is_difference else 1.0 for _, _, is_difference in listed]
    figure, axes = panels.panels(len(listed), max(len(row) for _, row, _ in listed), parts=heights)
    shown: dict[AxisUnit, list[Axes]] = {}
    for own, (group, row, is_difference) in zip(axes, listed, strict=True):
        for axis, quantity in zip(own, row, strict=True):
            axis.set_label(group.name)
            if quantity is None:
                axis.set_visible(False)
            elif is_difference:
                differences.draw(axis, results, labels, quantity.read, quantity.unit.factor)
                panels.name(axis, quantity.words, quantity.unit.reads)
            else:
                _lines(axis, results, labels, quantity)
                panels.name(axis, quantity.words, quantity.unit.reads)
                if quantity.held:
                    shown.setdefault(quantity.unit, []).append(axis)
    _scale(shown, results)
    for column in axes.T:
        _time_below(column)
    said = [remark, differences.remark(results, labels)] if len(results) > 1 else [remark]
    with_legend = len(results) > 1 or any(quantity and quantity.parts for _, row, _ in listed for quantity in row)
    return panels.finish(figure, remark="; ".join(filter(None, said)), with_legend=with_legend)


def _all_rows(groups: Sequence[PanelGroup], results: Sequence[Results]) -> list[tuple[PanelGroup, Row, bool]]:
    """All rows with their groups, and whether each is one of differences."""
    compares = len(results) > 1 and differences.comparable(results)
    listed = []
    for group in groups:
        listed += [(group, row, False) for row in group.rows]
        listed += [(group, group.compared, True)] if compares and group.compared else []
    return listed


def _lines(axis: Axes, results: Sequence[Results], labels: Sequence[str], quantity: PanelQuantity) -> None:
    for index, (result, label) in enumerate(zip(results, labels, strict=True)):
        values = quantity.read(result)
        if values is None:
            continue
        values = quantity.unit.factor * values.reshape(len(result.time), -1)
        grey: dict[str, Any] = OPEN if quantity.not_unique else {}
        if not quantity.parts:
            panels.plot(axis, result.abscissa, values[:, 0], panels.NOT_UNIQUE if grey else label, index, **grey)
        for column, (part, look) in enumerate(quantity.parts):
            panels.plot(axis, result.abscissa, values[:, column], part, look)


def _scale(shown: dict[AxisUnit, list[Axes]], results: Sequence[Results]) -> None:
    """Scale the panels of each unit together, so that round-off stays small. Angles have ticks at parts of a turn."""
    size = sizes(results)
    for unit, axes in shown.items():
        panels.hold_still(axes, unit.factor * size.get(unit.si, 1.0))
        for axis in axes if unit.reads == "°" else ():
            tick_degrees(axis)


def _time_below(column: Sequence[Axes]) -> None:
    """Show the time axis below the last visible panel of a column."""
    last = [axis for axis in column if axis.get_visible()][-1]
    last.set_xlabel(panels.TIME)
    last.tick_params(labelbottom=True)
