"""Forces and motions of a planar scene: those that act in the plane, and those for which a scene is not planar.

Bushings have three coordinates in the plane, with their stiffness, in place of six. Where the relative rotation is
about the normal n, its vector is θ n, and the translation has a constant part along n: the six coordinates are linear
in two components and θ, s = B y + s0. Then F in the plane is Bᵀ F, exactly; the joints bear the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Integers, like_of
from mbproj.model.channels import Channels
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.forces import Bushings
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.rows import BESIDE, INSIDE, OUTSIDE, Seen, seen_from, sides
from mbproj.model.primitive_set import PrimitiveSet, bind, bindings
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def obstacle_in_plane(system: System, plane: Plane) -> str | None:
    """Return the first load, motion, stop or friction that is no function of the coordinates in the plane, in words;
    None without any.

    Forces out of the plane are no obstacle: the joints bear them.
    """
    locked = np.flatnonzero(coordinates_in_plane(plane, system.motions.joint_coordinate) < 0)
    if len(locked):
        return f"motion '{system.names.motions[locked[0]]}' drives a coordinate out of the plane"
    named = channels_in_plane(plane, system.channels)
    if (named < 0).any():
        name = system.names.coordinates[int(system.channels.index[int(np.argmax(named < 0))])]
        return f"a function names '{name}', a coordinate out of the plane"
    laws, owners = system.forces.laws, [f"force '{name}' acts" for name in system.forces.law_owners]
    leaves = _leaves_plane(system, plane, laws.coordinates, laws.joint_coordinate, owners)
    if leaves is not None:
        return leaves
    leaning = tilted_bushings(plane, system.forces.bushings)
    if len(leaning):
        return f"the frames of force '{system.forces.bushing_names[leaning[0]]}' lean against each other"
    if system.stops is not None:
        owners = [f"the stop of {owner} acts" for owner in system.stops.owners]
        leaves = _leaves_plane(system, plane, system.stops.coordinates, system.stops.joint_coordinate, owners)
        if leaves is not None:
            return leaves
    return _friction_obstacle(system, plane)


def _friction_obstacle(system: System, plane: Plane) -> str | None:
    """Return the friction that depends on forces or moments out of the plane, which the plane does not know; None
    without any. Of the two tangents at a stop one may be normal to the plane."""
    bearings, frictions = system.bearings, system.frictions
    frames = np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])
    if bearings is not None:
        axis = (frames[system.reaction_body[bearings.joint]] @ bearings.axis[..., None])[..., 0]
        tilted = np.abs(axis @ plane.axes[:, 2]) < (1.0 - THRESHOLDS.rounding) * np.linalg.norm(axis, axis=-1)
        leaves = tilted | ((bearings.axial > 0.0) & ~bearings.is_of_rows) | np.isfinite(bearings.length)
        if leaves.any():
            joint = system.names.joints[int(bearings.joint[int(np.argmax(leaves))])]
            return f"friction depends on the load of joint '{joint}' out of the plane"
    if frictions is None:
        return None
    bound, side = (
        bindings(frictions.coordinates),
        sides(frictions.coordinates, _in_plane(system, plane, frictions.coordinates)),
    )
    kept = np.flatnonzero((frictions.partner < 0) | ((side != OUTSIDE) & (side != BESIDE)))
    along = bind([replace(bound[k], owner=at) for at, k in enumerate(kept)])
    owners = [f"{frictions.owners[k]} acts" for k in kept]
    return _leaves_plane(system, plane, along, frictions.joint_coordinate[kept], owners)


def _leaves_plane(
    system: System, plane: Plane, along: PrimitiveSet, joint_coordinate: Integers, owners: Sequence[str]
) -> str | None:
    """Return the first owner whose coordinate is no function of those in the plane, in words; None without any."""
    of_joints = joint_coordinate >= 0
    locked = np.flatnonzero(of_joints & (coordinates_in_plane(plane, joint_coordinate) < 0))
    if len(locked):
        return f"{owners[locked[0]]} along a coordinate out of the plane"
    leaves = ~of_joints & (sides(along, _in_plane(system, plane, along)) != INSIDE)
    for group in along.groups:
        has_axis = "vector" in group.primitive.slots
        for row in group.rows[leaves[group.rows[:, 0]], 0]:
            what = "along an axis out of the plane" if has_axis else "between points at different depths"
            return f"{owners[row]} {what}"
    return None


def coordinates_in_plane(plane: Plane, joint_coordinate: Integers) -> Integers:
    """Return the numbers in `plane.coordinates` of the system's joint coordinates (k,); -1 for one that is constant in
    the plane, and for -1."""
    number = np.full(len(plane.constant) + plane.coordinates.size + 1, -1, dtype=np.intp)
    number[plane.coordinates.source.source] = np.arange(plane.coordinates.size)
    return number[joint_coordinate]


def channels_in_plane(plane: Plane, channels: Channels) -> Integers:
    """Return the numbers of channels (c,) among the states of elements or in `plane.coordinates`; -1 for none."""
    index = channels.index.copy()
    index[~channels.is_state] = coordinates_in_plane(plane, index[~channels.is_state])
    return index


def locals_in_plane(plane: Plane, bound: PrimitiveSet) -> Array:
    """Return the local vectors (S, 2) of a set's attachments in their bodies' planar axes."""
    return _in_axes(plane, bound)[:, :2]


def _in_plane(system: System, plane: Plane, bound: PrimitiveSet) -> Seen:
    """Return a set in plane axes at the plane's reference."""
    depth = np.append(plane.depth, 0.0)
    return seen_from(bound, _in_axes(plane, bound), depth[:, None] * [0.0, 0.0, 1.0], system.length)


