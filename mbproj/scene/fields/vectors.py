"""Fields of three numbers: points, directions, the rows of a matrix."""

from __future__ import annotations

from typing import Any

from mbproj.scene.fields.checks import direction
from mbproj.scene.fields.fields import Converted, Field, List
from mbproj.scene.fields.quantities import Number


def vector(unit: str | None) -> List[float]:
    """Three numbers in `unit` (see `Number`)."""
    return List(Number(unit), 3)


POINT: Field[Any] = vector("m")
DIRECTION: Field[Any] = Converted(vector(None), direction)


def rows(unit: str) -> List[tuple[float, ...]]:
    """The rows of a 3 x 3 matrix."""
    return List(vector(unit), 3, "rows of 3 numbers")
