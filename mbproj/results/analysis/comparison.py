"""The comparison of two results: the largest difference of each quantity, and where the motions first part."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.analysis.common_quantities import (
    KINDS,
    SharedColumns,
    floors,
    one_sided,
    reactions_left_out,
    shared_columns,
)
from mbproj.analysis.comparison import common_samples
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.results import Results
from mbproj.results.views.table import Table, Tabled


@dataclass(frozen=True)
class Parting:
    """A difference of a quantity: its size, the name of the column, and the time in s."""

    difference: float
    name: str
    time: float

    @property
    def of(self) -> str | None:
        """The name of the column; None where it has none."""
        return self.name or None


@dataclass(frozen=True)
class QuantityComparison:
    """The comparison of a quantity, by its path in the results, in `unit`: the `largest` difference, the difference
    `allowed`, and the `first` one above that, or None. Vectors differ by a length, orientations by an angle."""

    quantity: str
    unit: str
    largest: Parting
    allowed: float
    first: Parting | None

    @property
    def same(self) -> bool:
        """Whether no difference is larger than allowed."""
        return self.first is None


@dataclass(frozen=True)
class MotionComparison(Tabled):
    """The comparison of two results at the `samples` times that both have. `counts` are the numbers of samples of each;
    `ends` the last times in s, equal to within a sampling interval where `as_long`. `missing` are the names that only
    one has, by kind. `left_out` are the components of reactions, by joint, that are not unique ("Fy Tx"), and so not
    compared."""

    quantities: tuple[QuantityComparison, ...]
    samples: int
    counts: tuple[int, int]
    ends: tuple[float, float]
    as_long: bool
    missing: Mapping[str, tuple[str, ...]]
    left_out: Mapping[str, str]

    @property
    def same(self) -> bool:
        """Whether the results are the same motion over the same time."""
        return self.as_long and self.parting is None

    @property
    def parting(self) -> QuantityComparison | None:
        """The quantity that first differs by more than allowed; None where none does."""
        apart = [each for each in self.quantities if each.first is not None]
        return min(apart, key=lambda each: each.first.time if each.first else np.inf, default=None)

    @property
    def table(self) -> Table:
        """A table with a row for each quantity: its largest difference, the column and time of that, and the allowed
        difference."""
        return Table.of(
            {
                "quantity": each.quantity,
                "unit": each.unit,
                "largest": each.largest.difference,
                "of": each.largest.name,
                "time": each.largest.time,
                "allowed": each.allowed,
                "same": each.first is None,
            }
            for each in self.quantities
        )

    @property
    def line(self) -> str:
        """A line that tells whether the results are the same motion."""
        parting = self.parting
        if parting is not None and parting.first is not None:
            return f"they part at t = {parting.first.time:.6g} s, in {parting.quantity}"
        return "the same motion" if self.as_long else f"the same motion until t = {min(self.ends):.6g} s"

    __repr__ = Tabled.__repr__


def compare_motions(
    first: Results, second: Results, tolerance: float, absolute: Mapping[str, float] | None = None
) -> MotionComparison:
    """Compares the quantities that both results have, without interpolation. A quantity may differ by `tolerance` times
    its largest magnitude in either result, or by `absolute[path]` in SI units. Magnitudes below those of `floors` are
    replaced by them.

    Raises InputError for mechanisms without a common body, or results without a common time.
    """
    rows = common_samples(first.time, second.time)
    _check_comparable(first, second, len(rows[0]))
    least = floors(first, second)
    given = absolute or {}
    partings = [
        _compared(columns, first.time[rows[0]], least, given.get(columns.path), tolerance)
        for columns in shared_columns(first, second, rows)
    ]
    ends = float(first.time[-1]), float(second.time[-1])
    interval = max(float(np.median(np.diff(time))) if len(time) > 1 else 0.0 for time in (first.time, second.time))
    return MotionComparison(
        tuple(partings),
        len(rows[0]),
        (len(first.time), len(second.time)),
        ends,
        abs(ends[0] - ends[1]) < 0.999 * interval or ends[0] == ends[1],
        {kind: names for kind in KINDS.values() if (names := one_sided(first, second, kind))},
        reactions_left_out(first, second),
    )


def _compared(
    columns: SharedColumns, time: Array, least: Mapping[str, float], absolute: float | None, tolerance: float
) -> QuantityComparison:
    one, other = columns.values
    with np.errstate(over="ignore", invalid="ignore"):  # a difference that is not finite counts as a difference
        distance = np.linalg.norm(one - other, axis=-1)
        size = max(float(np.linalg.norm(values, axis=-1).max()) for values in columns.values)
    unit = columns.unit
    if columns.path == "bodies/orientation":
        distance, unit = 4.0 * np.arcsin(np.minimum(distance / 2.0, 1.0)), "rad"
        size = 1.0
    else:
        size = max(size, least.get(unit, 0.0))
    allowed = tolerance * size if absolute is None else absolute
    beyond = np.flatnonzero(~(np.isfinite(distance) & (distance <= allowed)).all(axis=1))
    first = _parting(columns, distance, time, int(beyond[0])) if len(beyond) else None
    worst = int(np.argmax(distance.max(axis=1)))
    return QuantityComparison(columns.path, unit, _parting(columns, distance, time, worst), allowed, first)


def _parting(columns: SharedColumns, distance: Array, time: Array, row: int) -> Parting:
    column = int(np.argmax(distance[row]))
    return Parting(float(distance[row, column]), columns.names[column], float(time[row]))


def _check_comparable(first: Results, second: Results, shared: int) -> None:
    if not set(first.names("bodies")) & set(second.names("bodies")):
        message = f"'{first.path}' and '{second.path}' have no body in common"
        raise InputError(Problem(message, hint="give two results of one mechanism"))
    if not shared:
        message = f"'{first.path}' and '{second.path}' have no sample time in common"
        raise InputError(Problem(message, hint="run both with the same --output-step"))
