"""Primitives of a set, in space or in a plane, as the flat arrays that the kernel takes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from mbproj.arrays import Array, Integers, distinct_rows
from mbproj.constraints import PRIMITIVES, Primitive
from mbproj.model.planar import PlanarSet
from mbproj.model.primitive_set import PrimitiveSet

#: The primitives in the order of the kernel's `Kind`.
KINDS = ("coincident", "perpendicular", "along", "distance", "angle", "screw", "gear")
MOST_SLOTS = 6
_CODES = {PRIMITIVES[name]: number for number, name in enumerate(KINDS)}


class Bound(NamedTuple):
    """k primitives in the order of their rows: kinds (k,), slots (k, 6), parameters (k, 2), offsets and owners (k,);
    and what the slots number: S attachments' bodies (S,), `is_point` (S,), local vectors (S, 3 or 2)."""

    kind: Integers
    slots: Integers
    parameters: Array
    offset: Array
    owner: Integers
    body: Integers
    is_point: Array
    local: Array

    def only(self, members: Integers) -> Bound:
        """Some of the primitives."""
        return self._replace(
            kind=self.kind[members],
            slots=self.slots[members],
            parameters=self.parameters[members],
            offset=self.offset[members],
            owner=self.owner[members],
        )


def joined(parts: Sequence[Bound]) -> Bound:
    """Several one after another; the owners of each follow those before it."""
    slots, owners, attachments, owned = [], [], 0, 0
    for part in parts:
        slots.append(part.slots + attachments)
        owners.append(part.owner + owned)
        attachments += len(part.body)
        owned += int(part.owner.max(initial=-1)) + 1
    rest = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("kind", "parameters", "offset", "body", "is_point", "local")
    }
    return Bound(slots=np.concatenate(slots), owner=np.concatenate(owners), **rest)


def bound_in_space(bound: PrimitiveSet) -> Bound:
    groups = [(group.primitive, group.slots, group.rows[:, 0]) for group in bound.groups]
    counts = [len(slots) for _, slots, _ in groups]
    first = np.concatenate([rows for *_, rows in groups]) if groups else np.zeros(0, dtype=np.intp)
    order = np.argsort(first)
    return Bound(
        kind=np.repeat(_codes(primitive for primitive, *_ in groups), counts)[order],
        slots=_stacked([slots for _, slots, _ in groups])[order],
        parameters=np.repeat(_parameters(primitive for primitive, *_ in groups), counts, axis=0)[order],
        offset=bound.offset[first[order]],
        owner=bound.owner[first[order]],
        body=bound.body,
        is_point=bound.is_point,
        local=bound.local,
    )


def bound_in_plane(bound: PlanarSet) -> Bound:
    numbers = np.arange(MOST_SLOTS)
    widths = np.array([len(primitive.slots) for primitive in bound.primitives], dtype=np.int64)[:, None]
    return Bound(
        kind=_codes(bound.primitives),
        slots=np.where(numbers < widths, bound.first_slot[:, None] + numbers, 0),
        parameters=_parameters(bound.primitives),
        offset=bound.offset[bound.row],
        owner=bound.owner,
        body=bound.body,
        is_point=bound.is_point,
        local=bound.local,
    )


def _codes(primitives: Iterable[Primitive]) -> Integers:
    return np.array([_CODES[type(primitive)] for primitive in primitives], dtype=np.int64)


def _parameters(primitives: Iterable[Primitive]) -> Array:
    rows = [
        [float(number) for name in primitive.parameters for number in np.ravel(getattr(primitive, name))]
        if primitive.parameters
        else []
        for primitive in primitives
    ]
    return np.array([[*row, 0.0, 0.0][:2] for row in rows]).reshape(-1, 2)


def _stacked(slots: list[Integers]) -> Integers:
    """Slots of several widths as one array, filled with zeros."""
    wide = np.zeros((sum(len(part) for part in slots), MOST_SLOTS), dtype=np.int64)
    first = 0
    for part in slots:
        wide[first : first + len(part), : part.shape[1]] = part
        first += len(part)
    return wide


def primitives(kind: Any, bodies: int, bound: Bound) -> Any:
    """The kernel's set. Points and vectors that several primitives bind are there once."""
    unique, place = distinct_rows(np.column_stack([bound.body, bound.is_point, bound.local]))
    slots = place[bound.slots] if len(place) else bound.slots
    return kind(
        bodies=bodies,
        body=unique[:, 0].astype(np.int64),
        is_point=unique[:, 1].astype(np.int64),
        local=np.ascontiguousarray(unique[:, 2:]),
        kind=bound.kind.astype(np.int64),
        slots=np.ascontiguousarray(slots, dtype=np.int64),
        parameters=np.ascontiguousarray(bound.parameters, dtype=float),
        offset=np.ascontiguousarray(bound.offset, dtype=float),
    )
