"""Finds the largest loads of a run: of joints, motions, forces, stops and frictions, with time, place and means."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import h5py
import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, may_overflow
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.results.between_samples import Pieces, in_and_out, integrals, peaks, pieces, size
from mbproj.results.events import Happening
from mbproj.results.file.checksums import TEXT, create_records, room_for_records, write_records
from mbproj.results.file.contents import Contents

#: The most bytes of a dataset's columns that are read at once.
AT_ONCE = 2**26
TURN = 2.0 * np.pi
NOTHING = float("nan")


@dataclass(frozen=True)
class LoadSource:
    """The source of loads of one kind, as "joint": a quantity, and the path of its dataset. `rate` is the dataset of
    the rate that gives its power. `units` are its units on an angle and on a length. `names` is the kind of names of
    its columns, `units_of` that of their units. `power` is the dataset of its power, where there is one."""

    kind: str
    quantity: str
    path: str
    rate: str | None
    units: tuple[str, str]
    names: str
    units_of: str | None = None
    power: str | None = None


#: The sources of all loads of a run.
SOURCES = (
    LoadSource("joint", "reaction_force", "joints/reaction_force", None, ("N", "N"), "joints"),
    LoadSource("joint", "reaction_torque", "joints/reaction_torque", None, ("N m", "N m"), "joints"),
    LoadSource("motion", "force", "motions/force", "motions/rate", ("N m", "N"), "motions", "motion_units"),
    LoadSource("force", "force", "forces/force", "forces/rate", ("N m", "N"), "forces", "force_units"),
    LoadSource(
        "force", "force", "forces/applied", None, ("N m", "N"), "applied", "applied_units", "forces/applied_power"
    ),
    LoadSource("stop", "force", "stops/force", None, ("N m", "N"), "stops", "stop_units"),
    LoadSource("friction", "force", "friction/force", "friction/rate", ("N m", "N"), "frictions", "friction_units"),
)


class Load(NamedTuple):
    """A load of a run: its item ("joint", "A"), its quantity, its unit. `largest` is the largest magnitude, of a scalar
    with its sign, and `uncertainty` the error that interpolation may leave. It occurs at `time` in s and at `place`,
    the coordinate of the cycle in rad (modulo a turn) or m. `mean` and `rms` are over time. `put_in` and `taken_out`
    are the works in J of a power where it is above and below zero. `unique` is false for a reaction that redundant
    joints share in an undetermined way. Numbers that do not apply are NaN."""

    kind: str
    name: str
    quantity: str
    unit: str
    largest: float
    uncertainty: float
    time: float
    place: float
    mean: float
    rms: float
    put_in: float = NOTHING
    taken_out: float = NOTHING
    unique: bool = True


class _LoadNumbers(NamedTuple):
    """The numbers of a `Load` that every kind has."""

    largest: float
    uncertainty: float
    time: float
    place: float
    mean: float
    rms: float


class Cycle(NamedTuple):
    """The coordinate that gives the place in the cycle: its name, its unit, its values (T,)."""

    name: str
    unit: str
    values: Array


@dataclass(frozen=True, eq=False)
class Recorded:
    """The record of a run from which loads are computed. `names` are those of columns by kind; `read` reads the columns
    `slice` of a dataset, (T, C, ...); `events` are times in s. `open` gives, for a dataset of reactions, projections
    (nj, 3, 3) on the directions along which they are not unique; None where these are not known."""

    names: Mapping[str, Sequence[str]]
    read: Callable[[str, slice], npt.NDArray[Any]]
    time: Array
    events: Array
    open: Callable[[str], Array | None]

    def cycle(self) -> Cycle | None:
        """The coordinate of the first motion that drives an angle, else of the first motion; None without motions."""
        units = list(self.names.get("motion_units", ()))
        if not units:
            return None
        column = units.index("rad") if "rad" in units else 0
        values = self.read("motions/value", slice(column, column + 1))[:, 0]
        return Cycle(f"motion '{self.names['motions'][column]}'", units[column], values)


def open_directions(constant: Callable[[str], npt.NDArray[Any] | None], path: str) -> Array | None:
    """The projections (nj, 3, 3) of `Recorded.open`, by a run's constants. An older file has marks of components."""
    projections, marks = constant(f"{path}_open"), constant(f"{path}_unique")
    if projections is None and marks is not None:
        return np.asarray(np.where(marks, 0.0, 1.0)[:, :, None] * np.eye(3))
    return projections


def loads(recorded: Recorded, cycle: Cycle | None) -> list[Load]:
    """All loads of the run, kind by kind; [] without samples."""
    if not len(recorded.time):
        return []
    piece = pieces(recorded.time, recorded.events)
    with may_overflow():
        return [load for source in SOURCES for load in _of_source(recorded, source, piece, cycle)]


