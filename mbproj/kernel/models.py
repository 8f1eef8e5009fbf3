"""From a System or a Plane to the kernel's models."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np

from mbproj.arrays import Array, Integers, distinct_rows
from mbproj.kernel.bound import Bound, bound_in_plane, bound_in_space, joined, primitives
from mbproj.kernel.loads import (
    along_in_plane,
    motion_coordinate,
    motion_programs,
    motion_start,
    plane_loads,
    space_loads,
)
from mbproj.model.meshes import Meshes
from mbproj.model.planar import Plane, coordinates_in_plane
from mbproj.model.stops import Stops
from mbproj.model.system import System
from mbproj.thresholds import of_the_kernel


def space_model(core: ModuleType, system: System) -> Any:
    """The kernel's model of a system with six coordinates a body. Joints keep their numbers, rows their order; motions
    follow the joints, as joints of one row each."""
    n, sets = system.bodies, [system.joints] if system.motions is None else [system.joints, system.motions.rows]
    rows = joined([bound_in_space(bound) for bound in sets])
    coordinates = bound_in_space(system.coordinates)
    return core.SpaceModel(
        thresholds=core.Thresholds(of_the_kernel()),
        mass=system.mass,
        inertia=np.ascontiguousarray(system.inertia),
        gravity=system.gravity,
        constraints=primitives(core.SpacePrimitives, n, rows),
        joint_begin=_runs(rows.owner),
        row_scale=np.ascontiguousarray(system.row_scale[n:]),
        coordinates=primitives(core.SpacePrimitives, n, coordinates),
        length=system.length,
        loads=space_loads(core, system),
        motions=motion_programs(core, system),
        motion_start=motion_start(system),
        motion_coordinate=motion_coordinate(system).tolist(),
        meshes=_meshes(system.meshes.row, system.meshes.coordinate, system.meshes),
        **_space_flywheels(core, system),
        **_space_stops(core, system),
    )


def _space_flywheels(core: ModuleType, system: System) -> dict[str, Any]:
    """The reflected inertias: flywheels that coordinates turn; none where the scene has none."""
    if system.reflected is None:
        return {}
    coordinates = bound_in_space(system.reflected.rows)
    return {
        "flywheel_coordinates": primitives(core.SpacePrimitives, system.bodies, coordinates),
        "flywheels": system.reflected.inertia.tolist(),
    }


def _plane_flywheels(core: ModuleType, system: System, plane: Plane, coordinates: Bound) -> dict[str, Any]:
    """The same of the coordinates that change in the plane: the others' rates are 0."""
    if system.reflected is None:
        return {}
    own = coordinates_in_plane(plane, system.reflected.joint_coordinate)
    turned = np.flatnonzero(own >= 0)
    return {
        "flywheel_coordinates": primitives(core.PlanePrimitives, system.bodies, coordinates.only(own[turned])),
        "flywheels": system.reflected.inertia[turned].tolist(),
    }


def _space_stops(core: ModuleType, system: System) -> dict[str, Any]:
    """What stops limit; none where the scene has none."""
    stops = system.stops
    return {} if stops is None else _stops(core.SpacePrimitives, bound_in_space(stops.coordinates), system, stops)


def _plane_stops(core: ModuleType, system: System, plane: Plane, coordinates: Bound) -> dict[str, Any]:
    """The same in a plane: a coordinate that no motion in it changes is seen from within it, too."""
    stops = system.stops
    if stops is None:
        return {}
    along = along_in_plane(stops.coordinates, stops.joint_coordinate, plane, coordinates)
    in_plane = replace(stops, joint_coordinate=coordinates_in_plane(plane, stops.joint_coordinate))
    return _stops(core.PlanePrimitives, along, system, in_plane)


def _stops(kind: Any, along: Bound, system: System, stops: Stops) -> dict[str, Any]:
    return {
        "stop_coordinates": primitives(kind, system.bodies, along),
        "stop_turns": stops.joint_coordinate.tolist(),
        "stop_bounds": stops.bound.tolist(),
    }


def plane_model(core: ModuleType, system: System, plane: Plane) -> Any:
    """The kernel's model of a planar system. Its joints are those with rows in the plane, by `joints_in_plane`."""
    coordinates = bound_in_plane(plane.coordinates)
    joints = bound_in_plane(plane.joints)
    rows = joint_and_motion_rows(system, plane, joints, coordinates)
    return core.PlaneModel(
        thresholds=core.Thresholds(of_the_kernel()),
        mass=plane.mass,
        inertia=plane.inertia.reshape(-1, 1, 1),
        gravity=plane.gravity,
        constraints=primitives(core.PlanePrimitives, system.bodies, rows),
        joint_begin=_runs(rows.owner),
        row_scale=plane_row_scale(system, plane),
        coordinates=primitives(core.PlanePrimitives, system.bodies, coordinates),
        length=system.length,
        loads=plane_loads(core, system, plane, coordinates),
        motions=motion_programs(core, system),
        motion_start=motion_start(system),
        motion_coordinate=coordinates_in_plane(plane, motion_coordinate(system)).tolist(),
        meshes=_meshes_in_plane(system, plane),
        **_plane_flywheels(core, system, plane, coordinates),
        **_plane_stops(core, system, plane, coordinates),
    )


def _meshes(row: Integers, coordinate: Integers, meshes: Meshes) -> list[tuple[Any, ...]]:
    """Gears and screws as the kernel takes them: row, coordinates, weights, period."""
    parts = zip(row.tolist(), coordinate.tolist(), meshes.weight.tolist(), meshes.period.tolist(), strict=True)
    return [(at, *pair, *weights, period) for at, pair, weights, period in parts]


def _meshes_in_plane(system: System, plane: Plane) -> list[tuple[Any, ...]]:
    """The gears; a scene with a screw is not planar."""
    meshes, rows = system.meshes, plane_rows(plane).tolist()
    row = np.array([rows.index(at) for at in meshes.row.tolist()], dtype=np.intp)
    coordinate = coordinates_in_plane(plane, meshes.coordinate.ravel()).reshape(-1, 2)
    return _meshes(row, coordinate, meshes)


def joint_and_motion_rows(system: System, plane: Plane, joints: Bound, coordinates: Bound) -> Bound:
    """The joints' rows in the plane, and after them the coordinates that motions drive."""
    if system.motions is None:
        return joints
    driven = coordinates.only(coordinates_in_plane(plane, system.motions.joint_coordinate))
    return joined([joints, driven._replace(owner=np.arange(len(driven.kind)))])


def joints_in_plane(plane: Plane) -> Integers:
    """The system's numbers of the joints that have rows in the plane."""
    return distinct_rows(plane.joints.owner[:, None])[0][:, 0]


def plane_rows(plane: Plane) -> Integers:
    """For each row in the plane a row of the system's joints that it comes from, (m,)."""
    source = plane.joints.source
    return source.source[np.searchsorted(source.row, np.arange(source.size))]


def plane_row_scale(system: System, plane: Plane) -> Array:
    """What each row in the plane is measured against, (m,): the joints', then the motions'."""
    scale = system.row_scale[system.bodies :]
    return np.concatenate([scale[plane_rows(plane)], scale[system.joints.size :]])


def _runs(owner: Integers) -> Integers:
    """Where each owner's primitives begin, and the end; the owners are sorted."""
    starts = np.flatnonzero(np.diff(owner, prepend=-1))
    return np.append(starts, len(owner)).astype(np.int64)
