"""Many primitives bound to bodies, as arrays: the joints' constraint rows, or the joints' coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers, Numbers
from mbproj.constraints import Primitive
from mbproj.dataclass import dataclass


@dataclass(frozen=True, eq=False)
class Binding:
    """One primitive on its way into a set: what it binds, as (body index, side 1 or 2, local vector) per slot; its
    value counts from `offset`."""

    primitive: Primitive
    owner: int
    slots: tuple[tuple[int, int, Array], ...]
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Group:
    """All instances of one primitive: `slots` (k, s) into the set's attachments, `rows` (k, rows) into its rows."""

    primitive: Primitive
    slots: Integers
    rows: Integers


@dataclass(frozen=True, eq=False)
class PrimitiveSet:
    """Primitives of one purpose, S attachments (points and vectors fixed in bodies) and m rows.

    Per attachment: `body` (S,) (the ground is the last index), `side` (S,) 1 or 2, `local` (S, 3) in body axes,
    `is_point` (S,) 1 for points and 0 for vectors. Per row: `owner` (m,) the joint's index, `is_length` (m,) True for
    metres and False for radians, `offset` (m,) what is subtracted from the primitives' values. `entry_row`,
    `entry_slot` (e,) list the pairs of a row and an attachment in the order of `gradient_entries`.
    """

    groups: tuple[Group, ...]
    body: Integers
    side: Integers
    local: Array
    is_point: Array
    owner: Integers
    is_length: npt.NDArray[np.bool_]
    offset: Array
    entry_row: Integers
    entry_slot: Integers

    @property
    def size(self) -> int:
        """m, the number of rows."""
        return len(self.owner)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each row, m or rad."""
        return tuple("m" if is_length else "rad" for is_length in self.is_length)

    def value(self, x: Numbers) -> Numbers:
        """C (..., m) of the attachments' global points and vectors x (..., S, 3)."""
        value = np.empty((*x.shape[:-2], self.size), dtype=x.dtype)
        for group in self.groups:
            value[..., group.rows] = group.primitive.value(x[..., group.slots, :])
        return value - self.offset

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """x'ᵀ C_xx x' of shape (..., m)."""
        value = np.empty((*x.shape[:-2], self.size), dtype=x.dtype)
        for group in self.groups:
            slots = group.slots
            value[..., group.rows] = group.primitive.curvature(x[..., slots, :], x_dot[..., slots, :])
        return value

    def gradient_entries(self, x: Numbers) -> Numbers:
        """∂C/∂x, its entries that can differ from zero, (..., e, 3): row `entry_row`, attachment `entry_slot`."""
        lead = x.shape[:-2]
        parts = [group.primitive.gradient(x[..., group.slots, :]).reshape(*lead, -1, 3) for group in self.groups]
        return np.concatenate(parts, axis=-2) if parts else np.zeros((*lead, 0, 3))

    def along(self, gradient: Numbers, direction: Numbers) -> Numbers:
        """∂C/∂x · direction, (..., m), from `gradient_entries` and one vector per attachment, (..., S, 3)."""
        products = np.sum(gradient * direction[..., self.entry_slot, :], axis=-1)
        total = np.zeros((*products.shape[:-1], self.size), dtype=products.dtype)
        for group in self.groups:
            count = group.rows.size * group.slots.shape[1]
            terms, products = products[..., :count], products[..., count:]
            total[..., group.rows] = terms.reshape(*terms.shape[:-1], *group.rows.shape, -1).sum(axis=-1)
        return total


def bind(bindings: Sequence[Binding]) -> PrimitiveSet:
    """The set of these primitives; rows in the order of the bindings."""
    height = [binding.primitive.rows for binding in bindings]
    first_row, first_slot = np.cumsum([0, *height]), np.cumsum([0] + [len(binding.slots) for binding in bindings])
    attachments = [slot for binding in bindings for slot in binding.slots]
    groups, is_point, is_length = [], np.zeros(len(attachments)), np.zeros(first_row[-1], dtype=bool)
    for primitive in dict.fromkeys(binding.primitive for binding in bindings):
        members = [index for index, binding in enumerate(bindings) if binding.primitive == primitive]
        slots = first_slot[members][:, None] + np.arange(len(primitive.slots))
        rows = first_row[members][:, None] + np.arange(primitive.rows)
        is_point[slots] = [float(kind == "point") for kind in primitive.slots]
        is_length[rows] = primitive.unit == "m"
        groups.append(Group(primitive, slots, rows))
    entry_row, entry_slot = _entries(groups)
    return PrimitiveSet(
        tuple(groups),
        body=np.array([slot[0] for slot in attachments], dtype=np.intp),
        side=np.array([slot[1] for slot in attachments], dtype=np.intp),
        local=np.array([slot[2] for slot in attachments], dtype=float).reshape(-1, 3),
        is_point=is_point,
        owner=np.repeat(np.array([binding.owner for binding in bindings], dtype=np.intp), height),
        is_length=is_length,
        offset=np.repeat(np.array([binding.offset for binding in bindings], dtype=float), height),
        entry_row=entry_row,
        entry_slot=entry_slot,
    )


def bindings(bound: PrimitiveSet, rows: Sequence[int] | None = None) -> list[Binding]:
    """A set's primitives again as they were bound, in the order of their rows; of all, or of those with these first
    rows."""
    found = dict(_bindings(bound))
    return [found[row] for row in (sorted(found) if rows is None else rows)]


def _bindings(bound: PrimitiveSet) -> Iterator[tuple[int, Binding]]:
    for group in bound.groups:
        for slots, rows in zip(group.slots, group.rows, strict=True):
            taken = tuple((int(bound.body[s]), int(bound.side[s]), bound.local[s]) for s in slots)
            first = int(rows[0])
            yield first, Binding(group.primitive, int(bound.owner[first]), taken, float(bound.offset[first]))


def _entries(groups: Sequence[Group]) -> tuple[Integers, Integers]:
    rows, slots = [np.zeros(0, dtype=np.intp)], [np.zeros(0, dtype=np.intp)]
    for group in groups:
        shape = (*group.rows.shape, group.slots.shape[1])
        rows.append(np.broadcast_to(group.rows[:, :, None], shape).ravel())
        slots.append(np.broadcast_to(group.slots[:, None, :], shape).ravel())
    return np.concatenate(rows), np.concatenate(slots)
