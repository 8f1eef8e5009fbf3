"""Functions, forces and motions as the kernel takes them."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from mbproj.arrays import Array, Integers, contiguous
from mbproj.functions.program import CHANNELS
from mbproj.functions.program_set import ProgramSet
from mbproj.kernel.bound import Bound, bound_in_space, joined, primitives
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.forces import Bushings, Forces
from mbproj.model.planar import Plane, bushings_in_plane, coordinates_in_plane, locals_in_plane
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System


def programs(core: ModuleType, functions: ProgramSet, variables: int = CHANNELS) -> Any:
    """The kernel's copy of a set of functions of so many variables."""
    return core.Programs(
        start=_indices(functions.start),
        op=_indices(functions.op),
        operand=contiguous(functions.operand, dtype=float),
        table_start=_indices(functions.table_start),
        knot=np.ascontiguousarray(functions.knot, dtype=float),
        origin=contiguous(functions.origin, dtype=float),
        piece=_floats(functions.piece, 4),
        kinked=_indices(functions.kinked),
        period=np.ascontiguousarray(functions.period, dtype=float),
        variables=variables,
    )


def functions(core: ModuleType, system: System, index: Integers) -> dict[str, Any]:
    """All programs, their channels and their switches. `index` (c,) has the number of each channel in its list."""
    return {
        "programs": programs(core, system.programs, CHANNELS + system.channels.size),
        "first_rate": system.first_rate,
        "channels": _indices(np.column_stack([system.channels.kind, index])),
        "switches": _indices(_switches(system.programs)).reshape(-1, 2),
    }


def _switches(functions: ProgramSet) -> list[tuple[int, int]]:
    if not functions.size:  # most scenes, which need not load what follows
        return []
    from mbproj.functions.switches import all_switches

    return all_switches(functions)


def space_loads(core: ModuleType, system: System) -> Any:
    """All forces but gravity in space; None without any."""
    forces = system.forces
    if forces.is_empty:
        return None
    given = forces.on_bodies
    maps = np.where(given.in_body[:, None, None], given.turn, np.eye(3))
    return core.SpaceLoads(
        coordinates=primitives(core.SpacePrimitives, system.bodies, bound_in_space(forces.laws.coordinates)),
        joint_coordinate=_indices(forces.laws.joint_coordinate),
        point=_floats(given.point, 3),
        force_map=_floats(maps, 3, 3),
        torque_map=_floats(maps, 3, 3),
        bushings=_space_bushings(core, system.bodies, forces.bushings),
        **_common(system.bodies, forces),
    )


def plane_loads(core: ModuleType, system: System, plane: Plane, coordinates: Bound) -> Any:
    """All forces but gravity in a plane, where `obstacle_in_plane` finds none; None without any."""
    forces = system.forces
    if forces.is_empty:
        return None
    reference = np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])[forces.on_bodies.body]
    given = forces.on_bodies
    maps = np.where(given.in_body[:, None, None], plane.axes.T @ reference @ given.turn, plane.axes.T)
    along = along_in_plane(forces.laws.coordinates, forces.laws.joint_coordinate, plane, coordinates)
    return core.PlaneLoads(
        coordinates=primitives(core.PlanePrimitives, system.bodies, along),
        joint_coordinate=_indices(coordinates_in_plane(plane, forces.laws.joint_coordinate)),
        point=_floats((plane.axes.T @ reference @ given.point[..., None])[:, :2, 0], 2),
        force_map=_floats(maps[:, :2], 2, 3),
        torque_map=_floats(maps[:, 2:], 1, 3),
        bushings=_plane_bushings(core, system.bodies, forces.bushings, plane),
        **_common(system.bodies, forces),
    )


def _space_bushings(core: ModuleType, bodies: int, bushings: Bushings) -> Any:
    return core.SpaceBushings(
        bodies=bodies,
        body=_indices(bushings.body.ravel()),
        origin=_floats(bushings.origin, 3),
        turn=_floats(rotation_matrix(bushings.turn), 3, 3),
        stiffness=_floats(bushings.stiffness, 6, 6),
        damping=_floats(bushings.damping, 6, 6),
        preload=_floats(bushings.preload, 6),
        map=_floats(np.tile(np.eye(6), (bushings.size, 1, 1)), 6, 6),
        turns_freely=_indices(bushings.turns_freely),
    )


def _plane_bushings(core: ModuleType, bodies: int, bushings: Bushings, plane: Plane) -> Any:
    in_plane = bushings_in_plane(plane, bushings)
    return core.PlaneBushings(
        bodies=bodies,
        body=_indices(bushings.body.ravel()),
        origin=_floats(in_plane.origin, 2),
        turn=_floats(in_plane.turn, 2, 2),
        stiffness=_floats(in_plane.stiffness, 3, 3),
        damping=_floats(in_plane.damping, 3, 3),
        preload=_floats(in_plane.preload, 3),
        turns_freely=_indices(bushings.turns_freely),
        map=_floats(in_plane.map, 6, 3),
    )


def along_in_plane(own: PrimitiveSet, joint_coordinate: Integers, plane: Plane, coordinates: Bound) -> Bound:
    """The coordinates along which forces or stops act, one each: the joint coordinate that `joint_coordinate` numbers,
    or the primitive in `own` where that is -1."""
    flat = bound_in_space(own)._replace(local=locals_in_plane(plane, own))
    every = joined([coordinates, flat])
    number = coordinates_in_plane(plane, joint_coordinate)
    return every.only(np.where(number >= 0, number, len(coordinates.kind) + np.arange(own.size)))


def _common(bodies: int, forces: Forces) -> dict[str, Any]:
    laws, given = forces.laws, forces.on_bodies
    return {
        "bodies": bodies,
        "law": _floats(np.column_stack([laws.stiffness, laws.damping, laws.free]), 3),
        "law_program": _indices(laws.program),
        "law_loses": _indices(laws.loses),
        "law_bearing": _indices(laws.bearing),
        "law_apart": _indices(laws.apart),
        "law_partner": _indices(laws.partner),
        "law_sliding": _floats(laws.sliding, 2),
        "body": _indices(given.body),
        "is_torque": _indices(given.is_torque),
        "in_body": _indices(given.in_body),
        "program": np.ascontiguousarray(given.program.reshape(-1, 3), dtype=np.int64),
    }


def _indices(values: Any) -> Integers:
    return np.ascontiguousarray(values, dtype=np.int64)


def _floats(values: Array, *shape: int) -> Array:
    return contiguous(values, dtype=float).reshape(-1, *shape)
