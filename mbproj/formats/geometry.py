"""Rotations of other formats as matrices whose columns are the turned axes, and numbers in attributes."""

from __future__ import annotations

import math

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem


@dataclass(frozen=True, eq=False)
class Pose:
    """A place (3,) and axes (3, 3) in those of another frame."""

    position: Array
    rotation: Array

    def then(self, inner: Pose) -> Pose:
        """A pose that is given in this frame, in the frame that this one is given in."""
        return Pose(self.position + self.rotation @ inner.position, self.rotation @ inner.rotation)

    def inverse(self) -> Pose:
        """The outer frame as this one sees it."""
        return Pose(-self.rotation.T @ self.position, self.rotation.T)


IDENTITY = Pose(np.zeros(3), np.eye(3))


def from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """URDF's and SDF's fixed axes: a roll about x, then a pitch about y, then a yaw about z."""
    return (
        turn(np.array([0.0, 0.0, 1.0]), yaw)
        @ turn(np.array([0.0, 1.0, 0.0]), pitch)
        @ turn(np.array([1.0, 0.0, 0.0]), roll)
    )


def to_rpy(rotation: Array) -> Array:
    """Roll, pitch and yaw of a matrix, with a roll of zero where the pitch is a right angle."""
    sine = -rotation[2, 0]
    level = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(sine, level)
    if level < 1e-12:
        return np.array([0.0, pitch, math.atan2(-rotation[0, 1], rotation[1, 1])])
    return np.array([math.atan2(rotation[2, 1], rotation[2, 2]), pitch, math.atan2(rotation[1, 0], rotation[0, 0])])


def turn(axis: Array, angle: float) -> Array:
    """The rotation about a unit vector (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + 2.0 * math.sin(angle / 2.0) ** 2 * (cross @ cross))


def from_quaternion(quaternion: Array) -> Array:
    """The rotation of a quaternion (w, x, y, z)."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def unit(vector: Array) -> Array:
    """The vector over its length."""
    return np.asarray(vector / np.linalg.norm(vector))


def numbers(text: str, count: int, place: Place, what: str) -> Array:
    """So many finite numbers in a text. Raises InputError at `place`."""
    try:
        found = np.array([float(part) for part in text.split()])
    except ValueError:
        found = np.zeros(0)
    if len(found) != count or not np.isfinite(found).all():
        shown = text if len(text) <= 60 else f"{text[:57]}..."
        takes = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(Problem(f"{what} takes {takes}, found '{shown}'", place, "write it as in '0 0 1'"))
    return found
