"""A joint's two frames, from the points and axes that the scene gives to what each body carries."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.arrays import Array, cross
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.scene.records import Joint, Pair
from mbproj.thresholds import THRESHOLDS

#: A body's pose: its centre of mass (3,) and its rotation matrix (3, 3).
Pose = tuple[Array, Array]


def local_frames(joint: Joint, frame: str, poses: Mapping[str, Pose]) -> Mapping[str, Array]:
    """The joint's symbols p1, x1, y1, z1, p2, x2, y2, z2, each (3,) in the axes of its own body.

    `frame` is that of the joint type. At the scene's pose x1 and x2 are the same direction (turned as little as
    possible where the axes do not agree yet), which makes it the zero of the joint's angle.
    """
    first, second = (poses[name] for name in joint.bodies)
    p1, p2 = _points(joint.points, first, second)
    z1, z2 = _directions(joint.axes, first, second) if joint.axes else (np.array([0.0, 0, 1]), np.array([0.0, 0, 1]))
    if frame == "normal":
        z2 = z1
    if frame == "axes":
        x1, x2 = _normal_part(z2, z1), _normal_part(z1, z2)
    else:
        x1 = _any_normal(z1)
        x2 = _turned(x1, z1, z2)
    symbols = {"p1": first[1].T @ (p1 - first[0]), "p2": second[1].T @ (p2 - second[0])}
    for side, x, z, (_, rotation) in (("1", x1, z1, first), ("2", x2, z2, second)):
        triad = {"x": x, "y": cross(z, x), "z": z}
        symbols.update({name + side: rotation.T @ vector for name, vector in triad.items()})
    return symbols


def pose(position: tuple[float, ...], orientation: tuple[float, ...]) -> Pose:
    """A body's pose from its position (3,) and unit Euler parameters (4,)."""
    return np.array(position), rotation_matrix(np.array(orientation))


def _points(pair: Pair, first: Pose, second: Pose) -> tuple[Array, Array]:
    p1, p2 = np.array(pair.first), np.array(pair.second)
    return (first[0] + first[1] @ p1, second[0] + second[1] @ p2) if pair.local else (p1, p2)


def _directions(pair: Pair, first: Pose, second: Pose) -> tuple[Array, Array]:
    z1, z2 = _unit(np.array(pair.first)), _unit(np.array(pair.second))
    return (first[1] @ z1, second[1] @ z2) if pair.local else (z1, z2)


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def _normal_part(vector: Array, axis: Array) -> Array:
    """The unit vector of the part of `vector` normal to `axis`; any normal where there is no such part."""
    part = vector - (vector @ axis) * axis
    return _unit(part) if np.linalg.norm(part) > THRESHOLDS.no_normal_part else _any_normal(axis)


def _any_normal(axis: Array) -> Array:
    """A unit vector normal to `axis`: the normal part of the coordinate axis that is farthest from it."""
    farthest = np.zeros(3)
    farthest[np.argmin(np.abs(axis))] = 1.0
    return _unit(farthest - (farthest @ axis) * axis)


def _turned(vector: Array, start: Array, end: Array) -> Array:
    """`vector`, normal to the unit vector `start`, by the shortest rotation that takes `start` to `end`."""
    axis, cosine = cross(start, end), float(start @ end)
    if cosine < -1.0 + THRESHOLDS.half_turn or not axis.any():
        return vector
    once: Array = cross(axis, vector)
    return vector + once + cross(axis, once) / (1.0 + cosine)
