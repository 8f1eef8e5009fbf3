"""Motions as they are given: columns of a CSV file, or the joint coordinates of a results file."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.model.system import System
from mbproj.results import Results
from mbproj.scene.expressions.unit_text import unit_of
from mbproj.scene.fields.quantities import agrees
from mbproj.scene.text.suggestions import choose_from

#: Samples that a spline of degree 5 needs.
FEWEST = 6
#: Bytes of a CSV file that is read, at most.
MOST_BYTES = 2**28
_HEADING = re.compile(r"\s*(?P<name>.*?)\s*(?:[(\[]\s*(?P<unit>[^)\]]*?)\s*[)\]])?\s*")
_MARKER = re.compile(r"(?P<marker>.+)\.(?:position_)?(?P<axis>[xyz])")
TIME_NAMES = ("time", "t")


@dataclass(frozen=True, eq=False)
class GivenMotion:
    """Samples at the times (T,) in s: values (T, c) of joint coordinates "crank.angle" and of positions of markers
    "tip.x", by `names`, in the SI `units` rad and m."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    time: Array
    values: Array


def known_columns(system: System) -> dict[str, str]:
    """What a motion may be given of, with its unit."""
    names = system.names
    found = dict(zip(names.coordinates, names.coordinate_units, strict=True))
    return found | {f"{marker}.{axis}": "m" for marker in names.markers for axis in "xyz"}


def from_csv(system: System, path: Path) -> GivenMotion:
    """The motion in a CSV file: its first line names the columns, `time (s), crank.angle (deg), tip.x (mm)`. Without a
    unit they are in s, rad and m. Raises InputError with file and line where a cell is no number, a column names
    nothing of the scene, or times do not ascend."""
    lines = _lines(path)
    if not lines:
        raise InputError(Problem("it is empty", Place(str(path)), "give a line of names, then a line for each sample"))
    headings, place = lines[0][1], Place(str(path), lines[0][0])
    columns = [_column(system, heading, place) for heading in headings]
    names = [name for name, _, _ in columns]
    for name in names:
        if names.count(name) > 1:
            raise InputError(Problem(f"two columns are of '{name}'", place, "leave one of them out"))
    if "time" not in names or len(names) < 2:
        raise InputError(Problem("it needs a column 'time (s)' and one of the motion", place, _listed(system)))
    rows = np.array([_numbers(path, line, cells, len(columns)) for line, cells in lines[1:]], dtype=float)
    rows = rows.reshape(-1, len(columns)) * [factor for _, _, factor in columns]
    at = names.index("time")
    numbers = [line for line, _ in lines[1:]]
    return _checked(
        GivenMotion(
            tuple(name for name in names if name != "time"),
            tuple(unit for name, unit, _ in columns if name != "time"),
            rows[:, at],
            np.delete(rows, at, axis=1),
        ),
        path,
        numbers,
    )


def from_results(system: System, results: Results) -> GivenMotion:
    """All joint coordinates that the results share with the scene. Raises InputError where there are none."""
    shared = [name for name in system.names.coordinates if name in results.names("coordinates")]
    if not shared:
        have = choose_from("", system.names.coordinates, "the scene has")
        raise InputError(Problem(f"'{results.path}' has no joint coordinate of the scene", hint=have))
    units = dict(zip(system.names.coordinates, system.names.coordinate_units, strict=True))
    last = np.append(np.diff(results.time) > 0.0, True)  # two samples at an event: the one after it
    values = np.stack([results.coordinate(name).value for name in shared], axis=1)
    found = GivenMotion(tuple(shared), tuple(units[name] for name in shared), results.time[last], values[last])
    return _checked(found, results.path, None)


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """The lines that are neither empty nor comments, with their numbers."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(Problem(f"it has more than {MOST_BYTES >> 20} MB", Place(str(path)), "thin it out"))
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        problem = Problem(f"cannot read '{path}': {error.strerror or error}", Place("--given"))
        raise InputError(problem) from error
    except UnicodeDecodeError as error:
        raise InputError(Problem("it is not a text in UTF-8", Place(str(path)), "give a CSV file")) from error
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    separator = next((mark for mark in (",", ";", "\t") if mark in first), ",")
    reader = csv.reader(text.splitlines(), delimiter=separator)
    try:
        found = [(reader.line_num, cells) for cells in reader]
    except csv.Error as error:
        raise InputError(Problem(f"it is no CSV table: {error}", Place(str(path), reader.line_num))) from error
    return [(line, cells) for line, cells in found if "".join(cells).strip() and not cells[0].startswith("#")]


def _column(system: System, heading: str, place: Place) -> tuple[str, str, float]:
    """The name of a column, its SI unit, and what its numbers are multiplied by."""
    match = _HEADING.fullmatch(heading)
    name, text = (match["name"], match["unit"]) if match else (heading.strip(), None)
    known = known_columns(system)
    marker = _MARKER.fullmatch(name)
    if name not in known and marker and f"{marker['marker']}.{marker['axis']}" in known:
        name = f"{marker['marker']}.{marker['axis']}"
    if name.lower() in TIME_NAMES:
        name, unit = "time", "s"
    elif name in known:
        unit = known[name]
    else:
        message = f"column '{name}' is no joint coordinate and no component of a marker"
        raise InputError(Problem(message, place, f"leave it out, or rename it; {choose_from(name, known)}"))
    if not text:
        return name, unit, 1.0
    try:
        found = unit_of(text)
    except ValueError as error:
        raise InputError(Problem(f"column '{name}': unknown unit '{text}'", place, f"give it in {unit}")) from error
    if not agrees(unit, found.dimension):
        raise InputError(Problem(f"column '{name}' is in {unit}, and '{text}' is not", place, f"give it in {unit}"))
    return name, unit, found.multiply / found.divide


def _listed(system: System) -> str:
    return choose_from("", known_columns(system), "columns may be")


def _numbers(path: Path, line: int, cells: list[str], count: int) -> list[float]:
    place = Place(str(path), line)
    if len(cells) != count:
        raise InputError(Problem(f"it has {len(cells)} cells, and the first line has {count}", place))
    try:
        found = [float(cell) for cell in cells]
    except ValueError:
        wrong = next(cell for cell in cells if not _is_number(cell))
        raise InputError(Problem(f"'{wrong.strip()}' is not a number", place, "give every sample a number")) from None
    if not np.isfinite(found).all():
        raise InputError(Problem("a number is not finite", place, "leave this sample out"))
    return found


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _checked(given: GivenMotion, path: Path, lines: list[int] | None) -> GivenMotion:
    if len(given.time) < FEWEST:
        message = f"it has {len(given.time)} samples, and a spline of degree 5 needs {FEWEST}"
        raise InputError(Problem(message, Place(str(path)), "give more samples"))
    wrong = np.flatnonzero(~(np.diff(given.time) > 0.0))
    if len(wrong):
        place = Place(str(path), None if lines is None else lines[int(wrong[0]) + 1])
        raise InputError(Problem("its time is not after the one before", place, "sort the samples by time"))
    return given
