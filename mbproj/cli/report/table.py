"""Names and values, one below the other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping


def table(values: Mapping[str, str], indent: str = "") -> Iterator[str]:
    """A line for each name, the values in one column."""
    width = max(map(len, values), default=0)
    for key, value in values.items():
        yield f"{indent}{key:<{width}}  {value}"
