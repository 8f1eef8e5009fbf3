"""Units for a person: angles in degrees, or in turns where there are many. Recorded values stay in SI."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import pi

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from mbproj.analysis.common_quantities import floors
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.results import Results


@dataclass(frozen=True)
class AxisUnit:
    """A unit on an axis: its text, and the factor from `si` to it."""

    reads: str
    si: str
    factor: float = 1.0


@dataclass(frozen=True)
class UnitPair:
    """The units of a coordinate and of its speed."""

    value: AxisUnit
    speed: AxisUnit


DEGREES = UnitPair(AxisUnit("°", "rad", 180.0 / pi), AxisUnit("°/s", "rad/s", 180.0 / pi))
TURNS = UnitPair(AxisUnit("turns", "rad", 0.5 / pi), AxisUnit("rpm", "rad/s", 30.0 / pi))
METRES = UnitPair(AxisUnit("m", "m"), AxisUnit("m/s", "m/s"))
#: The angle in rad above which turns are used: beyond ten turns, 3600°, degrees tell nothing.
MANY = 20.0 * pi
#: The distances of ticks in degrees, and the most intervals on an axis. A short axis has decimal ticks.
STEPS = (15, 30, 45, 90, 180, 360, 720, 1440)
MOST_PARTS = 6


def units_of(si: str, values: Iterable[Array]) -> UnitPair:
    """The units for a coordinate in `si`, rad or m, with these values."""
    if si == "m":
        return METRES
    largest = max((float(np.max(np.abs(each), where=np.isfinite(each), initial=0.0)) for each in values), default=0.0)
    return TURNS if largest > MANY else DEGREES


def tick_degrees(axis: Axes, *, along_x: bool = False) -> None:
    """Put the ticks of the vertical, or the horizontal, axis at parts of a turn, where its range is large enough."""
    low, high = axis.get_xlim() if along_x else axis.get_ylim()
    step = next((step for step in STEPS if high - low <= MOST_PARTS * step), None)
    if step is not None and high - low >= 2 * STEPS[0]:
        (axis.xaxis if along_x else axis.yaxis).set_major_locator(MultipleLocator(step))


def sizes(results: Sequence[Results]) -> dict[str, float]:
    """The mechanism's own size in each SI unit, from its extent, duration and energy. A panel in which nothing moves
    has this range. The size is 1 where the results do not tell it."""
    largest: dict[str, float] = {}
    with np.errstate(all="ignore"):
        for result in results:
            for unit, size in floors(result, result).items():
                largest[unit] = max(largest.get(unit, 0.0), size if np.isfinite(size) else 0.0)
    return {unit: size or 1.0 for unit, size in largest.items()}
