"""Two points coincide: p2 - p1 = 0."""

from __future__ import annotations

from typing import final

import numpy as np

from mbproj.arrays import Numbers
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass

_GRADIENT = np.stack([-np.eye(3), np.eye(3)], axis=1)


@final
@dataclass(frozen=True)
class Coincident(Primitive):
    """C = p2 - p1, three rows in metres (Haug 1989, Eq. 9.4.9: the spherical constraint)."""

    slots = ("point", "point")
    rows = 3
    unit = "m"

    def value(self, x: Numbers) -> Numbers:
        return x[..., 1, :] - x[..., 0, :]

    def gradient(self, x: Numbers) -> Numbers:
        return np.broadcast_to(_GRADIENT, (*x.shape[:-2], 3, 2, 3))

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return self.value(x_dot)

    def forces(self, x: Numbers, multipliers: Numbers) -> Numbers:
        return np.stack([-multipliers, multipliers], axis=-2)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return np.zeros((*x.shape[:-2], 3), dtype=x_dot.dtype)
