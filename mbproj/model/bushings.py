"""Bushings as arrays: elastic elements between two frames, with six coordinates each."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass

#: The coordinates of a bushing, with their units.
COORDINATES = {"x": "m", "y": "m", "z": "m", "rx": "rad", "ry": "rad", "rz": "rad"}


@dataclass(frozen=True, eq=False)
class Bushings:
    """B bushings, each between a frame in one body and a frame in another.

    `body` (B, 2). Each frame in the axes of its body: `origin` (B, 2, 3), and `turn` (B, 2, 4), the Euler parameters of
    the rotation from frame to body. With s the six coordinates of a bushing, three translations and a rotation vector
    φ:

        F = preload - stiffness s - damping w,   stiffness and damping (B, 6, 6), preload (B, 6).

    For the translations w is s'; for the rotation w is the relative angular velocity, in place of φ', and F is a
    torque. No block of `stiffness` or `damping` couples translations with the rotation.
    """

    body: Integers
    origin: Array
    turn: Array
    stiffness: Array
    damping: Array
    preload: Array

    @classmethod
    def none(cls) -> Bushings:
        """No bushings."""
        turn, square = np.zeros((0, 2, 4)), np.zeros((0, 6, 6))
        return cls(np.zeros((0, 2), dtype=np.intp), np.zeros((0, 2, 3)), turn, square, square, np.zeros((0, 6)))

    @property
    def size(self) -> int:
        """B."""
        return len(self.body)

    @property
    def units(self) -> tuple[str, ...]:
        """The units of all coordinates, one bushing after the other."""
        return (*COORDINATES.values(),) * self.size

    @property
    def turns_freely(self) -> Flags:
        """Whether the relative rotation of its frames has no effect on what a bushing exerts, (B,). Such a bushing
        resists only the distance of the origins, alike in all directions, and the relative angular velocity, alike
        too."""
        rigid, viscous = self.stiffness, self.damping
        alike = _is_isotropic(rigid[:, :3, :3]) & _is_isotropic(viscous[:, 3:, 3:])
        others = (rigid[:, 3:, 3:], viscous[:, :3, :3], self.preload[:, None, :])
        return alike & ~np.any([part.any(axis=(1, 2)) for part in others], axis=0)

    def on_diagonal(self, matrices: Array) -> Array:
        """Return the diagonals of `stiffness` or `damping`, (6B,)."""
        return np.diagonal(matrices, axis1=1, axis2=2).ravel()


def _is_isotropic(matrices: Array) -> Flags:
    """Whether each of the matrices (B, 3, 3) is a multiple of the identity, (B,)."""
    isotropic: Flags = (matrices == matrices[:, :1, :1] * np.eye(3)).all(axis=(1, 2))
    return isotropic
