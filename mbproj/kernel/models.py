"""The kernel's models of a System, in space or in a plane."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.arrays import Array, Integers, contiguous
from mbproj.functions.program import CHANNELS
from mbproj.kernel.bound import Bound, bound_in_plane, bound_in_space, joined, primitives
from mbproj.kernel.loads import (
    along_in_plane,
    functions,
    plane_loads,
    programs,
    space_loads,
)
from mbproj.model.couplings import FollowedKind
from mbproj.model.layout import Layout
from mbproj.model.planar import Plane, channels_in_plane, coordinates_in_plane
from mbproj.model.system import System
from mbproj.thresholds import Thresholds, of_the_kernel

if TYPE_CHECKING:
    from mbproj.model.bearings import Parts


@cache
def _thresholds(core: ModuleType, thresholds: Thresholds) -> Any:
    """The thresholds of the kernel, as its class."""
    return core.Thresholds(**of_the_kernel(thresholds))


def space_model(core: ModuleType, system: System, layout: Layout) -> Callable[[], Any]:
    """A function that makes the kernel's model of a system with six coordinates a body. The model has the joints with
    rows, in their order, and then each motion as a joint of one row."""
    n, rows = system.bodies, bound_in_space(system.rows)
    coordinates = bound_in_space(system.coordinates)
    return partial(
        core.SpaceModel,
        thresholds=_thresholds(core, system.thresholds),
        mass=system.mass,
        inertia=contiguous(system.inertia, dtype=float),
        gravity=system.gravity,
        constraints=primitives(core.SpacePrimitives, n, rows),
        joint_begin=_runs(rows.owner),
        row_scale=contiguous(system.row_scale[n:], dtype=float),
        coordinates=primitives(core.SpacePrimitives, n, coordinates),
        length=system.length,
        layout=_blocks(layout),
        loads=space_loads(core, system),
        **functions(core, system, system.channels.index),
        motion_start=system.motions.start.tolist(),
        motion_coordinate=system.motions.joint_coordinate.tolist(),
        couplings=_couplings(system, system.couplings.row, system.couplings.coordinate),
        followers=[(int(kind), at, program, second) for program, (kind, at, second) in system.following.items()],
        **_space_flywheels(core, system),
        **_space_stops(core, system),
        **_space_bearings(system),
        **_actions(core, system),
    )


def _actions(core: ModuleType, system: System) -> dict[str, Any]:
    """The actions of controllers on states; {} without controllers."""
    actions = system.actions
    if not actions.size:
        return {}
    pairs = list(zip(actions.state.tolist(), range(actions.programs.size), strict=True))
    return {
        "actions": [[pairs[k] for k in actions.sets(action)] for action in range(actions.size)],
        "action_programs": programs(core, actions.programs, CHANNELS + system.channels.size),
    }


def _blocks(layout: Layout) -> list[tuple[Any, ...]]:
    """The blocks of y: their names, scales and initial values."""
    return [
        (each.name, each.scale.tolist(), [] if each.start is None else each.start.tolist()) for each in layout.blocks
    ]


def _space_flywheels(core: ModuleType, system: System) -> dict[str, Any]:
    """The reflected inertias, as flywheels that coordinates turn; {} without any."""
    if not system.reflected.size:
        return {}
    coordinates = bound_in_space(system.reflected.rows)
    return {
        "flywheel_coordinates": primitives(core.SpacePrimitives, system.bodies, coordinates),
        "flywheels": system.reflected.inertia.tolist(),
    }


def _plane_flywheels(core: ModuleType, system: System, plane: Plane, coordinates: Bound) -> dict[str, Any]:
    """The flywheels of the coordinates that change in the plane. The rates of all others are 0."""
    if not system.reflected.size:
        return {}
    own = coordinates_in_plane(plane, system.reflected.joint_coordinate)
    turned = np.flatnonzero(own >= 0)
    return {
        "flywheel_coordinates": primitives(core.PlanePrimitives, system.bodies, coordinates.only(own[turned])),
        "flywheels": system.reflected.inertia[turned].tolist(),
    }


def _space_stops(core: ModuleType, system: System) -> dict[str, Any]:
    """The coordinates of stops, and then those of dry friction; {} without either."""
    parts = [bound_in_space(own.coordinates) for own in (system.stops, system.frictions) if own is not None]
    return _stops(core.SpacePrimitives, joined(parts), system, *_counted_turns(system)) if parts else {}


def _plane_stops(core: ModuleType, system: System, plane: Plane, coordinates: Bound) -> dict[str, Any]:
    """The coordinates of stops and dry friction in a plane, constant ones included."""
    parts = [
        along_in_plane(own.coordinates, own.joint_coordinate, plane, coordinates)
        for own in (system.stops, system.frictions)
        if own is not None
    ]
    if not parts:
        return {}
    turns, bounds = _counted_turns(system)
    return _stops(core.PlanePrimitives, joined(parts), system, coordinates_in_plane(plane, turns), bounds)


def _counted_turns(system: System) -> tuple[Integers, Array]:
    """For each stop and dry friction the joint coordinate whose turns it counts, and its bound in m or rad."""
    turns, bounds = [np.zeros(0, dtype=np.intp)], [np.zeros(0)]
    if system.stops is not None:
        turns, bounds = [system.stops.joint_coordinate], [system.stops.bound]
    if system.frictions is not None:
        turns, bounds = [*turns, system.frictions.joint_coordinate], [*bounds, np.zeros(system.frictions.size)]
    return np.concatenate(turns), np.concatenate(bounds)


def _stops(kind: Any, along: Bound, system: System, turns: Integers, bounds: Array) -> dict[str, Any]:
    return {
        "stop_coordinates": primitives(kind, system.bodies, along),
        "stop_turns": turns.tolist(),
        "stop_bounds": bounds.tolist(),
    }


def _space_bearings(system: System) -> dict[str, Any]:
    """The bearings whose loads friction depends on, in space."""
    bearings = system.bearings
    if bearings is None:
        return _bearings([], [], (), np.zeros((0, 3)), np.zeros((0, 3)))
    body, point = system.reaction_body[bearings.joint], system.reaction_local[bearings.joint]
    numbers = zip(bearings.radial, bearings.axial, bearings.length, bearings.preload, strict=True)
    own = joints_with_rows(system.rows.owner)
    whose = [(own.index(joint), each) for joint, each in zip(bearings.joint.tolist(), body.tolist(), strict=True)]
    return _bearings(whose, list(numbers), _numbered(bearings.parts, own), point, bearings.axis)


def _plane_bearings(system: System, plane: Plane) -> dict[str, Any]:
    """The bearings in a plane, where axial forces and moments are 0."""
    bearings, own = system.bearings, joints_with_rows(plane.joints.owner)
    if bearings is None:
        return _bearings([], [], (), np.zeros((0, 2)), np.zeros((0, 2)))
    joints = [own.index(joint) for joint in bearings.joint.tolist()]
    body, none = system.reaction_body[bearings.joint].tolist(), np.zeros((bearings.size, 2))
    numbers = [
        (radial, axial, np.inf, preload)
        for radial, axial, preload in zip(
            bearings.radial, bearings.axial * bearings.is_of_rows, bearings.preload, strict=True
        )
    ]
    return _bearings(list(zip(joints, body, strict=True)), numbers, _numbered(bearings.parts, own), none, none)


def _numbered(parts: tuple[Parts, ...], own: list[int]) -> tuple[Parts, ...]:
    """The parts of bearings, by the numbers of the kernel's joints."""
    return tuple(tuple((own.index(joint), row, part) for joint, row, part in each) for each in parts)


