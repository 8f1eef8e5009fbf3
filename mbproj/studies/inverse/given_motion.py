"""Reading a CSV table of measurements: headings such as `time (s)`, then lines of numbers."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.plain_number import plain_number
from mbproj.scene.expressions.units import unit_of
from mbproj.scene.fields.quantities import agrees

#: The largest CSV file that is read, bytes.
MOST_BYTES = 2**28
_HEADING = re.compile(r"\s*(?P<name>.*?)\s*(?:[(\[]\s*(?P<unit>[^)\]]*?)\s*[)\]])?\s*")
TIME_NAMES = ("time", "t")


@dataclass(frozen=True, eq=False)
class CsvTable:
    """A table with c columns. `headings` are pairs of a name and a unit ("" where there is none), from the line
    `heading_line`. `rows` (T, c) are the numbers as written; `lines` are their line numbers."""

    headings: tuple[tuple[str, str], ...]
    heading_line: int
    rows: Array
    lines: tuple[int, ...]


def read_columns(path: Path, asked: str) -> CsvTable:
    """Read the table in a file. `asked` is the option that named the file. Raises InputError with file and line where
    the file is no table, two columns have one name, or a cell is no finite number."""
    lines = _lines(path, asked)
    if not lines:
        raise InputError(Problem("it is empty", Place(str(path)), "give a line of names, then a line for each sample"))
    first, cells = lines[0]
    headings = tuple(_heading(cell) for cell in cells)
    names = [name for name, _ in headings]
    for name in names:
        if name and names.count(name) > 1:
            at = Place(str(path), first)
            raise InputError(Problem(f"two columns are of '{name}'", at, "leave one of them out, or rename it"))
    rows = np.array([_numbers(path, line, row, len(cells)) for line, row in lines[1:]], dtype=float)
    return CsvTable(headings, first, rows.reshape(-1, len(cells)), tuple(line for line, _ in lines[1:]))


def factor_of(name: str, unit: str, wanted: str, place: Place) -> float:
    """The factor from `unit` to the SI unit `wanted`; 1 where the column has no unit. Raises InputError where the unit
    is unknown, or of another quantity."""
    if not unit:
        return 1.0
    hint = f"give it in {wanted}" if wanted else "give it without a unit"
    try:
        unit_read = unit_of(unit)
    except ValueError as error:
        raise InputError(Problem(f"column '{name}': unknown unit '{unit}'", place, hint)) from error
    if not agrees(wanted, unit_read.dimension):
        what = f"is in {wanted}" if wanted else "has no unit"
        raise InputError(Problem(f"column '{name}' {what}, and '{unit}' is not", place, hint))
    return unit_read.multiply / unit_read.divide


def _heading(cell: str) -> tuple[str, str]:
    match = _HEADING.fullmatch(cell)
    return (match["name"], match["unit"] or "") if match else (cell.strip(), "")


def _lines(path: Path, asked: str) -> list[tuple[int, list[str]]]:
    """The lines that are neither empty nor comments, split into cells, with their numbers."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(Problem(f"it has more than {MOST_BYTES >> 20} MB", Place(str(path)), "thin it out"))
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        problem = Problem(f"cannot read '{path}': {error.strerror or error}", Place(asked))
        raise InputError(problem) from error
    except UnicodeDecodeError as error:
        raise InputError(Problem("it is not a text in UTF-8", Place(str(path)), "give a CSV file")) from error
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    separator = next((mark for mark in (",", ";", "\t") if mark in first), ",")
    reader = csv.reader(text.splitlines(), delimiter=separator)
    try:
        rows = [(reader.line_num, cells) for cells in reader]
    except csv.Error as error:
        raise InputError(Problem(f"it is no CSV table: {error}", Place(str(path), reader.line_num))) from error
    return [(line, cells) for line, cells in rows if "".join(cells).strip() and not cells[0].startswith("#")]


def _numbers(path: Path, line: int, cells: list[str], count: int) -> list[float]:
    place = Place(str(path), line)
    if len(cells) != count:
        raise InputError(Problem(f"it has {len(cells)} cells, and the first line has {count}", place))
    try:
        numbers = [plain_number(cell) for cell in cells]
    except ValueError:
        wrong = next(cell for cell in cells if not _is_number(cell))
        raise InputError(Problem(f"'{wrong.strip()}' is not a number", place, "give every sample a number")) from None
    if not np.isfinite(numbers).all():
        raise InputError(Problem("a number is not finite", place, "leave this sample out"))
    return numbers


def _is_number(cell: str) -> bool:
    try:
        plain_number(cell)
    except ValueError:
        return False
    return True
