"""Frames of joints in the axes of their bodies, from the points and axes in the scene; all joints at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mbproj.arrays import Array, cross, like_of, numbers
from mbproj.joints import JOINTS
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.scene.read import Scene
from mbproj.scene.records import GROUND, Joint, Pair
from mbproj.thresholds import THRESHOLDS

#: A body's pose: its centre of mass (3,) and its rotation matrix (3, 3).
Pose = tuple[Array, Array]
#: The points and vectors that a joint binds, in the order of arrays (..., 8, 3).
SYMBOLS = ("p1", "x1", "y1", "z1", "p2", "x2", "y2", "z2")
_NO_AXIS = Pair((0.0, 0.0, 1.0), (0.0, 0.0, 1.0), local=False)


def local_frames(joints: Sequence[Joint], poses: Mapping[str, Pose]) -> Array:
    """Return the vectors `SYMBOLS` of joints that couple no others, (joints, 8, 3), each in the axes of its own body.

    At the scene's pose x1 and x2 have the same direction, so that the joint's angle is zero there. Where the axes do
    not agree yet, the shortest rotation takes one to the other.
    """
    if not joints:
        return np.zeros((0, len(SYMBOLS), 3))
    number = {name: at for at, name in enumerate(poses)}
    bodies = np.array([[number[name] for name in joint.bodies] for joint in joints])
    position, rotation = (numbers(part)[bodies] for part in zip(*poses.values(), strict=True))
    p = _global([joint.points for joint in joints], position, rotation)
    z = _global([joint.axes or _NO_AXIS for joint in joints], np.zeros_like(position), rotation)
    z = z / _length(z)
    frame = np.array([JOINTS[joint.type].frame for joint in joints])
    z[frame == "normal", 1] = z[frame == "normal", 0]
    z1, z2 = z[:, 0], z[:, 1]
    x = np.empty_like(z)
    x[:, 0] = _any_normal(z1)
    x[:, 1] = _parallel_transport(x[:, 0], z1, z2)
    for at, joint in enumerate(joints):
        if joint.frames is not None:
            pair = (joint.frames.first, joint.frames.second)
            turned = numbers(
                [pose @ rotation_matrix(numbers(own)) for pose, own in zip(rotation[at], pair, strict=True)]
            )
            x[at], z[at] = turned[:, :, 0], turned[:, :, 2]
    given = np.array([joint.x_axis is not None for joint in joints])
    if given.any():
        chosen = [joint.x_axis for joint in joints if joint.x_axis is not None]
        direction = _global(chosen, np.zeros_like(position[given]), rotation[given])
        direction[frame[given] == "normal", 1] = direction[frame[given] == "normal", 0]
        direction[frame[given] == "face", 1] = z[given][frame[given] == "face", 0]
        x[given] = _normal_part(direction, z[given])
    own = (frame == "axes") | (frame == "line")
    if own.any():
        x[own] = _normal_part(z[own, ::-1], z[own])
    triad = np.stack([p - position, x, cross(z, x), z], axis=2)
    return (triad @ rotation).reshape(len(joints), len(SYMBOLS), 3)  # as rows: sᵀ A = (Aᵀ s)ᵀ


def poses_of(scene: Scene) -> dict[str, Pose]:
    """Return the pose of each body in the scene, and of the ground."""
    rotation = rotation_matrix(numbers([body.orientation for body in scene.bodies]).reshape(-1, 4))
    poses = {body.name: (numbers(body.position), turn) for body, turn in zip(scene.bodies, rotation, strict=True)}
    return poses | {GROUND: (np.zeros(3), np.eye(3))}


def pose(position: tuple[float, ...], orientation: tuple[float, ...]) -> Pose:
    """A body's pose from its position (3,) and unit Euler parameters (4,)."""
    return numbers(position), rotation_matrix(numbers(orientation))


def _global(pairs: Sequence[Pair], position: Array, rotation: Array) -> Array:
    """Return pairs of points or vectors in global axes, (k, 2, 3)."""
    given = numbers([(pair.first, pair.second) for pair in pairs])
    local = np.array([pair.local for pair in pairs])
    if local.any():
        given = np.array(given, like=like_of(given, position, rotation))
        given[local] = position[local] + (rotation[local] @ given[local][..., None])[..., 0]
    return given


def _length(vectors: Array) -> Array:
    return np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))


def _normal_part(vector: Array, axis: Array) -> Array:
    """Unit vectors of the parts of vectors (..., 3) normal to axes; any normal where there is no such part."""
    part = vector - np.sum(vector * axis, axis=-1, keepdims=True) * axis
    length = _length(part)
    is_inclined = length > THRESHOLDS.same_written
    return np.where(is_inclined, part / np.where(is_inclined, length, 1.0), _any_normal(axis))


def _any_normal(axis: Array) -> Array:
    """Unit vectors normal to axes (..., 3): the normal parts of the coordinate axes that are farthest from them."""
    farthest = np.eye(3)[np.argmin(np.abs(axis), axis=-1)]
    part = farthest - np.sum(farthest * axis, axis=-1, keepdims=True) * axis
    normal: Array = part / _length(part)
    return normal


def _parallel_transport(vector: Array, start: Array, end: Array) -> Array:
    """Vectors (..., 3), normal to unit vectors `start`, by the shortest rotations that take `start` to `end`."""
    axis, cosine = cross(start, end), np.sum(start * end, axis=-1, keepdims=True)
    once = cross(axis, vector)
    back = cosine < -1.0 + THRESHOLDS.rounding
    return np.where(back, vector, vector + once + cross(axis, once) / np.where(back, 1.0, 1.0 + cosine))
