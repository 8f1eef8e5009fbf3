"""Whether two results are the same motion: the largest difference of each quantity, and where they part first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mbproj.analysis.comparison import common_samples
from mbproj.analysis.energy import exchanged
from mbproj.analysis.tables import own_unit
from mbproj.arrays import Array, Integers
from mbproj.errors import InputError, Problem
from mbproj.results import DATASETS, Results

#: Kinds of names by the symbol of a dataset's columns.
KINDS = {"n": "bodies", "k": "markers", "nj": "joints", "nc": "coordinates", "nf": "forces", "nm": "motions"}
#: Of those whose columns have units of their own, the kind of these.
UNITS = {"nc": "coordinate_units", "nf": "force_units", "nm": "motion_units"}
ENERGIES = ("kinetic_energy", "potential_energy", "total_energy", "work", "dissipation")
#: Not the motion, but how well its joints are closed.
LEFT_OUT = ("joints/violation", "joints/violation_length", "joints/violation_angle")
#: What is compared, by its path in the results.
COMPARED = tuple(
    dataset for dataset in DATASETS
    if (dataset.symbol and dataset.path not in LEFT_OUT) or dataset.path.removeprefix("diagnostics/") in ENERGIES
)


@dataclass(frozen=True)
class Parting:
    """How far a quantity differs at most, of what (the name of a column), and when, in s."""

    difference: float
    name: str
    time: float


@dataclass(frozen=True)
class QuantityComparison:
    """A quantity (its path in the results) in `unit`: its `largest` difference, what is `allowed`, and the `first` one
    beyond that, None where they agree. Vectors differ by a length, orientations by an angle."""

    quantity: str
    unit: str
    largest: Parting
    allowed: float
    first: Parting | None


@dataclass(frozen=True)
class MotionComparison:
    """Two results at the `samples` times that they share, of `counts` each; their last times, `ends`, in s, which are
    the same up to a sampling interval where `as_long`. `missing`: by kind, the names that only one of them has."""

    quantities: tuple[QuantityComparison, ...]
    samples: int
    counts: tuple[int, int]
    ends: tuple[float, float]
    as_long: bool
    missing: Mapping[str, tuple[str, ...]]

    @property
    def same(self) -> bool:
        """Whether they are the same motion, as far as both go, and go as far."""
        return self.as_long and self.parting is None

    @property
    def parting(self) -> QuantityComparison | None:
        """The quantity that differs first; None where none does."""
        apart = [each for each in self.quantities if each.first is not None]
        return min(apart, key=lambda each: each.first.time if each.first else np.inf, default=None)


def compare_motions(
    first: Results, second: Results, tolerance: float, absolute: Mapping[str, float] | None = None
) -> MotionComparison:
    """Compares what both have: nothing is interpolated.

    A quantity may differ by `tolerance` times its largest magnitude in either (see `_floors` for one that is about
    zero), or by what `absolute` says for its path, in SI units. Raises InputError for mechanisms without a body in
    common, or results without a common time.
    """
    rows = common_samples(first.time, second.time)
    _check_comparable(first, second, len(rows[0]))
    floors = _floors(first, second)
    given = absolute or {}
    found = [
        _compared(columns, first.time[rows[0]], floors, given.get(columns.path), tolerance)
        for columns in _columns(first, second, rows)
    ]
    ends = float(first.time[-1]), float(second.time[-1])
    interval = max(float(np.median(np.diff(time))) if len(time) > 1 else 0.0 for time in (first.time, second.time))
    return MotionComparison(
        tuple(found), len(rows[0]), (len(first.time), len(second.time)), ends,
        abs(ends[0] - ends[1]) < 0.999 * interval or ends[0] == ends[1],
        {kind: names for kind in KINDS.values() if (names := _one_sided(first, second, kind))},
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Columns:
    """What both have of a quantity in one unit: values (S, c, k) at the common times, of the `names` (c)."""

    path: str
    unit: str
    names: tuple[str, ...]
    values: tuple[Array, Array]


def _columns(first: Results, second: Results, rows: tuple[Integers, Integers]) -> Iterator[_Columns]:
    for dataset in COMPARED:
        if dataset.symbol is None:
            pair = first[dataset.path][rows[0]][:, None, None], second[dataset.path][rows[1]][:, None, None]
            yield _Columns(dataset.path, dataset.unit, ("",), pair)
            continue
        kind = KINDS[dataset.symbol]
        shared = [name for name in first.names(kind) if name in set(second.names(kind))]
        for unit, names in _by_unit(first, dataset.symbol, dataset.unit, shared):
            at = [[results.names(kind).index(name) for name in names] for results in (first, second)]
            one, other = (
                results[dataset.path][taken][:, columns].reshape(len(taken), len(names), -1)
                for results, taken, columns in zip((first, second), rows, at, strict=True)
            )
            if dataset.path == "bodies/orientation":  # q and -q are one orientation
                other = np.where(np.sum(one * other, axis=-1, keepdims=True) < 0.0, -other, other)
            yield _Columns(dataset.path, unit, names, (one, other))


def _by_unit(results: Results, symbol: str, unit: str, names: list[str]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The names by the unit of their columns, which for "rad or m", "N m or N", ... is a column's own."""
    if symbol not in UNITS:
        groups = {unit: tuple(names)}
    else:
        units = dict(zip(results.names(KINDS[symbol]), results.names(UNITS[symbol]), strict=True))
        groups = {own_unit(unit, of): tuple(name for name in names if units[name] == of) for of in ("rad", "m")}
    yield from ((own, chosen) for own, chosen in groups.items() if chosen)