def _of_source(recorded: Recorded, source: LoadSource, piece: Pieces, cycle: Cycle | None) -> Iterator[Load]:
    names = recorded.names.get(source.names, ())
    width = max(1, AT_ONCE // (24 * len(recorded.time)))
    open_ = recorded.open(source.path) if names and source.kind == "joint" else None
    for first in range(0, len(names), width):
        chosen = slice(first, min(first + width, len(names)))
        values = recorded.read(source.path, chosen)
        values = values.reshape(len(values), values.shape[1], -1)
        units = recorded.names.get(source.units_of or "", ())
        angular = [not units or unit == "rad" for unit in units[chosen] or [""] * (chosen.stop - first)]
        unit = [source.units[0] if turns else source.units[1] for turns in angular]
        load_numbers, largest = _rows(recorded.time, values, piece, cycle), float(np.abs(values).max(initial=0.0))
        for name, load_unit, numbers, column in zip(
            names[chosen], unit, load_numbers, range(first, chosen.stop), strict=True
        ):
            sure = open_ is None or _is_unique(values[:, column - first] @ open_[column], largest)
            yield Load(source.kind, name, source.quantity, load_unit, *numbers)._replace(unique=sure)
        power = None if source.power is None else recorded.read(source.power, chosen)
        if source.rate is not None:
            power = values[..., 0] * recorded.read(source.rate, chosen)
        if power is not None:
            works = zip(*in_and_out(recorded.time, power, piece), strict=True)
            peaks_of = _rows(recorded.time, power[..., None], piece, cycle)
            for name, numbers, (put_in, out) in zip(names[chosen], peaks_of, works, strict=True):
                yield Load(source.kind, name, "power", "W", *numbers, float(put_in), float(out))


def _is_unique(shared: Array, largest: float) -> bool:
    """Whether a reaction is unique: its part (T, 3) along the directions that are not is none of the `largest`
    reaction. In a machine that moves in a plane these directions are normal to the plane."""
    return bool(np.abs(shared).max(initial=0.0) <= THRESHOLDS.no_part * largest)


def _rows(time: Array, values: Array, piece: Pieces, cycle: Cycle | None) -> list[_LoadNumbers]:
    """The row of numbers for each column of `values` (T, C, k)."""
    extremes, sizes = peaks(time, values, piece), size(values)
    place = np.full(len(extremes.time), NOTHING) if cycle is None else _place(time, cycle, extremes.time)
    span = float(time[-1] - time[0])
    if span > 0.0:
        mean = integrals(time, sizes, piece).sum(axis=0) / span
        rms = np.sqrt(np.maximum(integrals(time, sizes**2, piece).sum(axis=0), 0.0) / span)
    else:
        mean, rms = sizes[-1], np.abs(sizes[-1])
    return [_LoadNumbers(*map(float, row)) for row in zip(*extremes, place, mean, rms, strict=True)]


def _place(time: Array, cycle: Cycle, when: Array) -> Array:
    at = np.interp(when, time, cycle.values)
    return np.asarray(at % TURN if cycle.unit == "rad" else at)


# --- The /summary/loads group of a results file -----------------------------------------------------------------------
# The largest loads of the run, one row each.


GROUP = "summary/loads"
OF_CYCLE = "rad or m"
#: The HDF5 type of an entry, its unit and its description, by field of a `Load`.
LAYOUT = {
    "kind": (TEXT, "", "of what: joint, motion, force, stop, friction"),
    "name": (TEXT, "", "its name"),
    "quantity": (TEXT, "", "reaction_force, reaction_torque, force or power"),
    "unit": (TEXT, "", "unit of largest, uncertainty, mean and rms"),
    "largest": ("f8", "per row in unit", "largest magnitude, with its sign where it has one"),
    "uncertainty": ("f8", "per row in unit", "how far it may be off for want of samples"),
    "time": ("f8", "s", "when"),
    "place": ("f8", OF_CYCLE, "coordinate of the first motion there, modulo a turn; nan without motions"),
    "mean": ("f8", "per row in unit", "mean over time, of magnitudes where it is a vector"),
    "rms": ("f8", "per row in unit", "root of the mean square over time"),
    "put_in": ("f8", "J", "work where the power is positive; nan of what is no power"),
    "taken_out": ("f8", "J", "work where the power is negative, as a positive number"),
    "unique": ("i8", "1", "1; 0 where redundant joints share the reaction at will"),
}


def create(file: h5py.File) -> None:
    """Create the group without rows, which are written at the end of the run."""
    create_records(file, GROUP, LAYOUT)


def room(names: Mapping[str, Sequence[str]]) -> int:
    """The most bytes that `write` adds to the file for a run with these names by kind: two rows a name."""
    return room_for_records(2 * sum(map(len, names.values())), LAYOUT)


def recorded_loads(
    targets: Mapping[str, h5py.Dataset],
    names: Mapping[str, Sequence[str]],
    constants: Mapping[str, npt.NDArray[Any]],
    events: Sequence[Happening],
) -> list[Load]:
    """The largest loads of a run, from samples that are read back from its file: there may be more than memory
    holds."""
    recorded = Recorded(
        names,
        lambda path, columns: targets[path][:, columns],
        targets["time"][:],
        np.array([event.time for event in events]),
        lambda path: open_directions(constants.get, path),
    )
    return loads(recorded, recorded.cycle())


def write(file: h5py.File, loads: Sequence[Load]) -> None:
    """Write the loads into the group."""
    write_records(file, GROUP, LAYOUT, loads)


def read(contents: Contents) -> tuple[Load, ...]:
    """Read the loads; () where the file has no such group."""
    if not contents.has(GROUP):
        return ()
    texts = [contents.texts(f"{GROUP}/{name}") for name, (dtype, _, _) in LAYOUT.items() if dtype is TEXT]
    shape = (len(texts[0]),)
    if any(len(column) != shape[0] for column in texts):
        raise contents.damaged(GROUP, "does not fit together")
    plain = [name for name, (dtype, _, _) in LAYOUT.items() if dtype == "f8"]
    numbers = [contents.array(f"{GROUP}/{name}", shape).tolist() for name in plain]
    unique = contents.array(f"{GROUP}/unique", shape, np.int64).astype(bool).tolist()
    return tuple(Load(*row) for row in zip(*texts, *numbers, unique, strict=True))
