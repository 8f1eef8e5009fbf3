"""The comparison of two results: the largest difference of each quantity, and where the motions first part."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.results.analysis.loads import REACTIONS, Marks, open_components
from mbproj.results.analysis.summary import exchanged
from mbproj.results.analysis.tables import own_unit
from mbproj.results.layout import DATASETS
from mbproj.results.record import Results
from mbproj.results.views import Table, Tabled

# --- The quantities that two results have in common, side by side, so that they can be compared -----------------------


#: The kind of names that belongs to the symbol of a dataset's columns.
KINDS = {"n": "bodies", "k": "markers", "nj": "joints", "nc": "coordinates", "nf": "forces", "nm": "motions"}
#: The kind of names that holds the units of columns, where each column has its own unit.
UNITS = {"nc": "coordinate_units", "nf": "force_units", "nm": "motion_units"}
ENERGIES = ("kinetic_energy", "potential_energy", "total_energy", "work", "dissipation")
#: Datasets of the accuracy with which joints are closed, not of the motion.
LEFT_OUT = ("joints/violation", "joints/violation_length", "joints/violation_angle")
#: The datasets that are compared.
COMPARED = tuple(
    dataset
    for dataset in DATASETS
    if (dataset.symbol and dataset.path not in LEFT_OUT) or dataset.path.removeprefix("diagnostics/") in ENERGIES
)


@dataclass(frozen=True, eq=False)
class SharedColumns:
    """A quantity that both results have, in one unit: values (S, c, k) of each at the common times, for the `names`
    (c)."""

    path: str
    unit: str
    names: tuple[str, ...]
    values: tuple[Array, Array]


def shared_columns(first: Results, second: Results, rows: tuple[Integers, Integers]) -> Iterator[SharedColumns]:
    """Yield the datasets of `COMPARED` at these rows of each result. Columns are in the order of the first."""
    for dataset in COMPARED:
        if dataset.symbol is None:
            pair = first[dataset.path][rows[0]][:, None, None], second[dataset.path][rows[1]][:, None, None]
            yield SharedColumns(dataset.path, dataset.unit, ("",), pair)
            continue
        kind = KINDS[dataset.symbol]
        shared = [name for name in first.names(kind) if name in set(second.names(kind))]
        for unit, names in _by_unit(first, dataset.symbol, dataset.unit, shared):
            at = [[results.names(kind).index(name) for name in names] for results in (first, second)]
            one, other = (
                results[dataset.path][taken][:, columns].reshape(len(taken), len(names), -1)
                for results, taken, columns in zip((first, second), rows, at, strict=True)
            )
            if dataset.path in REACTIONS:  # redundant joints share these arbitrarily
                unique = unique_in_both(first, second, dataset.path, names)
                one, other = np.where(unique, one, 0.0), np.where(unique, other, 0.0)
            if dataset.path == "bodies/orientation":  # q and -q are one orientation
                other = np.where(np.sum(one * other, axis=-1, keepdims=True) < 0.0, -other, other)
            yield SharedColumns(dataset.path, unit, names, (one, other))


def unique_in_both(first: Results, second: Results, path: str, joints: Sequence[str]) -> Marks:
    """Mark the components (c, 3) of the reactions `path` of these joints that are unique in both results. All are where
    a result has no marks."""
    unique = np.ones((len(joints), 3), dtype=bool)
    for results in (first, second):
        marks = results.constant(f"{path}_unique")
        if marks is not None:
            unique &= marks[[results.names("joints").index(name) for name in joints]]
    return unique


def reactions_left_out(first: Results, second: Results) -> dict[str, str]:
    """The components of reactions that are not compared, as "Fy Tx Tz", for the joints of both results."""
    joints = [name for name in first.names("joints") if name in set(second.names("joints"))]
    return open_components(joints, *(unique_in_both(first, second, path, joints) for path in REACTIONS))


def _by_unit(results: Results, symbol: str, unit: str, names: list[str]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The names, grouped by the unit of their columns. In "rad or m", "N m or N", ... each column has its own unit."""
    if symbol not in UNITS:
        groups = {unit: tuple(names)}
    else:
        units = dict(zip(results.names(KINDS[symbol]), results.names(UNITS[symbol]), strict=True))
        groups = {own_unit(unit, of): tuple(name for name in names if units[name] == of) for of in ("rad", "m")}
    yield from ((column_unit, chosen) for column_unit, chosen in groups.items() if chosen)


def floors(first: Results, second: Results) -> dict[str, float]:
    """The least sizes to which a tolerance refers, by unit. So a quantity that is only round-off is not compared with
    zero. Sizes are made from the mechanism's extent L, the duration T and the exchanged energy E."""
    extent = max(float(np.ptp(results["bodies/position"], axis=(0, 1)).max()) for results in (first, second))
    length = extent or max(float(np.abs(results["bodies/position"]).max()) for results in (first, second)) or 1.0
    duration = max(float(np.ptp(results.time)) for results in (first, second)) or 1.0
    energy = max(
        exchanged(results["diagnostics/kinetic_energy"], results["diagnostics/potential_energy"])
        for results in (first, second)
    )
    return {
        "m": length,
        "m/s": length / duration,
        "m/s^2": length / duration**2,
        "rad": 1.0,
        "rad/s": 1.0 / duration,
        "rad/s^2": 1.0 / duration**2,
        "N": energy / length,
        "N m": energy,
        "J": energy,
        "W": energy / duration,
    }


def one_sided(first: Results, second: Results, kind: str) -> tuple[str, ...]:
    """The names of a kind that only one of the two results has."""
    return tuple(sorted(set(first.names(kind)) ^ set(second.names(kind))))


# --- The comparison of two runs of one mechanism at the sample times that they share ----------------------------------


#: Sample times count as equal where they differ by less than this part of the sampling interval.
SAME_TIME = 1e-6


@dataclass(frozen=True)
class Difference:
    """The distance (S) in m between two paths at the common `time` (S) in s."""

    time: Array
    distance: Array

    @property
    def largest(self) -> float:
        """The largest distance in m; NaN where a path has a NaN."""
        return float(np.max(self.distance))


def common_samples(first: Array, second: Array) -> tuple[Integers, Integers]:
    """Indices (S), (S) of the sample times that two increasing series (s) share. Nothing is interpolated."""
    if len(first) == 0 or len(second) == 0:
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    intervals = np.concatenate([np.diff(first), np.diff(second)])
    tolerance = SAME_TIME * float(np.median(intervals)) if len(intervals) else 0.0
    after = np.minimum(np.searchsorted(second, first), len(second) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(second[after] - first) < np.abs(second[before] - first), after, before)
    shared = np.flatnonzero(np.abs(second[nearest] - first) <= tolerance)
    return shared, nearest[shared]


def trajectory_difference(first: Results, second: Results, marker: str) -> Difference:
    """The distance between the paths of a marker. Raises InputError for an unknown marker, and for results without
    common times."""
    paths = first.marker(marker).position, second.marker(marker).position
    rows = common_samples(first.time, second.time)
    if len(rows[0]) == 0:
        message = f"'{first.path}' and '{second.path}' have no sample time in common"
        raise InputError(Problem(message, hint="run both with the same --output-step"))
    distance = np.linalg.norm(paths[0][rows[0]] - paths[1][rows[1]], axis=1)
    return Difference(first.time[rows[0]], distance)


# --- The comparison of two results ------------------------------------------------------------------------------------


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
    bounds = absolute or {}
    partings = [
        _compared(columns, first.time[rows[0]], least, bounds.get(columns.path), tolerance)
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
