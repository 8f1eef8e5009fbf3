"""Many primitives bound to bodies, as arrays: the joints' constraint rows, or the joints' coordinates."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers, Numbers, like_of, numbers
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Primitive

#: The number of layouts in the cache, enough for a few scenes, and the most primitives of a set that is cached.
LAYOUTS, MOST_KEPT = 64, 1000


@dataclass(frozen=True, eq=False)
class Binding:
    """One primitive to be bound in a set: its slots as (body index, side 1 or 2, local vector). `offset` is subtracted
    from its value."""

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


class Member(NamedTuple):
    """One instance of a primitive: its rows and its attachments in the set."""

    primitive: Primitive
    rows: tuple[int, ...]
    slots: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class SetLayout:
    """The structure of a set, without its numbers: scenes that differ in numbers alone share it.

    Per attachment: `body` (S,), where the ground is the last index; `side` (S,), 1 or 2; `is_point` (S,), 1 for points
    and 0 for vectors. Per row: `owner` (m,), the joint's index; `is_length` (m,), True for metres and False for
    radians; `is_velocity` (m,), whether the row is at velocity level, of a primitive that is not integrable.

    `members` are the primitives in the order of their rows; `member` (m,) is the number of the primitive of each row.
    `entry_row`, `entry_slot` (e,) list the pairs of a row and an attachment in the order of `gradient_entries`.
    """

    groups: tuple[Group, ...]
    body: Integers
    side: Integers
    is_point: Array
    owner: Integers
    is_length: npt.NDArray[np.bool_]
    is_velocity: npt.NDArray[np.bool_]
    members: tuple[Member, ...]
    member: Integers
    entry_row: Integers
    entry_slot: Integers

    @cached_property
    def on_second_bodies(self) -> tuple[Integers, Integers]:
        """The attachments on side 2, joint by joint, and the joint of each."""
        joint = np.empty_like(self.body)
        joint[self.entry_slot] = self.owner[self.entry_row]
        slots = np.flatnonzero(self.side == 2)
        slots = slots[np.argsort(joint[slots], kind="stable")]
        return slots, joint[slots]

    @cached_property
    def entry_body(self) -> Integers:
        """The body of each entry, (e,)."""
        return self.body[self.entry_slot]

    @cached_property
    def entry_is_point(self) -> Array:
        """1 for each entry at a point, 0 at a vector, (e, 1)."""
        return self.is_point[self.entry_slot, None]

    @cached_property
    def units(self) -> tuple[str, ...]:
        """The unit of each row, m or rad."""
        return tuple("m" if is_length else "rad" for is_length in self.is_length.tolist())


@dataclass(frozen=True, eq=False)
class PrimitiveSet:
    """Primitives of one purpose, S attachments (points and vectors fixed in bodies) and m rows: a layout and numbers.

    Per attachment `local` (S, 3) in body axes; per row `offset` (m,), which is subtracted from the primitives' values.
    """

    layout: SetLayout
    local: Array
    offset: Array

    @property
    def groups(self) -> tuple[Group, ...]:
        """The instances of primitives, grouped by primitive."""
        return self.layout.groups

    @property
    def body(self) -> Integers:
        """The body of each attachment, (S,)."""
        return self.layout.body

    @property
    def side(self) -> Integers:
        """The side of each attachment, (S,)."""
        return self.layout.side

    @property
    def is_point(self) -> Array:
        """1 for points and 0 for vectors, (S,)."""
        return self.layout.is_point

    @property
    def owner(self) -> Integers:
        """The joint of each row, (m,)."""
        return self.layout.owner

    @property
    def is_length(self) -> npt.NDArray[np.bool_]:
        """Whether each row is in metres, (m,)."""
        return self.layout.is_length

    @property
    def is_velocity(self) -> npt.NDArray[np.bool_]:
        """Whether each row is at velocity level, (m,)."""
        return self.layout.is_velocity

    @property
    def entry_row(self) -> Integers:
        """The row of each entry, (e,)."""
        return self.layout.entry_row

    @property
    def entry_slot(self) -> Integers:
        """The attachment of each entry, (e,)."""
        return self.layout.entry_slot

    @property
    def size(self) -> int:
        """m, the number of rows."""
        return len(self.layout.owner)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each row, m or rad."""
        return self.layout.units

    def value(self, x: Numbers) -> Numbers:
        """Return C (..., m) for the attachments' global points and vectors x (..., S, 3)."""
        value = np.empty((*x.shape[:-2], self.size), dtype=x.dtype, order="F", like=x)
        for group in self.groups:
            value[..., group.rows] = group.primitive.value(x[..., group.slots, :])
        return value - self.offset

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return ∂C/∂x · x', (..., m)."""
        return self._of_motion(x, x_dot, lambda primitive: primitive.rate)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return x'ᵀ C_xx x', (..., m)."""
        return self._of_motion(x, x_dot, lambda primitive: primitive.curvature)

    def _of_motion(
        self, x: Numbers, x_dot: Numbers, of: Callable[[Primitive], Callable[[Numbers, Numbers], Numbers]]
    ) -> Numbers:
        values = np.empty((*x.shape[:-2], self.size), dtype=np.result_type(x, x_dot), order="F", like=like_of(x, x_dot))
        for group in self.groups:
            slots = group.slots
            values[..., group.rows] = of(group.primitive)(x[..., slots, :], x_dot[..., slots, :])
        return values

    def forces(self, x: Numbers, multipliers: Numbers) -> Numbers:
        """Return ∂C/∂xᵀ λ of each attachment, (..., S, 3), for multipliers λ (..., m)."""
        lead = np.broadcast_shapes(x.shape[:-2], multipliers.shape[:-1])
        forces = np.empty(
            (*lead, *x.shape[-2:]), dtype=np.result_type(x, multipliers), order="F", like=like_of(x, multipliers)
        )
        for group in self.groups:
            slots = group.slots
            forces[..., slots, :] = group.primitive.forces(x[..., slots, :], multipliers[..., group.rows])
        return forces

    def gradient_entries(self, x: Numbers) -> Numbers:
        """Return the entries of ∂C/∂x that can be nonzero, (..., e, 3): row `entry_row`, attachment `entry_slot`."""
        lead = x.shape[:-2]
        parts = [group.primitive.gradient(x[..., group.slots, :]).reshape(*lead, -1, 3) for group in self.groups]
        return np.concatenate(parts, axis=-2) if parts else np.zeros((*lead, 0, 3))

    def derivative_along(self, gradient: Numbers, direction: Numbers) -> Numbers:
        """Return ∂C/∂x · direction, (..., m), from `gradient_entries` and one vector per attachment, (..., S, 3)."""
        along = direction[..., self.entry_slot, :]
        x, y, z = (gradient[..., axis] * along[..., axis] for axis in range(3))
        products = x + y + z
        total = np.zeros((*products.shape[:-1], self.size), dtype=products.dtype, like=products)
        for group in self.groups:
            count = group.rows.size * group.slots.shape[1]
            terms, products = products[..., :count], products[..., count:]
            total[..., group.rows] = terms.reshape(*terms.shape[:-1], *group.rows.shape, -1).sum(axis=-1)
        return total


def bind(bindings: Sequence[Binding]) -> PrimitiveSet:
    """Return the set of these primitives; rows are in the order of the bindings."""
    bound = tuple([(each.primitive, each.owner, *[slot[:2] for slot in each.slots]) for each in bindings])
    layout = _cached_layout(bound) if len(bound) <= MOST_KEPT else _layout(bound)
    return PrimitiveSet(
        layout,
        local=numbers([slot[2] for each in bindings for slot in each.slots]).reshape(-1, 3),
        offset=numbers([each.offset for each in bindings])[layout.member],
    )


@lru_cache(LAYOUTS)
def _cached_layout(bound: tuple[tuple[Any, ...], ...]) -> SetLayout:
    """Return a layout from the cache. Sets share it, so that nobody may write to it."""
    layout = _layout(bound)
    arrays = [part for part in vars(layout).values() if isinstance(part, np.ndarray)]
    for array in [*arrays, *[part for group in layout.groups for part in (group.slots, group.rows)]]:
        array.flags.writeable = False
    return layout


def _layout(bound: tuple[tuple[Any, ...], ...]) -> SetLayout:
    """Return the layout of primitives, each given with its owner and then a body and a side for each slot."""
    primitives: list[Primitive] = [each[0] for each in bound]
    attachments = [slot for _, _, *slots in bound for slot in slots]
    height = [primitive.rows for primitive in primitives]
    first_row, first_slot = np.cumsum([0, *height]), np.cumsum([0] + [len(each) - 2 for each in bound])
    members = [
        Member(primitive, tuple(range(row, row + primitive.rows)), tuple(range(slot, slot + len(primitive.slots))))
        for primitive, row, slot in zip(primitives, first_row.tolist(), first_slot.tolist(), strict=False)
    ]
    alike: dict[Primitive, list[int]] = {}
    for index, primitive in enumerate(primitives):
        alike.setdefault(primitive, []).append(index)
    groups, is_point, is_length = [], np.zeros(len(attachments)), np.zeros(first_row[-1], dtype=bool)
    for primitive, indices in alike.items():
        slots = first_slot[indices][:, None] + np.arange(len(primitive.slots))
        rows = first_row[indices][:, None] + np.arange(primitive.rows)
        is_point[slots] = [float(kind == "point") for kind in primitive.slots]
        is_length[rows] = primitive.unit == "m"
        groups.append(Group(primitive, slots, rows))
    entry_row, entry_slot = _entries(groups)
    return SetLayout(
        tuple(groups),
        body=np.array([body for body, _ in attachments], dtype=np.intp),
        side=np.array([side for _, side in attachments], dtype=np.intp),
        is_point=is_point,
        owner=np.repeat(np.array([each[1] for each in bound], dtype=np.intp), height),
        is_length=is_length,
        is_velocity=np.repeat(np.array([not each.integrable for each in primitives], dtype=bool), height),
        members=tuple(members),
        member=np.repeat(np.arange(len(bound)), height),
        entry_row=entry_row,
        entry_slot=entry_slot,
    )


def bindings(bound: PrimitiveSet, rows: Sequence[int] | None = None) -> list[Binding]:
    """Return the primitives of a set as bindings, in the order of their rows; of all, or of those with these first
    rows."""
    by_row = dict(_bindings(bound))
    return [by_row[row] for row in (sorted(by_row) if rows is None else rows)]


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
