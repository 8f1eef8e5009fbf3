"""Two vectors stay perpendicular: a·b = 0."""

from __future__ import annotations

from typing import final

from mbproj.arrays import Numbers, dot
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass


@final
@dataclass(frozen=True)
class Perpendicular(Primitive):
    """C = a·b of two unit vectors, in radians to first order (Haug 1989, Eq. 9.4.2: dot-1)."""

    slots = ("vector", "vector")
    rows = 1
    unit = "rad"

    def value(self, x: Numbers) -> Numbers:
        return dot(x[..., 0, :], x[..., 1, :])[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        return x[..., None, ::-1, :]

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return (dot(x_dot[..., 0, :], x[..., 1, :]) + dot(x[..., 0, :], x_dot[..., 1, :]))[..., None]

    def forces(self, x: Numbers, multipliers: Numbers) -> Numbers:
        return x[..., ::-1, :] * multipliers[..., None]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return 2.0 * self.value(x_dot)
