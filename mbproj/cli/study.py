"""What the commands that run many simulations share: progress with the time left, tables, files."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any

from mbproj.errors import InputError, Problem
from mbproj.studies.progress import Tell


@contextmanager
def telling(hidden: bool) -> Iterator[Tell]:
    """Shows how far a study is and how long it will take, on a terminal only: one line on stderr."""
    begun: dict[str, float] = {}
    shown = not hidden and sys.stderr.isatty()

    def tell(phase: str, done: int, whole: int) -> None:
        started = begun.setdefault(phase, monotonic())
        left = (monotonic() - started) / done * (whole - done) if done else None
        text = f"{phase}: {done} of {whole}" + ("" if left is None else f", {_duration(left)} left")
        if shown:
            sys.stderr.write(f"\r{text}\x1b[K")
            sys.stderr.flush()

    try:
        yield tell
    finally:
        if shown and begun:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


def columns(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in plain text: the first column and settings to the left, the others to the right."""
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
    """A number of a table; a dash where there is none."""
    return "-" if value != value else format(value, form)


def milliseconds(seconds: float) -> str:
    """Three digits of a time in ms; a dash where there is none."""
    value = 1e3 * seconds
    return "-" if not seconds < float("inf") else f"{value:.3g}" if value < 1000.0 else f"{value:.0f}"


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> Path:
    """The rows with the names of the first as headings. Raises InputError where the file cannot be written."""
    try:
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    except OSError as error:
        raise unwritable(path, error) from error
    return path


def unwritable(path: Path, error: OSError) -> InputError:
    """A file or folder that cannot be made."""
    message = f"cannot write '{path}': {error.strerror or error}"
    return InputError(Problem(message, hint="choose another folder with -o"))


def journal_at(stem: Path, fresh: bool) -> Path:
    """The journal of a study whose files begin with `stem`; without what is in it where it is to begin anew."""
    journal = Path(f"{stem}.jsonl")
    if fresh:
        journal.unlink(missing_ok=True)
    return journal


def make(folder: Path) -> Path:
    """The folder, made where it was missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from error
    return folder
