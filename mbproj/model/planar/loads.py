"""Forces and motions of a planar scene: what of them acts in the plane, and what keeps a scene from being planar."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.planar.bushings import tilted_bushings
from mbproj.model.planar.plane import Plane
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def obstacle_in_plane(system: System, plane: Plane) -> str | None:
    """What of the forces and motions is no function of the coordinates in the plane; None where all are.

    Forces out of the plane are none: the joints bear them.
    """
    if system.motions is not None:
        locked = np.flatnonzero(coordinates_in_plane(plane, system.motions.joint_coordinate) < 0)
        if len(locked):
            return f"motion '{system.names.motions[locked[0]]}' drives a coordinate out of the plane"
    if system.forces is not None:
        laws, owners = system.forces.laws, system.forces.law_owners
        of_joints = laws.joint_coordinate >= 0
        locked = np.flatnonzero(of_joints & (coordinates_in_plane(plane, laws.joint_coordinate) < 0))
        if len(locked):
            return f"force '{owners[locked[0]]}' acts along a coordinate out of the plane"
        depth = _depths(plane, laws.coordinates)
        for group in laws.coordinates.groups:
            apart = np.ptp(depth[group.slots], axis=1) > THRESHOLDS.in_plane * max(
                system.length, float(np.abs(depth).max())
            )
            tilted = [row for row in group.rows[apart, 0] if not of_joints[row]]
            if tilted:
                return f"force '{owners[tilted[0]]}' acts between points at different depths"
        leaning = tilted_bushings(plane, system.forces.bushings)
        if len(leaning):
            return f"the frames of force '{system.forces.bushing_names[leaning[0]]}' lean against each other"
    return None


def coordinates_in_plane(plane: Plane, joint_coordinate: Integers) -> Integers:
    """The numbers in `plane.coordinates` of the system's joint coordinates (k,); -1 for none, and for -1."""
    number = np.full(len(plane.constant) + plane.coordinates.size + 1, -1, dtype=np.intp)
    number[plane.coordinates.source.source] = np.arange(plane.coordinates.size)
    return number[joint_coordinate]


def locals_in_plane(plane: Plane, bound: PrimitiveSet) -> Array:
    """The local vectors (S, 2) of a set's attachments in their bodies' planar axes."""
    return _in_axes(plane, bound)[:, :2]


def _depths(plane: Plane, bound: PrimitiveSet) -> Array:
    return _in_axes(plane, bound)[:, 2] + bound.is_point * np.append(plane.depth, 0.0)[bound.body]


def _in_axes(plane: Plane, bound: PrimitiveSet) -> Array:
    reference = np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])
    return (plane.axes.T @ reference[bound.body] @ bound.local[..., None])[..., 0]