def _bearings(
    whose: list[tuple[int, int]],
    numbers: list[Any],
    parts: tuple[Parts, ...],
    points: Array,
    axes: Array,
) -> dict[str, Any]:
    each = zip(whose, numbers, parts, strict=True)
    return {
        "bearings": [(*who, *map(float, own), list(pushed)) for who, own, pushed in each],
        "bearing_points": np.ascontiguousarray(points),
        "bearing_axes": np.ascontiguousarray(axes),
    }


def plane_model(core: ModuleType, system: System, plane: Plane, layout: Layout) -> Callable[[], Any]:
    """A function that makes the kernel's model of a planar system. Its joints are those with rows in the plane, by
    `joints_with_rows`."""
    coordinates = bound_in_plane(plane.coordinates)
    joints = bound_in_plane(plane.joints)
    rows = joint_and_motion_rows(system, plane, joints, coordinates)
    return partial(
        core.PlaneModel,
        thresholds=_thresholds(core, system.thresholds),
        mass=plane.mass,
        inertia=plane.inertia.reshape(-1, 1, 1),
        gravity=plane.gravity,
        constraints=primitives(core.PlanePrimitives, system.bodies, rows),
        joint_begin=_runs(rows.owner),
        row_scale=plane_row_scale(system, plane),
        coordinates=primitives(core.PlanePrimitives, system.bodies, coordinates),
        length=system.length,
        layout=_blocks(layout),
        loads=plane_loads(core, system, plane, coordinates),
        **functions(core, system, channels_in_plane(plane, system.channels)),
        motion_start=system.motions.start.tolist(),
        motion_coordinate=coordinates_in_plane(plane, system.motions.joint_coordinate).tolist(),
        couplings=_couplings_in_plane(system, plane),
        followers=_followers_in_plane(system, plane),
        **_plane_flywheels(core, system, plane, coordinates),
        **_plane_stops(core, system, plane, coordinates),
        **_plane_bearings(system, plane),
        **_actions(core, system),
    )


