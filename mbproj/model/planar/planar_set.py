"""Primitives bound to bodies in a plane: the PrimitiveSet of 2-vectors."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.constraints import Primitive
from mbproj.dataclass import dataclass
from mbproj.model.planar.rows import RowMap, Seen, kind_of
from mbproj.model.primitive_set import LAYOUTS, Member, PrimitiveSet, SetLayout


@dataclass(frozen=True, eq=False)
class PlanarSet:
    """k primitives on S attachments, with m rows: those of a spatial set that act in the plane.

    Per primitive: `primitives` (k,); `first_slot` (k,), its first attachment, which the others follow; `row` (k,), its
    first row; `owner` (k,), the joint. A coincident primitive has two rows, along e1 and e2, the others one.

    Per attachment: `body` (S,), where the ground is the last index; `local` (S, 2) in the body's planar axes, which are
    e1 and e2 at angle zero; `is_point` (S,), 1 for points and 0 for vectors. Per row: `offset` (m,). `source` makes the
    rows from the spatial set's, and the spatial set's multipliers from the rows' multipliers.

    A vector may point out of the plane, as in a prismatic joint. Then `local` is its part in the plane, and `offset`
    contains the constant from its part along n.
    """

    primitives: tuple[Primitive, ...]
    first_slot: Integers
    row: Integers
    owner: Integers
    body: Integers
    local: Array
    is_point: Array
    offset: Array
    source: RowMap

    @property
    def size(self) -> int:
        """m, the number of rows."""
        return self.source.size

    @property
    def kinds(self) -> tuple[str, ...]:
        """The primitives' names in PRIMITIVES, (k,)."""
        return tuple(kind_of(primitive) for primitive in self.primitives)


def planar_set(bound: PrimitiveSet, seen: Seen, inside: npt.NDArray[np.bool_], axes: Array) -> PlanarSet:
    """Return the primitives of `bound` whose rows are `inside` (m,); coincident ones along e1, e2 and n of `axes` (3,
    3)."""
    kept = _planar_layout(bound.layout, inside.tobytes(), axes.tobytes())
    slots, source = kept.slots, kept.source
    whole, flat = bound.value(np.stack([seen.x, seen.x * [1.0, 1.0, 0.0]]))
    for each in bound.layout.members:
        if kind_of(each.primitive) == "wheel_height":  # its planar form assumes that the axis is normal to the plane
            flat[list(each.rows)] = whole[list(each.rows)]
    return PlanarSet(
        primitives=kept.primitives,
        first_slot=kept.first_slot,
        row=kept.row,
        owner=kept.owner,
        body=bound.body[slots],
        local=seen.arm[slots, :2],
        is_point=bound.is_point[slots],
        offset=source.rows(bound.offset) - (whole - flat)[kept.rows],
        source=source,
    )


@dataclass(frozen=True, eq=False)
class _PlanarLayout:
    """The parts of a `PlanarSet` that do not depend on its numbers, with the attachments (S,) and rows (m,) of the
    spatial set."""

    primitives: tuple[Primitive, ...]
    first_slot: Integers
    row: Integers
    owner: Integers
    slots: Integers
    rows: Integers
    source: RowMap


@lru_cache(LAYOUTS)
def _planar_layout(layout: SetLayout, inside: bytes, axes: bytes) -> _PlanarLayout:
    """Return the layout of a planar set from the cache. Sets share it, so that nobody may write to it."""
    acts = np.frombuffer(inside, dtype=bool).tolist()
    members = [(each, rows) for each in layout.members if (rows := [row for row in each.rows if acts[row]])]
    kept = _PlanarLayout(
        primitives=tuple(each.primitive for each, _ in members),
        first_slot=_starts([len(each.slots) for each, _ in members]),
        row=_starts([len(rows) for _, rows in members]),
        owner=layout.owner[[each.rows[0] for each, _ in members]],
        slots=np.array([slot for each, _ in members for slot in each.slots], dtype=np.intp),
        rows=np.array([row for _, rows in members for row in rows], dtype=np.intp),
        source=_source(members, np.frombuffer(axes).reshape(3, 3)),
    )
    for part in (*vars(kept).values(), *vars(kept.source).values()):
        if isinstance(part, np.ndarray):
            part.flags.writeable = False
    return kept


def _source(members: list[tuple[Member, list[int]]], axes: Array) -> RowMap:
    """Return the map to the planar rows: one spatial row each, but all three rows of coincident points."""
    along: list[list[float]] = axes.T.tolist()
    row: list[int] = []
    source: list[int] = []
    weight: list[float] = []
    size = 0
    for each, kept in members:
        for spatial in kept:
            all_three = len(each.rows) == 3
            parts = zip(each.rows, along[spatial - each.rows[0]], strict=True) if all_three else [(spatial, 1.0)]
            used = [(own, part) for own, part in parts if part]
            row += [size] * len(used)
            source += [own for own, _ in used]
            weight += [part for _, part in used]
            size += 1
    return RowMap(size, np.array(row, dtype=np.intp), np.array(source, dtype=np.intp), np.array(weight))


def _starts(lengths: list[int]) -> Integers:
    return np.cumsum([0, *lengths], dtype=np.intp)[:-1]
