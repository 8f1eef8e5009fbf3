"""Results as tables of numbers over time: one for each body, marker, joint, force, motion, stop and dry friction, and
one of diagnostics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import prod
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Flags, Integers
from mbproj.base.dataclass import dataclass
from mbproj.results.analysis.expectations import mechanical_advantage, transmission_angle, velocity_ratio
from mbproj.results.analysis.loads import loads_of, shared_at_contacts
from mbproj.results.largest_loads import SOURCES, Load
from mbproj.results.layout import DATASETS
from mbproj.results.record import Over, Results
from mbproj.results.trust import Trust

#: The number of rows that are held as lists at one time.
AT_ONCE = 1000
#: The endings of the names of components, by their number.
COMPONENTS = {1: ("",), 3: ("_x", "_y", "_z"), 4: ("_0", "_1", "_2", "_3")}
#: Tables that do not have a row for each sample.
NOT_OVER = ("loads", "events", "trust")
#: A quantity in a table: its name, its unit, and its dataset and column in the results; None for all columns.
Quantity: TypeAlias = tuple[str, str, str, int | None]


@dataclass(frozen=True, eq=False)
class QuantityTable:
    """A table with a name such as "body-crank" and headings such as "position_x (m)". `read` returns its values (T,
    columns) from the results, which must still be open."""

    name: str
    headings: tuple[str, ...]
    read: Callable[[], npt.NDArray[Any]]

    def rows(self) -> Iterator[list[Any]]:
        """Yield each row as a list. Only the table of loads has texts."""
        values = self.read()
        for first in range(0, len(values), AT_ONCE):
            yield from values[first : first + AT_ONCE].tolist()


def tables(results: Results, corners: Sequence[tuple[str, str, str]] = ()) -> Iterator[QuantityTable]:
    """Yield all tables of these results. The first column of each is time, or the coordinate that results are shown
    over and then time. `corners` are the markers of transmission angles."""
    over = results.shown_over
    for table in _over_time(results):
        yield table if over is None or table.name in NOT_OVER else _with_coordinate(results, table)
    if over is not None:
        yield _with_coordinate(results, QuantityTable("ratios", *_ratios(results, over)))
    for first, corner, second in corners:
        markers = [results.marker(name).position for name in (first, corner, second)]
        angle = np.stack([results.time, transmission_angle(*markers)], axis=1)
        heading = f"angle between {first} and {second} (rad)"
        transmission = QuantityTable(f"transmission-{corner}", ("time (s)", heading), partial(_as_it_is, angle))
        yield transmission if over is None else _with_coordinate(results, transmission)


def _as_it_is(values: Array) -> Array:
    return values


def _with_coordinate(results: Results, table: QuantityTable) -> QuantityTable:
    """Return the table with a column of the coordinate before time, in SI units."""
    over = results.shown_over
    assert over is not None
    values = np.radians(over.values) if over.unit == "rad" else over.values
    headings = (f"{over.name} ({over.unit})", *table.headings)
    return QuantityTable(table.name, headings, lambda: np.concatenate([values[:, None], table.read()], axis=1))


def _ratios(results: Results, over: Over) -> tuple[tuple[str, ...], Callable[[], Array]]:
    """The headings, and a function for the values, of velocity ratios and mechanical advantages of all coordinates to
    the input."""
    names, units = results.names("coordinates"), results.names("coordinate_units")
    others = [(name, unit) for name, unit in zip(names, units, strict=True) if name != over.name]
    input_unit = over.unit
    headings = ["time (s)"]
    for name, unit in others:
        same = unit == input_unit
        headings.append(f"{name} velocity ratio ({'1' if same else f'{unit}/{input_unit}'})")
        headings.append(f"{name} mechanical advantage ({'1' if same else f'{input_unit}/{unit}'})")

    def read() -> Array:
        speed, columns = over.rate, [results.time]
        for name, _ in others:
            output = results.coordinate(name).speed
            columns += [velocity_ratio(output, speed), mechanical_advantage(output, speed)]
        return np.stack(columns, axis=1)

    return tuple(headings), read


def _over_time(results: Results) -> Iterator[QuantityTable]:
    for kind, symbol, group in (("bodies", "n", "body"), ("markers", "k", "marker"), ("joints", "nj", "joint")):
        for column, name in enumerate(results.names(kind)):
            parts = [(dataset.path, dataset.unit) for dataset in DATASETS if dataset.symbol == symbol]
            quantities: list[Quantity] = [(path.partition("/")[2], unit, path, column) for path, unit in parts]
            if kind == "joints":
                quantities += _coordinates(results, name)
            open_ = _not_unique(results, column, name) if kind == "joints" else ()
            yield _table(results, f"{group}-{name}", quantities, open_)
    along = (
        ("forces", "force_units", "nf", "force"),
        ("applied", "applied_units", "na", "force"),
        ("motions", "motion_units", "nm", "motion"),
        ("stops", "stop_units", "ns", "stop"),
        ("frictions", "friction_units", "nr", "friction"),
        ("states", "state_units", "nx", "state"),
        ("signals", "signal_units", "nu", "signal"),
    )
    for kind, units, symbol, group in along:
        columns_of = [dataset for dataset in results.datasets if dataset.symbol == symbol]
        for column, (name, unit) in enumerate(zip(results.names(kind), results.names(units), strict=True)):
            parts = [(dataset.path, own_unit(dataset.unit, unit)) for dataset in columns_of]
            quantities = [(path.partition("/")[2], unit, path, column) for path, unit in parts]
            shares = f"{group} '{name}'" in shared_at_contacts(results)
            yield _table(results, f"{group}-{name}", quantities, ("force",) if shares else ())
    diagnostics = [entry for entry in DATASETS if entry.path.startswith("diagnostics/")]
    quantities = [(entry.path.partition("/")[2], entry.unit, entry.path, None) for entry in diagnostics]
    yield _table(results, "diagnostics", quantities)
    if len(results.time) and any(results.names(source.names) for source in SOURCES):
        yield QuantityTable("loads", tuple(map(_heading, Load._fields)), partial(_loads, results))
    if results.events:
        yield _events(results)
    if results.trust is not None:
        yield _trust(results.trust)


def _loads(results: Results) -> npt.NDArray[Any]:
    return np.array([tuple(load) for load in loads_of(results)], dtype=object)


def _heading(field: str) -> str:
    """The heading of a column of loads, with a unit where all rows share it."""
    units = {"time": " (s)", "place": " (rad or m)", "put_in": " (J)", "taken_out": " (J)"}
    return field + units.get(field, "")


def _events(results: Results) -> QuantityTable:
    """The table of the times at which steps ended at events. The owner and the kind of each are in the results file."""
    headings: tuple[str, ...] = ("time (s)", "direction")
    values = np.array([[event.time, event.direction] for event in results.events])
    if results.names("stops"):
        headings = (*headings, "impulse (N s or N m s)", "energy (J)")
        values = np.hstack([values, [[event.impulse, event.energy] for event in results.events]])
    return QuantityTable("events", headings, lambda: values)


def _trust(trust: Trust) -> QuantityTable:
    """The table of a certified run: the error of each marker, and its uncertainty."""
    headings = [f"{quantity} of {name} (m)" for quantity in ("error", "uncertainty") for name in trust.names]
    values = np.concatenate([trust.time[:, None], trust.error, trust.uncertainty], axis=1)
    return QuantityTable("trust", ("time (s)", *headings), lambda: values)


def _coordinates(results: Results, joint: str) -> Iterator[Quantity]:
    units = results.names("coordinate_units")
    for column, name in enumerate(results.names("coordinates")):
        owner, _, coordinate = name.rpartition(".")
        if owner == joint:
            yield coordinate, units[column], "joints/coordinate", column
            yield f"{coordinate}_speed", f"{units[column]}/s", "joints/speed", column
    if joint in results.names("touching"):
        yield "contact", "m", "curves/contact", list(results.names("touching")).index(joint)
    for column, name in enumerate(results.names("tensions")):
        owner, _, tension = name.rpartition(".")
        if owner == joint:
            yield tension, "N", "ropes/tension", column


def own_unit(either: str, unit: str) -> str:
    """The unit of one column of "rad or m", "N m or N", ... It is the first where `unit` is rad, the second where it is
    m. A single unit stays; "any" means `unit` itself."""
    if either == "any":
        return unit
    first, _, second = either.partition(" or ")
    return first if unit == "rad" or not second else second


def _not_unique(results: Results, column: int, joint: str) -> tuple[str, ...]:
    """The columns of a joint's reactions that are not unique, as "reaction_force_y"."""
    paths: list[str] = []
    shares = f"joint '{joint}'" in shared_at_contacts(results)
    for quantity in ("reaction_force", "reaction_torque"):
        if shares:
            paths += [quantity + component for component in COMPONENTS[3]]
            continue
        unique = results.constant(f"joints/{quantity}_unique")
        if unique is not None:
            paths += [quantity + COMPONENTS[3][axis] for axis in np.flatnonzero(~unique[column])]
    return tuple(paths)


