"""Rotations of other formats as matrices whose columns are the turned axes, numbers in texts, inertias."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.base.text import plain_number
from mbproj.scene.fields.rotations import from_axis_angle, from_euler, from_matrix, impossible, to_matrix


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame: its origin (3,) and the matrix (3, 3) of its axes, both in another frame."""

    position: Array
    rotation: Array

    def then(self, inner: Frame) -> Frame:
        """The pose `inner`, given in this frame, in the frame in which this frame is given."""
        return Frame(self.position + self.rotation @ inner.position, self.rotation @ inner.rotation)

    def inverse(self) -> Frame:
        """The pose in this frame of the frame in which it is given."""
        return Frame(-self.rotation.T @ self.position, self.rotation.T)


IDENTITY = Frame(np.zeros(3), np.eye(3))


def from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """URDF's fixed axes: a roll about x, then a pitch about y, then a yaw about z."""
    return np.array(to_matrix(from_euler((yaw, pitch, roll), "zyx")))


def turn(axis: Array, angle: float) -> Array:
    """The rotation about a unit vector."""
    return np.array(to_matrix(from_axis_angle(tuple(axis.tolist()), angle)))


def from_quaternion(quaternion: Array) -> Array:
    """The rotation of a quaternion (w, x, y, z) of any length."""
    return np.array(to_matrix(tuple(unit(quaternion).tolist())))


def unit(vector: Array) -> Array:
    """The vector divided by its length."""
    return np.asarray(vector / np.linalg.norm(vector))


def direction(vector: Array, place: Place, what: str) -> Array:
    """The unit vector along a vector that a model gives. Raises InputError at `place` where its length is zero, or so
    small that its square is."""
    if not np.linalg.norm(vector) > 0.0:
        raise InputError(Problem(f"{what} has no direction", place, "give a vector of length 1"))
    return unit(vector)


#: The largest number of a model, but for limits: products of three are finite.
LARGEST = 1e100


def numbers(text: str, count: int, place: Place, what: str) -> Array:
    """The `count` finite numbers in a text. Raises InputError at `place` where there are fewer or more, or where one is
    beyond LARGEST."""
    try:
        values = np.array([plain_number(part) for part in text.split()])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count or not (np.abs(values) <= LARGEST).all():
        shown = text if len(text) <= 60 else f"{text[:57]}..."
        takes = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(Problem(f"{what} takes {takes}, found '{shown}'", place, "write it as in '0 0 1'"))
    return values


def limit(text: str, place: Place, what: str) -> float:
    """The number of a limit, which may be infinite or as large as a number can be. Raises InputError where it is
    none."""
    try:
        value = plain_number(text)
    except ValueError:
        value = np.nan
    return value if abs(value) > LARGEST else float(numbers(text, 1, place, what)[0])


def check_inertia(mass: float, inertia: Array, at_mass: Place, at_inertia: Place) -> None:
    """Raises InputError where no body can have this mass and inertia tensor."""
    if mass < 0.0:
        raise InputError(Problem(f"the mass is negative: {mass:g} kg", at_mass, "give one that is not"))
    why = impossible(tuple(map(tuple, inertia.tolist())))  # type: ignore[arg-type]
    if why:
        raise InputError(Problem(f"the inertia {why}", at_inertia, "correct the inertia about the centre of mass"))


# --- The keys of a scene for a place and an orientation on a body -----------------------------------------------------


def quaternion(rotation: Array) -> Array:
    """The unit Euler parameters (4,) of a rotation matrix."""
    return np.array(from_matrix(tuple(map(tuple, rotation.tolist()))))  # type: ignore[arg-type]


def placed(position: Array, rotation: Array) -> dict[str, Any]:
    """The keys `position` and `orientation`; one that changes nothing is left out."""
    keys: dict[str, Any] = {}
    if np.abs(position).max() > 1e-15:
        keys["position"] = np.round(position, 9)
    turned = quaternion(rotation)
    if np.abs(turned[1:]).max() > 1e-9:
        keys["orientation"] = {"quaternion": np.round(turned, 9)}
    return keys
