"""Scales on which a person reads SI values (millimetres, degrees, kilonewtons), and axes with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator, NullLocator

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, choose_from
from mbproj.results.sweep_table import GRID, Column, SweepCases
from mbproj.show.figures.fitted_text import fitted
from mbproj.show.figures.style import label_size

#: Units other than SI's: the largest value from which downwards one is used, its name, and its factor.
SMALLER: Mapping[str, tuple[tuple[float, str, float], ...]] = MappingProxyType(
    {
        "m": ((1e-6, "nm", 1e9), (1e-3, "µm", 1e6), (1.0, "mm", 1e3)),
        "s": ((1e-3, "µs", 1e6), (0.1, "ms", 1e3)),
        "kg": ((0.1, "g", 1e3),),
        "N": ((0.01, "mN", 1e3),),
        "N*m": ((0.01, "mN m", 1e3),),
        "J": ((0.01, "mJ", 1e3),),
    }
)
LARGER: Mapping[str, tuple[float, str, float]] = MappingProxyType(
    {"N": (1e4, "kN", 1e-3), "N*m": (1e4, "kN m", 1e-3), "J": (1e4, "kJ", 1e-3)}
)
OTHERS: Mapping[str, tuple[str, float]] = MappingProxyType(
    {"rad": ("°", 180.0 / pi), "rad/s": ("°/s", 180.0 / pi), "1": ("", 1.0)}
)
#: The most values on a logarithmic axis that have a tick each.
MOST_TICKS = 8
#: Steps between values count as even where they differ by less than this part.
EVEN = 1e-6


@dataclass(frozen=True)
class Scale:
    """A unit for a person, and the factor from SI to it."""

    unit: str
    factor: float

    def reads(self, value: Any) -> str:
        """The text of an SI value on this scale; a word stays."""
        return f"{self.factor * value:.5g} {self.unit}".strip() if isinstance(value, float) else str(value)


def scale_of(column: Column) -> Scale:
    """The scale for the values of a column."""
    unit = column.unit
    if not column.is_number or unit in OTHERS:
        return Scale(*OTHERS.get(unit, ("", 1.0)))
    sizes = np.abs(column.values[np.isfinite(column.values)])
    largest = float(sizes.max()) if len(sizes) else 1.0
    for bound, name, factor in SMALLER.get(unit, ()):
        if 0.0 < largest < bound:
            return Scale(name, factor)
    if unit in LARGER and largest >= LARGER[unit][0]:
        return Scale(*LARGER[unit][1:])
    return Scale(unit.replace("*", " "), 1.0)


def name(column: Column, room: float, lines: int = 2) -> str:
    """The name of an axis for a column, in at most `lines` lines of `room` inches."""
    unit = scale_of(column).unit
    whole = f" ({unit})".replace(" ", "\u00a0") if unit else ""
    return fitted(column.name + whole, room, label_size(), lines)


def spread_out(axis: Axes, which: Literal["x", "y"], values: Any) -> None:
    """Make an axis logarithmic where its distinct positive `values` are evenly spaced only in their logarithms."""
    distinct = np.unique(values)
    if len(distinct) < 3 or distinct[0] <= 0.0:
        return
    steps, ratios = np.diff(distinct), np.diff(np.log(distinct))
    if np.ptp(ratios) <= EVEN * ratios.max() and np.ptp(steps) > EVEN * steps.max():
        getattr(axis, f"set_{which}scale")("log")
        if len(distinct) <= MOST_TICKS:
            getattr(axis, f"set_{which}ticks")(distinct, [f"{value:.4g}" for value in distinct])
            getattr(axis, f"{which}axis").set_minor_locator(NullLocator())


def few_ticks(axis: Axes, horizontal: int, vertical: int) -> None:
    """Limit the number of ticks on linear axes."""
    for each, scale, most in ((axis.xaxis, axis.get_xscale(), horizontal), (axis.yaxis, axis.get_yscale(), vertical)):
        if scale == "linear":
            each.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))


# --- The marks of failed cases ----------------------------------------------------------------------------------------


FAILED = "failed"
CROSS: dict[str, Any] = {
    "marker": "x",
    "markersize": 4.5,
    "markeredgewidth": 1.1,
    "color": "#D55E00",
    "linestyle": "none",
    "zorder": 3,
}


def crosses(axis: Axes, x: Array, y: Array) -> None:
    """Draw a cross for each failed case, if there are any."""
    if len(x):
        axis.plot(x, y, label=FAILED, **CROSS)


def crosses_below(axis: Axes, x: Array) -> None:
    """Draw crosses at the lower edge, for cases without a value."""
    if len(x):
        axis.plot(x, [0.03] * len(x), label=FAILED, transform=axis.get_xaxis_transform(), clip_on=False, **CROSS)


# --- The part of a sweep that is drawn --------------------------------------------------------------------------------
# Its measures, and its varied quantities, those asked for first.


#: Marks of cases (N,).
Cases: TypeAlias = npt.NDArray[np.bool_]
#: The most measures on a page.
MOST = 6
SALTELLI = "saltelli"


@dataclass(frozen=True, eq=False)
class Chosen:
    """A table of a sweep, the measures to draw, and the quantities that have more than one value."""

    table: SweepCases
    measures: tuple[Column, ...]
    over: tuple[Column, ...]
    left_out: str

    @property
    def numbers(self) -> tuple[Column, ...]:
        """The varied quantities that are numbers."""
        return tuple(column for column in self.over if column.is_number)

    @property
    def independent(self) -> slice:
        """The cases that are independent samples: in Saltelli's design the first two blocks, otherwise all."""
        return slice(2 * self.table.samples if self.table.combine == SALTELLI else None)

    def remark(self, *more: str) -> str:
        """The small print: the given remarks, the measures left out, the title, and the number of cases."""
        table = self.table
        bad = int(np.count_nonzero(table.failed))
        cases = f"{table.combine}, {len(table.status)} cases" + (f", {bad} failed" if bad else "")
        return "; ".join(part for part in (*more, self.left_out, table.title, cases) if part)

    def scaled(self, column: Column) -> tuple[Scale, Array]:
        """The scale of a column of numbers, and its values on that scale."""
        scale = scale_of(column)
        return scale, scale.factor * column.values


