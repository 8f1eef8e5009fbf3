"""Bushings as arrays: elastic elements between two frames, with six coordinates each."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass

#: The coordinates of a bushing, with their units.
COORDINATES = {"x": "m", "y": "m", "z": "m", "rx": "rad", "ry": "rad", "rz": "rad"}


@dataclass(frozen=True, eq=False)
class Bushings:
    """B bushings, each from a frame in one body to a frame in another.

    `body` (B, 2). The frames in the axes of their bodies: `origin` (B, 2, 3), and `turn` (B, 2, 4), Euler parameters
    from the frame to the body. With s the coordinates of a bushing, three translations and a rotation vector:

        F = preload - stiffness s - damping w,   stiffness and damping (B, 6, 6), preload (B, 6),

    where w is s' of the translations, and for the rotation the relative angular velocity in place of φ'. There F is a
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
        """Whether what a bushing exerts has nothing to do with how far its frames have turned, (B,): it resists their
        angular velocity, or a way between their origins, alike in all directions."""
        rigid, viscous = self.stiffness, self.damping
        alike = _is_isotropic(rigid[:, :3, :3]) & _is_isotropic(viscous[:, 3:, 3:])
        others = (rigid[:, 3:, 3:], viscous[:, :3, :3], self.preload[:, None, :])
        return alike & ~np.any([part.any(axis=(1, 2)) for part in others], axis=0)

    def on_diagonal(self, matrices: Array) -> Array:
        """The diagonals of `stiffness` or `damping`, (6B,)."""
        return np.diagonal(matrices, axis1=1, axis2=2).ravel()


def _is_isotropic(matrices: Array) -> Flags:
    """Whether matrices (B, 3, 3) are multiples of 1, (B,)."""
    isotropic: Flags = (matrices == matrices[:, :1, :1] * np.eye(3)).all(axis=(1, 2))
    return isotropic
