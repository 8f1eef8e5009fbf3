"""Output of commands: tables in plain text, JSON, notes on a scene."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from mbproj.base.errors import Problem


def table(values: Mapping[str, str], indent: str = "") -> Iterator[str]:
    """A line for each name, the values in one column."""
    width = max(map(len, values), default=0)
    for key, value in values.items():
        yield f"{indent}{key:<{width}}  {value}"


def columns(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in plain text. The first column and the column `setting` are left-aligned, the others right-aligned."""
    table = [list(headings), *map(list, rows)]
    widths = [max(len(row[column]) for row in table) for column in range(len(headings))]
    lines = [
        "  ".join(
            cell.ljust(width) if heading == "setting" or heading is headings[0] else cell.rjust(width)
            for cell, width, heading in zip(row, widths, headings, strict=True)
        ).rstrip()
        for row in table
    ]
    return "\n".join(lines)


def number(value: float, form: str = ".1e") -> str:
    """A number in a table; a dash for NaN."""
    return "-" if value != value else format(value, form)


def milliseconds(seconds: float) -> str:
    """A time in ms with three digits; a dash where it is infinite or NaN."""
    value = 1e3 * seconds
    return "-" if not seconds < float("inf") else f"{value:.3g}" if value < 1000.0 else f"{value:.0f}"


def json_text(contents: Any, indent: int | None = None) -> str:
    """Convert `contents` to JSON. NumPy's arrays become lists and paths become text; NaN and infinity, which JSON
    lacks, become null."""
    return json.dumps(_plain(contents), indent=indent, ensure_ascii=False, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    return None if isinstance(value, float) and not isfinite(value) else value


def show_notes(notes: Iterable[Problem]) -> None:
    """Print a line for each note on stderr."""
    for note in notes:
        click.echo(note.line("note"), err=True)
