"""Bushings of a planar scene: three coordinates in the plane, with their stiffness, in place of six.

Where the relative rotation is about the normal n, its vector is θ n, and the translation has a constant part along n:
the six coordinates are linear in two components and θ, s = B y + s0. Then F in the plane is Bᵀ F, exactly; the joints
bear the rest.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.lanes import one_of
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.forces import Bushings
from mbproj.model.planar.plane import Plane
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class PlanarBushings:
    """B bushings: `origin` (B, 2, 2), and `turn` (B, 2, 2, 2) from the frames to the bodies' planar axes; `stiffness`,
    `damping` (B, 3, 3) and `preload` (B, 3) of two components and an angle; `map` (B, 6, 3) from these to all six."""

    origin: Array
    turn: Array
    stiffness: Array
    damping: Array
    preload: Array
    map: Array


def tilted_bushings(plane: Plane, bushings: Bushings) -> Integers:
    """Return the numbers of the bushings whose frames are not turned against each other about the normal alone."""
    turned = _relative(plane, bushings)
    return np.flatnonzero(np.abs(turned[:, 2, :2]).max(axis=-1, initial=0.0) > THRESHOLDS.rounding)


def bushings_in_plane(plane: Plane, bushings: Bushings) -> PlanarBushings:
    """Return all bushings in the plane; none may be tilted."""
    origin = _reference(plane, bushings) @ bushings.origin[..., None]
    ends = (plane.axes.T @ origin)[..., 0]
    depth = ends[..., 2] + np.append(plane.depth, 0.0)[bushings.body]
    first = np.swapaxes(_frames(plane, bushings)[:, 0], -1, -2) @ plane.axes  # columns e1, e2, n in frame 1
    apart = np.zeros((bushings.size, 6), like=one_of((first, depth)))
    apart[:, :3] = first[..., 2] * (depth[:, 1] - depth[:, 0])[:, None]
    B = np.zeros((bushings.size, 6, 3), like=first)
    B[:, :3, :2], B[:, 3:, 2] = first[..., :2], first[..., 2]
    transposed = np.swapaxes(B, -1, -2)
    left = bushings.preload[..., None] - bushings.stiffness @ apart[..., None]
    relative = _relative(plane, bushings)[:, :2, :2]
    turn = np.stack([np.broadcast_to(np.eye(2), relative.shape), relative], axis=1)
    return PlanarBushings(
        origin=ends[..., :2],
        turn=turn,
        stiffness=transposed @ bushings.stiffness @ B,
        damping=transposed @ bushings.damping @ B,
        preload=(transposed @ left)[..., 0],
        map=B,
    )


def _reference(plane: Plane, bushings: Bushings) -> Array:
    """Return the orientations (B, 2, 3, 3) of the bodies at angle zero."""
    return np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])[bushings.body]


def _frames(plane: Plane, bushings: Bushings) -> Array:
    """Return the orientations (B, 2, 3, 3) of the bushings' frames where the bodies are at angle zero."""
    found: Array = _reference(plane, bushings) @ rotation_matrix(bushings.turn)
    return found


def _relative(plane: Plane, bushings: Bushings) -> Array:
    """Return the rotations (B, 3, 3) from frame 1 to frame 2 where the bodies are at angle zero, in the axes of the
    plane."""
    frames = _frames(plane, bushings)
    found: Array = plane.axes.T @ frames[:, 1] @ np.swapaxes(frames[:, 0], -1, -2) @ plane.axes
    return found
