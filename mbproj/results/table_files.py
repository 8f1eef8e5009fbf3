"""Writes a table for a paper, in the format that the ending of the file's name gives: CSV, LaTeX or Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from csv import writer as csv_writer
from math import isnan
from pathlib import Path
from typing import Any

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.base.text import escaped
from mbproj.results import output_files as kinds
from mbproj.results.output_files import (
    ELSEWHERE,
    MARKDOWN_MARK,
    FileKind,
    check_replaceable,
    csv,
    latex,
    markdown,
    replacing,
)

# --- CSV tables, whose texts are safe in a spreadsheet ----------------------------------------------------------------
# None is taken for a formula, none has control characters.


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
        writer.writerow([_csv_cell(heading, form) for heading in headings])
        numbers = ",".join([f"%{form}"] * len(headings)) + "\n"
        for row in rows:
            if form and all(type(value) is float for value in row):  # takes a third of the time; tables can be long
                file.write(numbers % tuple(row))
            else:
                writer.writerow([_csv_cell(value, form) for value in row])
    return path


def _csv_cell(value: object, form: str) -> object:
    if isinstance(value, float):
        return format(value, form)
    if not isinstance(value, str):
        return value
    text = escaped(value)
    return f"'{text}" if text.startswith(FORMULA) else text


# --- Tables for LaTeX -------------------------------------------------------------------------------------------------
# A tabular for \input, which needs no package. Characters that LaTeX takes for commands are escaped.


GREEK = "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi o pi rho varsigma sigma tau "
GREEK += "upsilon phi chi psi omega"
#: The LaTeX code of characters that LaTeX takes for commands, or that its text fonts do not have.
COMMANDS = {
    **{chr(ord("α") + k): f"$\\{name}$" for k, name in enumerate(GREEK.split())},
    "Δ": r"$\Delta$",
    "Λ": r"$\Lambda$",
    "Ω": r"$\Omega$",
    "Σ": r"$\Sigma$",
    "Φ": r"$\Phi$",
    "≤": r"$\le$",
    "≥": r"$\ge$",
    "∞": r"$\infty$",
    "ᵀ": "$^T$",
    "−": "$-$",
    "→": r"$\to$",
    "∫": r"$\int$",
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{character: f"\\{character}" for character in "&%$#_{}"},
}


def write_latex(
    path: Path,
    headings: Sequence[str],
    rows: Iterable[Sequence[object]],
    *,
    form: str = ".6g",
    force: bool = False,
    hint: str = ELSEWHERE,
) -> Path:
    """Write the table and return `path`; floats in the format `form`, as mathematics, columns of text to the left."""
    with (
        replacing(path, kinds.latex(), force=force, hint=hint) as draft,
        draft.open("w", encoding="utf-8", newline="") as file,
    ):
        written = [[_latex_cell(value, form) for value in row] for row in rows]
        numeric = [all(cell.startswith("$") or not cell for cell in column) for column in zip(*written, strict=True)]
        columns = "".join("r" if each else "l" for each in numeric) or "l" * len(headings)
        file.write(f"{kinds.LATEX_MARK}\n\\begin{{tabular}}{{{columns}}}\n\\hline\n")
        file.write(" & ".join(_text(heading) for heading in headings) + " \\\\\n\\hline\n")
        file.writelines(" & ".join(row) + " \\\\\n" for row in written)
        file.write("\\hline\n\\end{tabular}\n")
    return path


def _latex_cell(value: object, form: str) -> str:
    """Return a float as mathematics, NaN as an empty cell, and anything else as escaped text."""
    if isinstance(value, float):
        if isnan(value):
            return ""
        digits, _, power = format(value, form).partition("e")
        return f"${digits} \\cdot 10^{{{int(power)}}}$" if power else f"${digits}$".replace("inf", "\\infty")
    return _text(str(value))


def _text(text: str) -> str:
    return "".join(COMMANDS.get(character, character) for character in escaped(text))


# --- Writes a table for a paper, in the format that the ending of the file's name gives -------------------------------


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
