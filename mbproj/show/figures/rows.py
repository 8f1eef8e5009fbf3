"""Rows of panels: the quantities of one result, or of several overlaid, with rows of their differences below."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.settings import SETTINGS, SettingEntry
from mbproj.results.analysis.comparison import common_samples
from mbproj.results.record import Results
from mbproj.show.figures import panels
from mbproj.show.figures.style import OPEN, AxisUnit, sizes, tick_degrees

# --- Differences of overlaid results ----------------------------------------------------------------------------------
# The differences of overlaid results from the first of them, at the sample times that they share. Coordinates that
# coincide at all times are found too, so that one line shows them.


#: The symbol of a difference on an axis.
SIGN = "|Δ|"
#: A function that reads values (T) or (T, k) of a result; None where the result has none.
Read = Callable[[Results], Array | None]
#: The tolerance up to which coordinates coincide: a part of the largest value, and m or rad, as joints are closed to.
SAME, CLOSED = 1e-9, 1e-13


def comparable(results: Sequence[Results]) -> bool:
    """Whether another result shares a sample time with the first."""
    return any(len(common_samples(results[0].time, other.time)[0]) for other in results[1:])


def differences_remark(results: Sequence[Results], labels: Sequence[str]) -> str:
    """A remark that names the first result, or tells why there are no differences."""
    if comparable(results):
        return f"{SIGN}: difference from {labels[0]}, at the times of both"
    return "no differences: the results share no sample time; run them with the same --output-step"


def draw_differences(
    axis: Axes, results: Sequence[Results], labels: Sequence[str], read: Read, factor: float = 1.0
) -> None:
    """Draw the difference of each other result from the first, times `factor`; of vectors the length. The axis is
    logarithmic and omits zeros, unless all differences are zero."""
    first = read(results[0])
    lines = []
    for index, (other, label) in enumerate(zip(results[1:], labels[1:], strict=True), start=1):
        second = read(other)
        if first is None or second is None:
            continue
        here, there = common_samples(results[0].time, other.time)
        apart = factor * np.abs(first[here] - second[there])
        lines.append(
            (results[0].abscissa[here], apart if apart.ndim == 1 else np.linalg.norm(apart, axis=1), label, index)
        )
    if any(np.any(apart > 0.0) for _, apart, _, _ in lines):
        axis.set_yscale("log")
        lines = [(time, np.where(apart > 0.0, apart, np.nan), label, index) for time, apart, label, index in lines]
    else:
        axis.set_yticks([0.0])
    for time, apart, label, index in lines:
        panels.plot(axis, time, apart, label, index)


def coinciding(results: Sequence[Results], names: Sequence[str]) -> dict[str, list[str]]:
    """Group the coordinates of the results that coincide: the others by the first of each group."""
    groups: dict[str, list[str]] = {}
    for name in names:
        curves = [_of(result, name) for result in results]
        first = next((other for other in groups if _agree(curves, [_of(result, other) for result in results])), None)
        groups.setdefault(name, []) if first is None else groups[first].append(name)
    return groups


def alike(first: Array, second: Array) -> bool:
    """Whether two series are equal, up to round-off."""
    with np.errstate(invalid="ignore"):
        return bool(np.all(np.abs(first - second) <= SAME * np.max(np.abs(first), initial=0.0) + CLOSED))


def _of(result: Results, name: str) -> tuple[str, Array, Array] | None:
    if name not in result.names("coordinates"):
        return None
    coordinate = result.coordinate(name)
    return coordinate.unit, coordinate.value, coordinate.speed


def _agree(one: Sequence[tuple[str, Array, Array] | None], other: Sequence[tuple[str, Array, Array] | None]) -> bool:
    for first, second in zip(one, other, strict=True):
        if first is None or second is None:
            if first is not second:
                return False
        elif first[0] != second[0] or not alike(first[1], second[1]) or not alike(first[2], second[2]):
            return False
    return True


# --- Rows of panels ---------------------------------------------------------------------------------------------------


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
    shown: list[PanelGroup] = []
    for group in groups:
        shown.append(group)
        if len(shown) > 1 and len(_all_rows(shown, results)) > MAX_ROWS:
            return shown[:-1]
    return shown


def draw_rows(
    results: Sequence[Results], labels: Sequence[str], groups: Sequence[PanelGroup], remark: str = ""
) -> Figure:
    """Draw the groups below each other: a line for each part of a quantity, or for each of several results."""
    listed = _all_rows(groups, results)
    heights = [LOWER if is_difference else 1.0 for _, _, is_difference in listed]
    figure, axes = panels.panels(len(listed), max(len(row) for _, row, _ in listed), parts=heights)
    shown: dict[AxisUnit, list[Axes]] = {}
    for row_axes, (group, row, is_difference) in zip(axes, listed, strict=True):
        for axis, quantity in zip(row_axes, row, strict=True):
            axis.set_label(group.name)
            if quantity is None:
                axis.set_visible(False)
            elif is_difference:
                draw_differences(axis, results, labels, quantity.read, quantity.unit.factor)
                panels.name(axis, quantity.words, quantity.unit.reads)
            else:
                _lines(axis, results, labels, quantity)
                panels.name(axis, quantity.words, quantity.unit.reads)
                if quantity.held:
                    shown.setdefault(quantity.unit, []).append(axis)
    _scale(shown, results)
    for column in axes.T:
        _time_below(column)
    said = [remark, differences_remark(results, labels)] if len(results) > 1 else [remark]
    with_legend = len(results) > 1 or any(quantity and quantity.parts for _, row, _ in listed for quantity in row)
    return panels.finish(figure, remark="; ".join(filter(None, said)), with_legend=with_legend)


def _all_rows(groups: Sequence[PanelGroup], results: Sequence[Results]) -> list[tuple[PanelGroup, Row, bool]]:
    """All rows with their groups, and whether each is one of differences."""
    compares = len(results) > 1 and comparable(results)
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


# --- The labels of overlaid results -----------------------------------------------------------------------------------
# The settings in which they differ.


#: Settings that follow from the method, or concern only the duration and the sampling.
MINOR = ("gains", "alpha", "duration", "output_step")


def derive_labels(results: Sequence[Results]) -> list[str]:
    """A different label for each result: the settings and parameters that differ, or the names of the files."""
    stems = [stem(result) for result in results]
    if len(results) == 1:
        return stems
    settings = [_flat(result) for result in results]
    keys = dict.fromkeys(key for values in settings for key in values)
    differing = [key for key in keys if len({values.get(key) for values in settings}) > 1]
    telling = [key for key in differing if getattr(key, "name", "") not in MINOR] or differing
    labels = [", ".join(_reads(key, s[key]) for key in telling if s.get(key) is not None) for s in settings]
    if len({result.title for result in results}) > 1 or len(set(labels)) < len(labels) or not all(labels):
        names = stems if len(set(stems)) == len(stems) else [str(result.path) for result in results]
        labels = [f"{name}: {label}" if label else name for name, label in zip(names, labels, strict=True)]
    return labels


def stem(result: Results) -> str:
    """The name of the results file without the endings .h5 and .part."""
    path = result.path.with_suffix("") if result.partial else result.path
    return path.stem


def _flat(result: Results) -> dict[SettingEntry | str, Any]:
    """The settings, those of the projection first, and the changed parameters by name."""
    flat: dict[SettingEntry | str, Any] = {}
    for entry in sorted(SETTINGS.values(), key=lambda entry: -len(entry.path)):
        flat[entry] = entry.of(result.settings)
    return flat | dict(result.overrides)


def _reads(key: SettingEntry | str, value: Any) -> str:
    if isinstance(key, str):
        return f"{key} = {value}"
    return (key.label or f"{key.name.replace('_', ' ')} {{}}").format(f"{value:g}" if key.kind == "float" else value)
