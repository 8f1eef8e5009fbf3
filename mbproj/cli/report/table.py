"""Tables in plain text: names and values, rows and columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence


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
