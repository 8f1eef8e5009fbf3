"""The quantities that two results have in common, side by side, so that they can be compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.analysis.energy import exchanged
from mbproj.analysis.reactions import REACTIONS, Marks, open_components
from mbproj.analysis.tables import own_unit
from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.results import DATASETS, Results

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
    yield from ((own, chosen) for own, chosen in groups.items() if chosen)


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
