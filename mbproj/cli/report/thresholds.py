"""`info --thresholds`: every chosen number, as a table and for JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from mbproj.report_schema import report_of
from mbproj.report_schema.results import THRESHOLD_ROWS
from mbproj.thresholds import table

#: The users of a threshold, in words.
USERS = {"both": "NumPy and kernel", "kernel": "kernel", "numpy": "NumPy"}


def facts() -> dict[str, Any]:
    """Each threshold by its name."""
    return {row.name: report_of(THRESHOLD_ROWS, row) for row in table()}


def lines() -> Iterator[str]:
    """Yield a line of numbers for each threshold, and below it its effect and its source."""
    rows = table()
    name, value = max(len(row.name) for row in rows), max(len(f"{row.value:g}") for row in rows)
    for row in rows:
        yield f"{row.name:<{name}}  {row.value:>{value}g} {row.unit} ({USERS[row.used_by]})"
        yield f"  {row.why} [{row.source}]"
