r"""Tables for LaTeX: a tabular for \input, which needs no package. Characters that LaTeX takes for commands are
escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isnan
from pathlib import Path

from mbproj.control_characters import escaped
from mbproj.output_files import kinds
from mbproj.output_files.replace import ELSEWHERE, replacing

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
        written = [[_cell(value, form) for value in row] for row in rows]
        numeric = [all(cell.startswith("$") or not cell for cell in column) for column in zip(*written, strict=True)]
        columns = "".join("r" if each else "l" for each in numeric) or "l" * len(headings)
        file.write(f"{kinds.LATEX_MARK}\n\\begin{{tabular}}{{{columns}}}\n\\hline\n")
        file.write(" & ".join(_text(heading) for heading in headings) + " \\\\\n\\hline\n")
        file.writelines(" & ".join(row) + " \\\\\n" for row in written)
        file.write("\\hline\n\\end{tabular}\n")
    return path


def _cell(value: object, form: str) -> str:
    """Return a float as mathematics, NaN as an empty cell, and anything else as escaped text."""
    if isinstance(value, float):
        if isnan(value):
            return ""
        digits, _, power = format(value, form).partition("e")
        return f"${digits} \\cdot 10^{{{int(power)}}}$" if power else f"${digits}$".replace("inf", "\\infty")
    return _text(str(value))


def _text(text: str) -> str:
    return "".join(COMMANDS.get(character, character) for character in escaped(text))
