"""Gears and screws as arrays: the rows that are known but for whole teeth or threads, and the coordinates that tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.constraints.mesh import Mesh
from mbproj.dataclass import dataclass
from mbproj.model.primitive_set import Binding


@dataclass(frozen=True, eq=False)
class Meshes:
    """k rows of the joints, each a sum of two joint coordinates less a multiple of a period.

    `row` (k,) of the joints' rows; `coordinate` (k, 2) which of the system's coordinates; `weight` (k, 2) of each;
    `period` (k,) one tooth in rad, or one thread in m.
    """

    row: Integers
    coordinate: Integers
    weight: Array
    period: Array

    @property
    def size(self) -> int:
        """k, the number of gears and screws."""
        return len(self.row)


def compile_meshes(rows: Sequence[Binding], coordinates: Sequence[Binding]) -> Meshes:
    """Those of the joints' rows, which share their slots with the coordinates that they couple."""
    first = np.cumsum([0, *(binding.primitive.rows for binding in rows)])
    found = [
        (int(row), binding.primitive, [_coordinate(binding.slots[part], coordinates) for part in (_FIRST, _SECOND)])
        for row, binding in zip(first, rows, strict=False)
        if isinstance(binding.primitive, Mesh)
    ]
    return Meshes(
        row=np.array([row for row, *_ in found], dtype=np.intp),
        coordinate=np.array([pair for *_, pair in found], dtype=np.intp).reshape(-1, 2),
        weight=np.array([mesh.weights for _, mesh, _ in found]).reshape(-1, 2),
        period=np.array([mesh.period for _, mesh, _ in found], dtype=float),
    )


_FIRST, _SECOND = slice(0, 3), slice(3, 6)


def _coordinate(slots: Sequence[tuple[int, int, Array]], coordinates: Sequence[Binding]) -> int:
    """The number of the joint coordinate on these points and vectors."""
    for number, binding in enumerate(coordinates):
        pairs = zip(slots, binding.slots, strict=True)
        if all(one[0] == other[0] and np.array_equal(one[2], other[2]) for one, other in pairs):
            return number
    raise AssertionError("a gear or screw couples what is no joint coordinate")