def _compared(
    columns: _Columns, time: Array, floors: Mapping[str, float], absolute: float | None, tolerance: float
) -> QuantityComparison:
    one, other = columns.values
    distance = np.linalg.norm(one - other, axis=-1)
    unit = columns.unit
    if columns.path == "bodies/orientation":
        distance, unit = 4.0 * np.arcsin(np.minimum(distance / 2.0, 1.0)), "rad"
        size = 1.0
    else:
        size = max(float(np.linalg.norm(values, axis=-1).max()) for values in columns.values)
        size = max(size, floors.get(unit, 0.0))
    allowed = tolerance * size if absolute is None else absolute
    beyond = np.flatnonzero(~(distance <= allowed).all(axis=1))
    first = _parting(columns, distance, time, int(beyond[0])) if len(beyond) else None
    worst = int(np.argmax(distance.max(axis=1)))
    return QuantityComparison(columns.path, unit, _parting(columns, distance, time, worst), allowed, first)


def _parting(columns: _Columns, distance: Array, time: Array, row: int) -> Parting:
    column = int(np.argmax(distance[row]))
    return Parting(float(distance[row, column]), columns.names[column], float(time[row]))


def _floors(first: Results, second: Results) -> dict[str, float]:
    """What a quantity is held to at least, by unit, so that one that is zero but for round-off is not held to zero:
    what the mechanism's extent L, the duration T and the energy E that it exchanged make in its unit."""
    extent = max(float(np.ptp(results["bodies/position"], axis=(0, 1)).max()) for results in (first, second))
    length = extent or max(float(np.abs(results["bodies/position"]).max()) for results in (first, second)) or 1.0
    duration = max(float(np.ptp(results.time)) for results in (first, second)) or 1.0
    energy = max(
        exchanged(results["diagnostics/kinetic_energy"], results["diagnostics/potential_energy"])
        for results in (first, second)
    )
    return {
        "m": length, "m/s": length / duration, "m/s^2": length / duration**2,
        "rad": 1.0, "rad/s": 1.0 / duration, "rad/s^2": 1.0 / duration**2,
        "N": energy / length, "N m": energy, "J": energy,
    }  # fmt: skip


def _check_comparable(first: Results, second: Results, shared: int) -> None:
    if not set(first.names("bodies")) & set(second.names("bodies")):
        message = f"'{first.path}' and '{second.path}' have no body in common"
        raise InputError(Problem(message, hint="give two results of one mechanism"))
    if not shared:
        message = f"'{first.path}' and '{second.path}' have no sample time in common"
        raise InputError(Problem(message, hint="run both with the same --output-step"))


def _one_sided(first: Results, second: Results, kind: str) -> tuple[str, ...]:
    return tuple(sorted(set(first.names(kind)) ^ set(second.names(kind))))
