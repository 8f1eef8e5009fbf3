"""The height of a wheel's lowest point over a plane."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from mbproj.arrays import Numbers, cross, dot
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass


@final
@dataclass(frozen=True)
class WheelHeight(Primitive):
    """C = n·(p2 - p1) - R |n × a|, in metres: a plane through p1 with the normal n, a wheel with centre p2 and axis a.

    Its lowest point is R |n × a| below the centre.
    """

    radius: float

    slots = ("point", "vector", "point", "vector")
    rows = 1
    unit = "m"
    parameters: ClassVar[Mapping[str, str]] = MappingProxyType({"radius": "m"})

    def value(self, x: Numbers) -> Numbers:
        _, upright = _uprightness(x)
        return (dot(x[..., 1, :], x[..., 2, :] - x[..., 0, :]) - self.radius * upright)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        n, a = x[..., 1, :], x[..., 3, :]
        across, upright = _uprightness(x)
        unit = self.radius * across / upright[..., None]
        of_normal = x[..., 2, :] - x[..., 0, :] - cross(a, unit)
        return np.stack([-n, of_normal, n, -cross(unit, n)], axis=-2)[..., None, :, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        across, upright = _uprightness(x)
        n_dot, a_dot = x_dot[..., 1, :], x_dot[..., 3, :]
        rate = cross(n_dot, x[..., 3, :]) + cross(x[..., 1, :], a_dot)
        bend = dot(rate, rate) + 2.0 * dot(across, cross(n_dot, a_dot)) - (dot(across, rate) / upright) ** 2
        moved = 2.0 * dot(n_dot, x_dot[..., 2, :] - x_dot[..., 0, :])
        return (moved - self.radius * bend / upright)[..., None]


def _uprightness(x: Numbers) -> tuple[Numbers, Numbers]:
    """Return n × a and its length."""
    across = cross(x[..., 1, :], x[..., 3, :])
    return across, np.sqrt(dot(across, across))
