"""Reduces a system to its plane, or gives the reason why it has none."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers, cross
from mbproj.constraints import PRIMITIVES
from mbproj.dataclass import dataclass
from mbproj.lanes import numbers
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.planar.certain import certain_plane
from mbproj.model.planar.normals import candidate_normals, plane_axes
from mbproj.model.planar.planar_set import planar_set
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.rank import escape
from mbproj.model.planar.rows import INSIDE, OUTSIDE, Seen, see, sides
from mbproj.model.planar.tilt import Refusal, split
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class NotPlanar:
    """The reason why a scene is not planar, in words that name the joint or the body."""

    reason: str


@dataclass(frozen=True, eq=False)
class _Pose:
    """A pose: positions (n+1, 3), unit Euler parameters (n+1, 4) and rotation matrices (n+1, 3, 3), the ground last."""

    position: Array
    orientation: Array
    rotation: Array


def planar_reduction(system: System, q: Array) -> Plane | NotPlanar:
    """Return the plane in which the joints keep all bodies, at the assembled pose q (7n,), or the reason why there is
    none.

    The verdict rests on the joints alone: not on initial velocities, nor on symmetry of forces or inertia. Candidates
    for the normal with most rows outside come first; the reason is that of the first candidate.
    """
    rows = np.concatenate([q.reshape(-1, 7), [[0.0, 0, 0, 1, 0, 0, 0]]])
    orientation = rows[:, 3:] / np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    pose = _Pose(rows[:, :3], orientation, rotation_matrix(orientation))
    known = certain_plane(system.joints, pose.position, pose.rotation, system.length)
    if known is not None:
        find = _plane if known.is_held else _reduction
        plane = find(system, pose, known.axes, known.seen, known.side)
        if isinstance(plane, Plane):
            return plane
    refusals = []
    for axes, joints, side in _candidates(system, pose):
        reduction = _reduction(system, pose, axes, joints, side)
        if isinstance(reduction, Plane):
            return reduction
        refusals.append(reduction)
    return (
        refusals[0]
        if refusals
        else NotPlanar("nothing but symmetry can keep the bodies in a plane: no joint has an axis")
    )


def _candidates(system: System, pose: _Pose) -> list[tuple[Array, Seen, Integers]]:
    """Return the axes (3, 3) to try, the joints as seen along them, and the side of each row. Candidates with most rows
    outside come first, and among these the ones with fewest inside."""
    normals = candidate_normals(system.joints, pose.rotation)
    if not len(normals):
        return []
    axes = numbers([plane_axes(normal) for normal in normals])
    joints = _seen(system.joints, pose, axes, system.length)
    side = sides(system.joints, joints)
    ranked = np.lexsort([np.count_nonzero(side == INSIDE, axis=1), -np.count_nonzero(side == OUTSIDE, axis=1)])
    return [(axes[number], joints.along(number), side[number]) for number in ranked.tolist()]


def _reduction(system: System, pose: _Pose, axes: Array, joints: Seen, side: Integers) -> Plane | NotPlanar:
    """Return the plane with these axes, or the reason against it."""
    parts = split(system.joints, joints, side)
    if isinstance(parts, Refusal):
        return _not_planar(f"joint '{system.names.joints[parts.joint]}' {parts.cause}, seen in the plane", axes)
    loose = escape(system.joints, joints, parts.outside, system.names.carriers, system.length)
    if loose is not None:
        return _not_planar(loose, axes)
    return _plane(system, pose, axes, joints, np.where(parts.inside, INSIDE, OUTSIDE))


def _plane(system: System, pose: _Pose, axes: Array, joints: Seen, side: Integers) -> Plane | NotPlanar:
    """Return the plane with these axes, in which the joints hold the bodies, or the angle that is tilted against it."""
    n, inside = system.bodies, side == INSIDE
    coordinates = _seen(system.coordinates, pose, axes, system.length)
    changing = _changing(system.coordinates, coordinates)
    if not changing.all():
        rate = _in_plane_rate(system.coordinates, coordinates)
        tilted = np.flatnonzero(~changing & (np.abs(rate) > THRESHOLDS.dependent))
        if len(tilted):
            return _not_planar(f"the angle '{system.names.coordinates[tilted[0]]}' is tilted, seen in the plane", axes)
    normal = (np.swapaxes(pose.rotation[:n], -1, -2) @ axes[:, 2, None])[..., 0]
    return Plane(
        axes=axes,
        depth=pose.position[:n] @ axes[:, 2],
        reference=pose.orientation[:n],
        mass=system.mass,
        inertia=np.einsum("ni,nij,nj->n", normal, system.inertia, normal),
        gravity=system.gravity @ axes[:, :2],
        joints=planar_set(system.joints, joints, inside, axes),
        coordinates=planar_set(system.coordinates, coordinates, changing, axes),
        constant=np.flatnonzero(~changing),
    )


def _seen(bound: PrimitiveSet, pose: _Pose, axes: Array, length: float) -> Seen:
    return see(bound, pose.position, pose.rotation, axes, length)


def _changing(bound: PrimitiveSet, seen: Seen) -> npt.NDArray[np.bool_]:
    """Whether each coordinate can change, (nc,): angles between vectors in the plane, and displacements along a vector
    that is not the normal. Other tilted coordinates belong to motions that the joint locks."""
    side = sides(bound, seen)
    shift = np.zeros(bound.size, dtype=bool)
    for group in bound.groups:
        shift[group.rows] = isinstance(group.primitive, PRIMITIVES["along"])
    return (side == INSIDE) | (shift & (side != OUTSIDE))


def _in_plane_rate(bound: PrimitiveSet, seen: Seen) -> Array:
    """Return the rates of the coordinates, (nc,), while body 2 of each joint turns about n at 1 rad/s."""
    turning = cross(np.array([0.0, 0.0, 1.0]), seen.arm) * (bound.side == 2)[:, None]
    return bound.along(bound.gradient_entries(seen.x), turning)


def _not_planar(what: str, axes: Array) -> NotPlanar:
    x, y, z = axes[:, 2].tolist()
    return NotPlanar(f"{what} normal to [{x:.3g}, {y:.3g}, {z:.3g}]")
