"""Couplings as arrays: rows that are known but for whole teeth or threads, and the coordinates that tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.constraints.coupling import Coupling
from mbproj.dataclass import dataclass
from mbproj.model.primitive_set import Binding


@dataclass(frozen=True, eq=False)
class Couplings:
    """k rows of the joints, each a sum of coordinates less a multiple of a period.

    `row` (k,) of the joints' rows; `period` (k,) one tooth in rad, or one thread in m. `first` (k,): where the entries
    of each begin, which are `coordinate` (e,), numbers of the system's coordinates, and `weight` (e,).
    """

    row: Integers
    period: Array
    first: Integers
    coordinate: Integers
    weight: Array

    @property
    def size(self) -> int:
        """k."""
        return len(self.row)

    def sums(self, coordinate: Numbers) -> Numbers:
        """Of the system's coordinates (..., nc), (..., k)."""
        return np.asarray(np.add.reduceat(self.weight * coordinate[..., self.coordinate], self.first, axis=-1))


def compile_couplings(rows: Sequence[Binding], coordinates: Sequence[Binding]) -> Couplings:
    """Those among the joints' rows, which share their slots with the coordinates that they couple."""
    first = np.cumsum([0, *(binding.primitive.rows for binding in rows)])
    row, period, length, coordinate = [], [], [], []
    weight: list[float] = []
    for at, binding in zip(first.tolist(), rows, strict=False):
        if not isinstance(binding.primitive, Coupling):
            continue
        row.append(at)
        period.append(binding.primitive.period)
        length.append(len(binding.primitive.weights))
        weight += binding.primitive.weights
        coordinate += [_coordinate(binding.slots[slots], coordinates) for *_, slots in binding.primitive.parts()]
    return Couplings(
        row=np.array(row, dtype=np.intp),
        period=np.array(period, dtype=float),
        first=np.cumsum([0, *length], dtype=np.intp)[:-1],
        coordinate=np.array(coordinate, dtype=np.intp),
        weight=np.array(weight),
    )


def _coordinate(slots: Sequence[tuple[int, int, Array]], coordinates: Sequence[Binding]) -> int:
    """The number of the joint coordinate on these points and vectors."""
    for number, binding in enumerate(coordinates):
        pairs = list(zip(slots, binding.slots, strict=False))
        if len(slots) == len(binding.slots) and all(
            one[0] == other[0] and np.array_equal(one[2], other[2]) for one, other in pairs
        ):
            return number
    raise AssertionError("a row couples what is no joint coordinate")