def _in_axes(plane: Plane, bound: PrimitiveSet) -> Array:
    reference = np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])
    return (plane.axes.T @ reference[bound.body] @ bound.local[..., None])[..., 0]


def tilted_bushings(plane: Plane, bushings: Bushings) -> Integers:
    """Return the numbers of the bushings whose frames are not turned against each other about the normal alone."""
    turned = _relative(plane, bushings)
    return np.flatnonzero(np.abs(turned[:, 2, :2]).max(axis=-1, initial=0.0) > THRESHOLDS.rounding)


def bushings_in_plane(plane: Plane, bushings: Bushings) -> dict[str, Array]:
    """Return all bushings in the plane, of which none may be tilted, by name: `origin` (B, 2, 2), and `turn` (B, 2, 2,
    2) from the frames to the bodies' planar axes; `stiffness`, `damping` (B, 3, 3) and `preload` (B, 3) of two
    components and an angle; `map` (B, 6, 3) from these to all six."""
    origin = _reference(plane, bushings) @ bushings.origin[..., None]
    ends = (plane.axes.T @ origin)[..., 0]
    depth = ends[..., 2] + np.append(plane.depth, 0.0)[bushings.body]
    first = np.swapaxes(_frames(plane, bushings)[:, 0], -1, -2) @ plane.axes  # columns e1, e2, n in frame 1
    apart = np.zeros((bushings.size, 6), like=like_of(first, depth))
    apart[:, :3] = first[..., 2] * (depth[:, 1] - depth[:, 0])[:, None]
    B = np.zeros((bushings.size, 6, 3), like=first)
    B[:, :3, :2], B[:, 3:, 2] = first[..., :2], first[..., 2]
    transposed = np.swapaxes(B, -1, -2)
    left = bushings.preload[..., None] - bushings.stiffness @ apart[..., None]
    relative = _relative(plane, bushings)[:, :2, :2]
    turn = np.stack([np.broadcast_to(np.eye(2), relative.shape), relative], axis=1)
    return {
        "origin": ends[..., :2],
        "turn": turn,
        "stiffness": transposed @ bushings.stiffness @ B,
        "damping": transposed @ bushings.damping @ B,
        "preload": (transposed @ left)[..., 0],
        "map": B,
    }


def _reference(plane: Plane, bushings: Bushings) -> Array:
    """Return the orientations (B, 2, 3, 3) of the bodies at angle zero."""
    return np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])[bushings.body]


def _frames(plane: Plane, bushings: Bushings) -> Array:
    """Return the orientations (B, 2, 3, 3) of the bushings' frames where the bodies are at angle zero."""
    turned: Array = _reference(plane, bushings) @ rotation_matrix(bushings.turn)
    return turned


def _relative(plane: Plane, bushings: Bushings) -> Array:
    """Return the rotations (B, 3, 3) from frame 1 to frame 2 where the bodies are at angle zero, in the axes of the
    plane."""
    frames = _frames(plane, bushings)
    relative: Array = plane.axes.T @ frames[:, 1] @ np.swapaxes(frames[:, 0], -1, -2) @ plane.axes
    return relative
