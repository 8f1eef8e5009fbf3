"""Coordinates that coincide all the time: drawn once, they leave room for the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.results import Results

#: Part of its largest value by which a coordinate may differ from another, and how much in m or rad it may at least:
#: to that joints are closed.
SAME, CLOSED = 1e-9, 1e-13


def coinciding(results: Sequence[Results], names: Sequence[str]) -> dict[str, list[str]]:
    """Of coordinates in any of the results, the first of each that coincide, and the others by it."""
    found: dict[str, list[str]] = {}
    for name in names:
        own = [_of(result, name) for result in results]
        first = next((kept for kept in found if _agree(own, [_of(result, kept) for result in results])), None)
        found.setdefault(name, []) if first is None else found[first].append(name)
    return found


def alike(first: Array, second: Array) -> bool:
    """Whether two series have the same values, up to round-off."""
    with np.errstate(invalid="ignore"):
        return bool(np.all(np.abs(first - second) <= SAME * np.max(np.abs(first), initial=0.0) + CLOSED))


def _of(result: Results, name: str) -> tuple[str, Array, Array] | None:
    if name not in result.names("coordinates"):
        return None
    own = result.coordinate(name)
    return own.unit, own.value, own.speed


def _agree(one: Sequence[tuple[str, Array, Array] | None], other: Sequence[tuple[str, Array, Array] | None]) -> bool:
    for first, second in zip(one, other, strict=True):
        if first is None or second is None:
            if first is not second:
                return False
        elif first[0] != second[0] or not alike(first[1], second[1]) or not alike(first[2], second[2]):
            return False
    return True