def _table(results: Results, name: str, quantities: list[Quantity], not_unique: tuple[str, ...] = ()) -> QuantityTable:
    headings = ["time (s)"]
    for quantity, unit, path, column in quantities:
        size = prod(results.shape(path)[1 if column is None else 2 :])
        columns_of = [f"{quantity}{component}" for component in COMPONENTS[size]]
        headings += [f"{column} ({unit}{'; not unique' if column in not_unique else ''})" for column in columns_of]
    return QuantityTable(name, tuple(headings), partial(_values, results, quantities))


def _values(results: Results, quantities: list[Quantity]) -> Array:
    """The time and the quantities, as columns."""
    columns = [results.time[:, None]]
    for _, _, path, column in quantities:
        values = results[path] if column is None else results[path][:, column]
        # a copy, because a view would keep the values of all bodies
        columns.append(values.reshape(len(values), prod(values.shape[1:])).copy())
    return np.concatenate(columns, axis=1)


# --- Thinning of long lines for a picture -----------------------------------------------------------------------------
# A page has no room for a million points.


#: The number of points from which on a line is thinned.
MANY = 20_000
#: The columns and rows of a page: each is at most a third of a printed dot.
COLUMNS = 4000


def thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """Return fewer points of a line that look the same on a page. For ascending x these are the first, lowest, highest
    and last point of each column. For another line they are each movement between two dots, once."""
    if len(x) < MANY:
        return x, y
    ascends = bool(np.isfinite(x).all() and (np.diff(x) >= 0.0).all())
    return _thinned_over_time(x, y) if ascends else _path(x, y)


