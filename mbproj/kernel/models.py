"""From a System or a Plane to the kernel's models: flat arrays of attachments and primitives."""

from __future__ import annotations

from collections.abc import Iterable
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from mbproj.arrays import Array, Integers, distinct_rows
from mbproj.constraints import PRIMITIVES, Primitive
from mbproj.model.planar import PlanarSet, Plane
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System

#: The primitives in the order of the kernel's `Kind`.
KINDS = ("coincident", "perpendicular", "along", "distance", "angle", "screw", "gear")
MOST_SLOTS = 6


class Bound(NamedTuple):
    """k primitives in the order of their rows: kinds (k,), slots (k, 6), parameters (k, 2), offsets and owners (k,)."""

    kind: Integers
    slots: Integers
    parameters: Array
    offset: Array
    owner: Integers


def space_model(core: ModuleType, system: System) -> Any:
    """The kernel's model of a system with six coordinates a body. Joints keep their numbers, rows their order."""
    n, joints = system.bodies, _bound_in_space(system.joints)
    return core.SpaceModel(
        mass=system.mass,
        inertia=np.ascontiguousarray(system.inertia),
        gravity=system.gravity,
        constraints=_primitives(core.SpacePrimitives, n, system.joints, joints),
        joint_begin=_runs(joints.owner),
        row_scale=np.ascontiguousarray(system.row_scale[n:]),
        coordinates=_primitives(core.SpacePrimitives, n, system.coordinates, _bound_in_space(system.coordinates)),
        length=system.length,
    )


def plane_model(core: ModuleType, system: System, plane: Plane) -> Any:
    """The kernel's model of a planar system. Its joints are those with rows in the plane, by `joints_in_plane`."""
    joints = _bound_in_plane(plane.joints)
    return core.PlaneModel(
        mass=plane.mass,
        inertia=plane.inertia.reshape(-1, 1, 1),
        gravity=plane.gravity,
        constraints=_primitives(core.PlanePrimitives, system.bodies, plane.joints, joints),
        joint_begin=_runs(joints.owner),
        row_scale=plane_row_scale(system, plane),
        coordinates=_primitives(
            core.PlanePrimitives, system.bodies, plane.coordinates, _bound_in_plane(plane.coordinates)
        ),
        length=system.length,
    )


def joints_in_plane(plane: Plane) -> Integers:
    """The system's numbers of the joints that have rows in the plane."""
    return distinct_rows(plane.joints.owner[:, None])[0][:, 0]


def plane_rows(plane: Plane) -> Integers:
    """For each row in the plane a row of the system's joints that it comes from, (m,)."""
    source = plane.joints.source
    return source.source[np.searchsorted(source.row, np.arange(source.size))]


def plane_row_scale(system: System, plane: Plane) -> Array:
    """What each row in the plane is measured against, (m,)."""
    return np.ascontiguousarray(system.row_scale[system.bodies :][plane_rows(plane)])


def _bound_in_space(bound: PrimitiveSet) -> Bound:
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
    )


def _bound_in_plane(bound: PlanarSet) -> Bound:
    starts = zip(bound.first_slot, bound.primitives, strict=True)
    slots = [(start + np.arange(len(primitive.slots)))[None] for start, primitive in starts]
    return Bound(
        kind=_codes(bound.primitives),
        slots=_stacked(slots),
        parameters=_parameters(bound.primitives),
        offset=bound.offset[bound.row],
        owner=bound.owner,
    )


def _codes(primitives: Iterable[Primitive]) -> Integers:
    code = {PRIMITIVES[name]: number for number, name in enumerate(KINDS)}
    return np.array([code[type(primitive)] for primitive in primitives], dtype=np.int64)


def _parameters(primitives: Iterable[Primitive]) -> Array:
    rows = [
        [float(number) for name in primitive.parameters for number in np.ravel(getattr(primitive, name))]
        for primitive in primitives
    ]
    return np.array([[*row, 0.0, 0.0][:2] for row in rows]).reshape(-1, 2)


def _stacked(slots: list[Integers]) -> Integers:
    """Slots of several widths as one array, filled with zeros."""
    wide = [np.pad(part, ((0, 0), (0, MOST_SLOTS - part.shape[1]))) for part in slots]
    return np.concatenate(wide) if wide else np.zeros((0, MOST_SLOTS), dtype=np.int64)


def _runs(owner: Integers) -> Integers:
    """Where each owner's primitives begin, and the end; the owners are sorted."""
    starts = np.flatnonzero(np.diff(owner, prepend=-1))
    return np.append(starts, len(owner)).astype(np.int64)


def _primitives(kind: Any, bodies: int, bound: PrimitiveSet | PlanarSet, instances: Bound) -> Any:
    """The kernel's set. Points and vectors that several primitives bind are there once."""
    every = np.column_stack([bound.body, bound.is_point, bound.local])
    unique, place = distinct_rows(every)
    slots = place[instances.slots] if len(every) else instances.slots
    return kind(
        bodies=bodies,
        body=unique[:, 0].astype(np.int64),
        is_point=unique[:, 1].astype(np.int64),
        local=np.ascontiguousarray(unique[:, 2:]),
        kind=instances.kind.astype(np.int64),
        slots=np.ascontiguousarray(slots, dtype=np.int64),
        parameters=np.ascontiguousarray(instances.parameters, dtype=float),
        offset=np.ascontiguousarray(instances.offset, dtype=float),
    )