def choose(table: SweepCases, of: Sequence[str], over: Sequence[str]) -> Chosen:
    """Choose the measures `of` and the quantities `over` to draw; all of them where none are named. Raises InputError
    for a name that the table does not have."""
    telling = [column for column in table.measured if column.varies] or table.measured
    measures = _columns_named(table.measured, of, "--of", "measure") or tuple(telling[:MOST])
    first = _columns_named(table.varied, over, "--over", "quantity that varies")
    for column in first:
        if not column.varies:
            raise InputError(Problem(f"--over {column.name}: it has one value in this sweep"))
    others = tuple(column for column in table.varied if column.varies and column not in first)
    left_out = "" if of else _left_out(table, measures)
    return Chosen(table, measures, first + others, left_out)


def _left_out(table: SweepCases, measures: Sequence[Column]) -> str:
    others = [column.name for column in table.measured if column not in measures]
    return f"not drawn: {', '.join(others)}; choose with --of" if others else ""


def _columns_named(columns: Sequence[Column], names: Sequence[str], option: str, what: str) -> tuple[Column, ...]:
    known = {column.name: column for column in columns}
    for name in names:
        if name not in known:
            raise InputError(Problem(f"{option}: the sweep has no {what} '{name}'", hint=choose_from(name, known)))
    return tuple(known[name] for name in dict.fromkeys(names))


def middle_of_others(chosen: Chosen, drawn: Sequence[Column]) -> tuple[Cases, str]:
    """Mark the cases (N,) of a grid in which all quantities but those `drawn` have their middle value, with a remark on
    these. In other designs mark all cases."""
    table = chosen.table
    at_middle = np.ones(len(table.status), dtype=bool)
    said = []
    for column in chosen.over if table.combine == GRID else ():
        if column not in drawn:
            values = list(dict.fromkeys(column.values.tolist()))
            middle = values[len(values) // 2]
            at_middle &= column.values == middle
            said.append(f"{column.name} = {scale_of(column).reads(middle)}")
    return at_middle, f"at {', '.join(said)}: choose others with --over" if said else ""
