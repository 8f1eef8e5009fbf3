"""CSV tables. Text in them is data for a spreadsheet, too: never a formula, never a control character."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

from mbproj.outputs import kinds
from mbproj.outputs.escapes import escaped
from mbproj.outputs.replace import ELSEWHERE, replacing

#: What makes a spreadsheet take a text for a formula, where the text begins with it.
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
    """Writes the table; floats in the format `form` ("": as few digits as give the same number back). `kind`: what it
    may replace, where that does not follow from the headings."""
    with (
        replacing(path, kind or kinds.csv(headings), force=force, hint=hint) as draft,
        draft.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([_cell(heading, form) for heading in headings])
        numbers = ",".join([f"%{form}"] * len(headings)) + "\n"
        for row in rows:
            if form and all(type(value) is float for value in row):  # a third of the time: tables can be very long
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
