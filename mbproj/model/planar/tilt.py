"""Splits rows that are neither inside nor outside on their own, but in combination.

A prismatic joint's vectors x and y are normal to its axis, at any angle to the plane's normal n. So none of its rows
need be inside or outside. Rows of a joint that differ only in their vector (`along`), or have the same two bodies
(`perpendicular`), form a block. A block locks shifts along, or turns about, the directions that its rows span.

Where n is one of these directions, the block splits. As many rows as there is motion in the plane for them to lock are
inside. The others, less multiples of these, are outside.

For `along` that holds in every pose. For `perpendicular` it holds where the joint is closed: the row inside keeps the
bodies from turning about n, and without such a turn the others have no gradient in the plane. In a joint that is open
by an angle δ they have a gradient of the order of δ, which is dropped. Where n is not among the directions, the joint
is tilted and the scene is not planar.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers, cross
from mbproj.dataclass import dataclass
from mbproj.lanes import numbers
from mbproj.model.planar.rows import INSIDE, OUTSIDE, STRANGE, TILTED, RowMap, Seen, kind_of, strangeness
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.thresholds import THRESHOLDS

_NORMAL = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Refusal:
    """The reason why rows do not split: the joint's index, and the cause in words that follow the joint's name."""

    joint: int
    cause: str


@dataclass(frozen=True, eq=False)
class PlaneSplit:
    """`inside` (m,) marks the rows that act in the plane; `outside` makes the rows that hold the bodies in it. Rows of
    coincident points are along e1, e2 and n here."""

    inside: npt.NDArray[np.bool_]
    outside: RowMap


@dataclass(frozen=True, eq=False)
class _Block:
    """Rows (k,) of one joint and the directions (k, 3) that they lock, in plane axes. `in_plane` selects the components
    of a direction that are motion in the plane: e1 and e2 of a shift, n of a turn."""

    joint: int
    rows: Integers
    directions: Array
    in_plane: slice


def split(bound: PrimitiveSet, seen: Seen, side: Integers) -> PlaneSplit | Refusal:
    """Return the rows inside and outside, from the side of each on its own; or the first joint that does not split."""
    strange = np.flatnonzero(side == STRANGE)
    if len(strange):
        return Refusal(int(bound.owner[strange[0]]), strangeness(bound, int(strange[0])))
    inside = side == INSIDE
    combinations = [([row], [1.0]) for row in np.flatnonzero(side == OUTSIDE).tolist()]
    for block in _tilted_blocks(bound, seen, side):
        if not _spans_normal(block.directions):
            return Refusal(block.joint, "is tilted")
        pivots, coefficients = _eliminated(block.directions[:, block.in_plane])
        inside[block.rows] = False
        inside[block.rows[pivots]] = True
        for place, row in enumerate(block.rows.tolist()):
            if place not in pivots and side[row] != OUTSIDE:
                combinations.append(([row, *block.rows[pivots].tolist()], [1.0, *(-coefficients[place]).tolist()]))
    return PlaneSplit(inside, _row_map(combinations))


def _row_map(combinations: list[tuple[list[int], list[float]]]) -> RowMap:
    row = np.repeat(np.arange(len(combinations)), [len(sources) for sources, _ in combinations])
    source = np.array([source for sources, _ in combinations for source in sources], dtype=np.intp)
    return RowMap(len(combinations), row, source, np.array([w for _, weights in combinations for w in weights]))


def _tilted_blocks(bound: PrimitiveSet, seen: Seen, side: Integers) -> Iterator[_Block]:
    """The blocks that have a tilted row, joint by joint."""
    group_of, place = np.empty((2, bound.size), dtype=np.intp)
    for index, group in enumerate(bound.groups):
        group_of[group.rows] = index
        place[group.rows] = np.arange(len(group.rows))[:, None]
    for joint in sorted(set(bound.owner[side == TILTED].tolist())):
        members: dict[tuple[str, bytes], list[tuple[int, Array]]] = {}
        for row in range(*np.searchsorted(bound.owner, [joint, joint + 1])):  # a joint's rows are consecutive
            group = bound.groups[group_of[row]]
            kind, slots = kind_of(group.primitive), group.slots[place[row]]
            if kind in ("along", "perpendicular"):
                shared, direction = (_shift if kind == "along" else _turn)(bound, seen, slots)
                members.setdefault((kind, shared), []).append((row, direction))
        for (kind, _), block in members.items():
            rows = np.array([row for row, _ in block], dtype=np.intp)
            if np.any(side[rows] == TILTED):
                in_plane = slice(0, 2) if kind == "along" else slice(2, 3)
                yield _Block(joint, rows, numbers([direction for _, direction in block]), in_plane)


def _shift(bound: PrimitiveSet, seen: Seen, slots: Integers) -> tuple[bytes, Array]:
    """Return the key by which an `along` row belongs to a block, and the direction of the shift that it locks: its
    vector."""
    return bound.body[slots].tobytes() + bound.local[slots[1:]].tobytes(), seen.x[slots[0]]


def _turn(bound: PrimitiveSet, seen: Seen, slots: Integers) -> tuple[bytes, Array]:
    """Return the key by which a `perpendicular` row belongs to a block, and the axis of the turn that it locks. For a
    turn φ of b's body relative to a's, a·(φ × b) = φ·(b × a)."""
    a, b = seen.x[slots]
    return bound.body[slots].tobytes(), cross(b, a)


def _spans_normal(directions: Array) -> bool:
    """Whether n is a combination of the directions (k, 3)."""
    _, values, basis = np.linalg.svd(directions, full_matrices=False)
    basis = basis[values > THRESHOLDS.rounding]
    return bool(np.linalg.norm(_NORMAL - (basis @ _NORMAL) @ basis) <= THRESHOLDS.rounding)


def _eliminated(parts: Array) -> tuple[list[int], Array]:
    """Return rows of `parts` (k, d) that span all, the largest first, and the coefficients (k, p) of all rows in
    these."""
    pivots: list[int] = []
    coefficients, rest = np.zeros((len(parts), 0)), parts
    while np.abs(rest).max() > THRESHOLDS.rounding:
        pivots.append(int(np.argmax(np.linalg.norm(rest, axis=1))))
        coefficients = parts @ np.linalg.pinv(parts[pivots])
        rest = parts - coefficients @ parts[pivots]
    return pivots, coefficients
