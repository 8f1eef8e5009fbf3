"""Bushings as arrays: elastic elements between two frames, with six coordinates each."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass

#: The coordinates of a bushing, with their units.
COORDINATES = {"x": "m", "y": "m", "z": "m", "rx": "rad", "ry": "rad", "rz": "rad"}


@dataclass(frozen=True, eq=False)
class Bushings:
    """B bushings, each from a frame in one body to a frame in another.

    `body` (B, 2). The frames in the axes of their bodies: `origin` (B, 2, 3), and `turn` (B, 2, 4), Euler parameters
    from the frame to the body. With s the coordinates of a bushing, three translations and a rotation vector:

        F = preload - stiffness s - damping s',   stiffness and damping (B, 6, 6), preload (B, 6)
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

    def on_diagonal(self, matrices: Array) -> Array:
        """The diagonals of `stiffness` or `damping`, (6B,)."""
        return np.diagonal(matrices, axis1=1, axis2=2).ravel()
