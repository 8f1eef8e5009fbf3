"""Scales on which a person reads SI values (millimetres, degrees, kilonewtons), and axes with them."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator, NullLocator

from mbproj.dataclass import dataclass
from mbproj.figures.fitted_text import fitted
from mbproj.figures.style import label_size
from mbproj.results.sweep.table import Column

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
