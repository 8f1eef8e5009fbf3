"""Dry friction of points, balls and wheels on planes as arrays: along two tangents of each plane."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints.basic import Along
from mbproj.constraints.slip import BallSlip, WheelSlipAcross, WheelSlipAlong
from mbproj.model.compile.frames import Pose
from mbproj.model.compile.rigid_groups import Seat
from mbproj.model.compile.stops import local_point, local_vector, seated
from mbproj.model.frictions import Frictions
from mbproj.model.primitive_set import Binding, bind, bindings
from mbproj.scene.read import Scene
from mbproj.scene.stops import PlaneStop


def tangential_friction(
    scene: Scene, seats: Mapping[str, Seat], poses: Mapping[str, Pose], stops: Sequence[str]
) -> tuple[Frictions | None, tuple[str, ...]]:
    """Return the friction at plane stops, None without any, and its names: "floor.1", "floor.2"."""
    rubbing = [force for force in scene.forces if isinstance(force, PlaneStop) and force.friction is not None]
    if not rubbing:
        return None, ()
    laws = [force.friction for force in rubbing if force.friction is not None]
    along = [binding for force in rubbing for binding in _tangents(force, seats, poses)]
    none = np.full(2 * len(rubbing), -1, dtype=np.intp)
    frictions = Frictions(
        coordinates=bind([replace(each, owner=at) for at, each in enumerate(along)]),
        joint_coordinate=none,
        sliding=np.repeat([law.sliding for law in laws], 2),
        static=np.repeat([law.static for law in laws], 2),
        stribeck=np.repeat([law.stribeck_speed or 0.0 for law in laws], 2),
        bearing=none,
        stop=np.repeat([stops.index(force.name) for force in rubbing], 2),
        partner=np.arange(len(none)) ^ 1,
        owners=tuple(f"force '{force.name}'" for force in rubbing for _ in range(2)),
        places=tuple(scene.place("forces", force.name, "friction") for force in rubbing for _ in range(2)),
    )
    return frictions, tuple(name for force in rubbing for name in force.frictions)


def all_frictions(first: Frictions | None, second: Frictions | None) -> Frictions | None:
    """Return the frictions of joints, and after them those of stops."""
    if first is None or second is None:
        return first or second
    both = [*bindings(first.coordinates), *bindings(second.coordinates)]
    partner = np.where(second.partner >= 0, second.partner + first.size, -1)

    def of_both(name: str) -> Any:
        return np.concatenate([getattr(first, name), getattr(second, name)])

    return Frictions(
        coordinates=bind([replace(each, owner=at) for at, each in enumerate(both)]),
        joint_coordinate=of_both("joint_coordinate"),
        sliding=of_both("sliding"),
        static=of_both("static"),
        stribeck=of_both("stribeck"),
        bearing=of_both("bearing"),
        stop=of_both("stop"),
        partner=np.append(first.partner, partner),
        owners=(*first.owners, *second.owners),
        places=(*first.places, *second.places),
        varies=first.varies,
    )


def _tangents(force: PlaneStop, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> list[Binding]:
    """Return the rows along both tangents. A point moves along them; a ball or a wheel slips at its lowest point."""
    seat, triad = seats[force.normal.body], _triad(force, poses)
    carrier, location = seated(force.location, local_point(force.location, poses), seats)
    other, point = seated(force.point, local_point(force.point, poses), seats)
    plane, centre = (carrier, 1, location), (other, 2, point)
    x, y, z = ((carrier, 1, seat.vector(vector)) for vector in triad)
    if force.radius == 0.0:
        return [Binding(Along(), 0, (tangent, plane, centre)) for tangent in (x, y)]
    if force.axis is None:
        back, of_ball = (carrier, 1, -x[2]), _slots(other, np.eye(3))
        both = ((plane, *axes, centre, *of_ball) for axes in ((x, y, z), (y, back, z)))
        return [Binding(BallSlip(force.radius), 0, slots) for slots in both]
    axis = local_vector(force.axis, seats, poses)
    across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    across /= np.linalg.norm(across)
    slots = (plane, x, y, z, centre, *_slots(other, np.array([np.cross(across, axis), across, axis])))
    return [Binding(slip(force.radius), 0, slots) for slip in (WheelSlipAlong, WheelSlipAcross)]


def _triad(force: PlaneStop, poses: Mapping[str, Pose]) -> Array:
    """Return two tangents of the plane and its normal as rows (3, 3), in the axes of its body. The first is as near as
    can be to the global axis most nearly normal to the plane's normal. So planes along global axes have tangents along
    these."""
    rotation = poses[force.normal.body][1]
    normal = np.array(force.normal.vector)
    normal = rotation @ normal if force.normal.local else normal
    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    across = np.cross(normal, axis)
    across /= np.linalg.norm(across)
    first = np.cross(across, normal)
    return np.array([first / np.linalg.norm(first), across, normal]) @ rotation


def _slots(carrier: int, vectors: Array) -> list[tuple[int, int, Array]]:
    """Return vectors of the second body as slots of a row."""
    return [(carrier, 2, vector) for vector in vectors]
