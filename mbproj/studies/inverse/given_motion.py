"""Given motions: columns of a CSV file, or the joint coordinates of a results file."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.model.system import System
from mbproj.results import Results
from mbproj.studies.inverse.columns import TIME_NAMES, CsvTable, factor_of, read_columns

#: The fewest samples for a spline of degree 5.
FEWEST = 6
_MARKER = re.compile(r"(?P<marker>.+)\.(?:position_)?(?P<axis>[xyz])")


@dataclass(frozen=True, eq=False)
class GivenMotion:
    """Samples at the times (T,) in s. `values` (T, c) are joint coordinates such as "crank.angle" and positions of
    markers such as "tip.x". `units` are rad or m."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    time: Array
    values: Array


def known_columns(system: System) -> dict[str, str]:
    """The names of all coordinates whose motion can be given, with their SI units."""
    names = system.names
    units = dict(zip(names.coordinates, names.coordinate_units, strict=True))
    return units | {f"{marker}.{axis}": "m" for marker in names.markers for axis in "xyz"}


def from_csv(system: System, path: Path) -> GivenMotion:
    """Read a motion from a CSV file. Its first line names the columns: `time (s), crank.angle (deg), tip.x (mm)`.
    Without a unit they are in s, rad and m. Raises InputError with file and line where a cell is no number, a column is
    unknown to the scene, or times do not ascend."""
    table = read_columns(path, "--given")
    place = Place(str(path), table.heading_line)
    columns = [_column(system, name, unit, place) for name, unit in table.headings]
    names = [name for name, _, _ in columns]
    for name in names:
        if names.count(name) > 1:
            raise InputError(Problem(f"two columns are of '{name}'", place, "leave one of them out"))
    if "time" not in names or len(names) < 2:
        raise InputError(Problem("it needs a column 'time (s)' and one of the motion", place, _columns_hint(system)))
    rows = table.rows * [factor for _, _, factor in columns]
    at = names.index("time")
    given = GivenMotion(
        tuple(name for name in names if name != "time"),
        tuple(unit for name, unit, _ in columns if name != "time"),
        rows[:, at],
        np.delete(rows, at, axis=1),
    )
    return _checked(given, path, table)


def from_results(system: System, results: Results) -> GivenMotion:
    """The motion of all joint coordinates that the results share with the scene. Raises InputError where there are
    none."""
    shared = [name for name in system.names.coordinates if name in results.names("coordinates")]
    if not shared:
        have = choose_from("", system.names.coordinates, "the scene has")
        raise InputError(Problem(f"'{results.path}' has no joint coordinate of the scene", hint=have))
    units = dict(zip(system.names.coordinates, system.names.coordinate_units, strict=True))
    last = np.append(np.diff(results.time) > 0.0, True)  # of two samples at an event take the one after it
    values = np.stack([results.coordinate(name).value for name in shared], axis=1)
    motion = GivenMotion(tuple(shared), tuple(units[name] for name in shared), results.time[last], values[last])
    return _checked(motion, results.path, None)


def _column(system: System, name: str, unit: str, place: Place) -> tuple[str, str, float]:
    """The name of a column's coordinate, its SI unit, and the factor from the column's unit to it."""
    known = known_columns(system)
    marker = _MARKER.fullmatch(name)
    if name not in known and marker and f"{marker['marker']}.{marker['axis']}" in known:
        name = f"{marker['marker']}.{marker['axis']}"
    if name.lower() in TIME_NAMES:
        return "time", "s", factor_of(name, unit, "s", place)
    if name not in known:
        message = f"column '{name}' is no joint coordinate and no component of a marker"
        raise InputError(Problem(message, place, f"leave it out, or rename it; {choose_from(name, known)}"))
    return name, known[name], factor_of(name, unit, known[name], place)


def _columns_hint(system: System) -> str:
    return choose_from("", known_columns(system), "columns may be")


def _checked(given: GivenMotion, path: Path, columns: CsvTable | None) -> GivenMotion:
    if len(given.time) < FEWEST:
        message = f"it has {len(given.time)} samples, and a spline of degree 5 needs {FEWEST}"
        raise InputError(Problem(message, Place(str(path)), "give more samples"))
    wrong = np.flatnonzero(~(np.diff(given.time) > 0.0))
    if len(wrong):
        place = Place(str(path), None if columns is None else columns.lines[int(wrong[0]) + 1])
        raise InputError(Problem("its time is not after the one before", place, "sort the samples by time"))
    return given
