"""The basic primitives, of two points and vectors (Haug 1989, sect. 9.4)."""

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


@final
@dataclass(frozen=True)
class Distance(Primitive):
    """C = |p2 - p1| in metres, not its square, so that a violation is a length (Haug 1989, Eq. 9.4.10)."""

    slots = ("point", "point")
    rows = 1
    unit = "m"

    def value(self, x: Numbers) -> Numbers:
        line = x[..., 1, :] - x[..., 0, :]
        return np.sqrt(np.sum(line * line, axis=-1))[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        along = (x[..., 1, :] - x[..., 0, :]) / self.value(x)
        return np.stack([-along, along], axis=-2)[..., None, :, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        length = self.value(x)
        along = (x[..., 1, :] - x[..., 0, :]) / length
        rate = x_dot[..., 1, :] - x_dot[..., 0, :]
        stretch = np.sum(along * rate, axis=-1)[..., None]
        return (np.sum(rate * rate, axis=-1)[..., None] - stretch * stretch) / length


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
