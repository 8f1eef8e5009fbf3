"""Writes a table for a paper, in the format that the ending of the file's name gives: CSV, LaTeX or Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from mbproj.control_characters import escaped
from mbproj.errors import InputError, Place, Problem, placed_at
from mbproj.output_files.csv_table import write_csv
from mbproj.output_files.kinds import MARKDOWN_MARK, FileKind, csv, latex, markdown
from mbproj.output_files.latex_table import write_latex
from mbproj.output_files.replace import check_replaceable, replacing

OPTION = Place("--write-table")


def check_table(path: Path | None, first: Sequence[str], *, force: bool = False) -> None:
    """Check that a table whose first columns have the headings `first` can be written to `path`; None asks for none.

    Raises InputError at --write-table where the name has another ending, or `path` holds something else."""
    if path is not None:
        with placed_at(OPTION):
            check_replaceable(path, _kind(path, first), force=force, hint=f"choose another with {OPTION}")


def write_table(path: Path, headings: Sequence[str], rows: Iterable[Sequence[Any]], *, force: bool = False) -> Path:
    """Write the table and return `path`: all digits in CSV, six in LaTeX and Markdown; None is an empty cell. Raises
    InputError as `check_table` does."""
    check_table(path, headings, force=force)
    filled = [["" if value is None else value for value in row] for row in rows]
    return _WRITERS[path.suffix.lower()](path, headings, filled, force=force)


def _kind(path: Path, first: Sequence[str]) -> FileKind:
    kinds: Mapping[str, Callable[[], FileKind]] = {".csv": lambda: csv(first), ".tex": latex, ".md": markdown}
    if path.suffix.lower() not in kinds:
        hint = f"end it in {', '.join(kinds)}"
        raise InputError(Problem(f"'{path}' is not the name of a table", OPTION, hint))
    return kinds[path.suffix.lower()]()


def _write_markdown(path: Path, headings: Sequence[str], rows: Sequence[Sequence[Any]], *, force: bool) -> Path:
    lines = [MARKDOWN_MARK, "", _line(headings), _line(["---"] * len(headings)), *map(_line, rows)]
    with replacing(path, markdown(), force=force) as draft:
        draft.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _line(cells: Sequence[Any]) -> str:
    shown = (f"{cell:.6g}" if isinstance(cell, float) else escaped(str(cell)) for cell in cells)
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in shown)} |"


_WRITERS: Mapping[str, Callable[..., Path]] = {".csv": write_csv, ".tex": write_latex, ".md": _write_markdown}
