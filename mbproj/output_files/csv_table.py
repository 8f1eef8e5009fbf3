"""CSV tables, whose texts are safe in a spreadsheet: none is taken for a formula, none has control characters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from csv import writer as csv_writer
from pathlib import Path

from mbproj.control_characters import escaped
from mbproj.output_files import kinds
from mbproj.output_files.replace import ELSEWHERE, replacing

#: The first characters by which a spreadsheet takes a text for a formula.
FORMULA = ("=", "+", "-", "@")


def write_csv(
    path: Path,
    headings: Sequence[str],
    rows: Iterable[Sequence[object]],
    *,
    form: str = "",
    kind: kinds.FileKind | None = None,
    force: bool = False,
    hint: str = ELSEWHERE,
) -> Path:
    """Write the table and return `path`; floats in the format `form` ("": as few digits as give the same number back).
    `kind` is the kind of file that it may replace, where that does not follow from the headings."""
    with (
        replacing(path, kind or kinds.csv(headings), force=force, hint=hint) as draft,
        draft.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv_writer(file, lineterminator="\n")
        writer.writerow([_cell(heading, form) for heading in headings])
        numbers = ",".join([f"%{form}"] * len(headings)) + "\n"
        for row in rows:
            if form and all(type(value) is float for value in row):  # takes a third of the time; tables can be long
                file.write(numbers % tuple(row))
            else:
                writer.writerow([_cell(value, form) for value in row])
    return path


def _cell(value: object, form: str) -> object:
    if isinstance(value, float):
        return format(value, form)
    if not isinstance(value, str):
        return value
    text = escaped(value)
    return f"'{text}" if text.startswith(FORMULA) else text
