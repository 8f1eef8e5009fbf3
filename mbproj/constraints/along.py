"""The component of the line between two points along a vector."""

from __future__ import annotations

from typing import final

import numpy as np

from mbproj.arrays import Numbers, dot
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass


@final
@dataclass(frozen=True)
class Along(Primitive):
    """C = a·(p2 - p1) with a unit vector a, in metres (Haug 1989, Eq. 9.4.7: dot-2).

    As a constraint it keeps the line perpendicular to a; as a coordinate it is the displacement along a.
    """

    slots = ("vector", "point", "point")
    rows = 1
    unit = "m"

    def value(self, x: Numbers) -> Numbers:
        return dot(x[..., 0, :], x[..., 2, :] - x[..., 1, :])[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        a, line = x[..., 0, :], x[..., 2, :] - x[..., 1, :]
        return np.stack([line, -a, a], axis=-2)[..., None, :, :]

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        line, line_dot = x[..., 2, :] - x[..., 1, :], x_dot[..., 2, :] - x_dot[..., 1, :]
        return (dot(x_dot[..., 0, :], line) + dot(x[..., 0, :], line_dot))[..., None]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return 2.0 * self.value(x_dot)