def _couplings(system: System, row: Integers, coordinate: Integers) -> list[tuple[Any, ...]]:
    """The rows that couple coordinates, each as (row, period, coordinates, weights, program, growth)."""
    couplings = system.couplings
    parts = [np.split(each, couplings.first[1:]) for each in (coordinate, couplings.weight)]
    program = np.where(couplings.program >= 0, system.first_coupled + couplings.program, -1)
    own = [[each.tolist() for each in split] for split in parts]
    growth = couplings.growth.tolist()
    return list(zip(row.tolist(), couplings.period.tolist(), *own, program.tolist(), growth, strict=False))


def _couplings_in_plane(system: System, plane: Plane) -> list[tuple[Any, ...]]:
    """The rows that couple coordinates in a plane."""
    couplings, rows = system.couplings, plane_rows(plane).tolist()
    row = np.array([rows.index(at) for at in couplings.row.tolist()], dtype=np.intp)
    return _couplings(system, row, coordinates_in_plane(plane, couplings.coordinate))


def _followers_in_plane(system: System, plane: Plane) -> list[tuple[int, int, int, int]]:
    """The followers of curves in a plane: kind, number in its list, program, and 1 on the second of two curves."""
    rows, followers = plane_rows(plane).tolist(), []
    for program, (kind, at, second) in system.following.items():
        if kind is FollowedKind.COORDINATE:
            own = int(coordinates_in_plane(plane, np.array([at]))[0])
        else:
            own = rows.index(at) if kind is FollowedKind.ROW else at
        followers.append((int(kind), own, program, second))
    return [each for each in followers if each[1] >= 0]  # what is constant in the plane has no sign to change


def joint_and_motion_rows(system: System, plane: Plane, joints: Bound, coordinates: Bound) -> Bound:
    """The joints' rows in the plane, and after them the coordinates that motions drive."""
    driven = coordinates.only(coordinates_in_plane(plane, system.motions.joint_coordinate))
    return joined([joints, driven._replace(owner=np.arange(len(driven.kind)))])


def joints_with_rows(owner: Integers) -> list[int]:
    """The numbers of the joints that own these rows, ascending: the joints of the kernel's model."""
    return sorted({*owner.tolist()})


def plane_rows(plane: Plane) -> Integers:
    """For each row in the plane one row of the system that it comes from, (m,)."""
    source = plane.joints.source
    return source.source[np.searchsorted(source.row, np.arange(source.size))]


def plane_row_scale(system: System, plane: Plane) -> Array:
    """The scale of each row in the plane, (m,): of joints, then of motions."""
    scale = system.row_scale[system.bodies :]
    return np.concatenate([scale[plane_rows(plane)], scale[system.joints.size :]])


def _runs(owner: Integers) -> Integers:
    """The index of the first primitive of each owner, and their number last. The owners are sorted."""
    starts = np.flatnonzero(np.diff(owner, prepend=-1))
    return np.append(starts, len(owner)).astype(np.int64)
