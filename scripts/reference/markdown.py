"""Markdown: code and tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def code(value: object) -> str:
    """As code; a bar would end a cell."""
    return f"`{value}`".replace("|", "\\|")


def codes(values: Iterable[object]) -> str:
    return ", ".join(code(value) for value in values)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; bars in cells are escaped where they are not yet."""
    cells = ([cell.replace("|", "\\|").replace("\\\\|", "\\|") for cell in row] for row in rows)
    lines = [head, ["---"] * len(head), *cells]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