def _thinned_over_time(x: Array, y: Array) -> tuple[Array, Array]:
    column = _cells(x, float(x[0]), float(x[-1] - x[0]) / COLUMNS)
    begins = np.flatnonzero(np.diff(column, prepend=-1))
    of = np.repeat(np.arange(len(begins)), np.diff(begins, append=len(x)))
    low, high = np.fmin.reduceat(y, begins)[of], np.fmax.reduceat(y, begins)[of]
    places = [begins, np.append(begins[1:], len(x)) - 1]  # the first and the last point of each column
    places += [_first(which, of) for which in (y == low, y == high, np.isnan(y))]  # NaN leaves a gap
    at = np.unique(np.concatenate(places))
    return x[at], y[at]


def _first(which: Flags, of: Integers) -> Integers:
    """The index of the first marked point in each column. `of` is the column of each point."""
    marked = np.flatnonzero(which)
    places: Integers = marked[np.unique(of[marked], return_index=True)[1]]
    return places


def _path(x: Array, y: Array) -> tuple[Array, Array]:
    drawn = np.isfinite(x) & np.isfinite(y)
    if not drawn.any():
        return x[:1], y[:1]
    size = max(float(np.ptp(values[drawn])) for values in (x, y)) / COLUMNS
    column, row = (_cells(np.where(drawn, each, 0.0), float(each[drawn].min()), size) for each in (x, y))
    dot = np.where(drawn, column * (COLUMNS + 1) + row, -1)
    moved = np.flatnonzero(np.diff(dot, prepend=-2))
    x, y, dot = np.where(drawn, x, np.nan)[moved], y[moved], dot[moved]
    way = dot[:-1] * (COLUMNS + 1) ** 2 + dot[1:]
    new = np.zeros(len(way), dtype=bool)
    new[np.unique(way, return_index=True)[1]] = True
    places = np.flatnonzero(np.append(new, False) | np.append(True, new))
    ends = np.flatnonzero((np.diff(places) > 1) | ~new[places[:-1]]) + 1
    return np.insert(x[places], ends, np.nan), np.insert(y[places], ends, np.nan)


def _cells(values: Array, first: float, size: float) -> Integers:
    """The number of the cell that each value lies in. Cells have equal `size`, from `first` on."""
    return np.minimum(((values - first) / size).astype(np.int64), COLUMNS) if size > 0.0 else np.zeros(len(values), int)
