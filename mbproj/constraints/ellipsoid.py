"""An ellipsoid on a plane: the height of its lowest point, and slip there.

With its axes b, semi-axes a and the plane's normal n, the ellipsoid reaches h = |(a1 n·b1, a2 n·b2, a3 n·b3)| below its
centre. Its lowest point is at -Σ a² (n·b) b / h from the centre.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from mbproj.arrays import Numbers, dot
from mbproj.constraints.primitive import Primitive
from mbproj.constraints.slip import Slip
from mbproj.dataclass import dataclass

_SEMI_AXES: Mapping[str, str] = MappingProxyType({f"semi_axes_{number}": "m" for number in (1, 2, 3)})


@final
@dataclass(frozen=True)
class EllipsoidHeight(Primitive):
    """C = n·(p2 - p1) - h, in metres: a plane through p1 with the normal n, an ellipsoid with centre p2 and axes b."""

    semi_axes_1: float
    semi_axes_2: float
    semi_axes_3: float

    slots = ("point", "vector", "point", "vector", "vector", "vector")
    rows = 1
    unit = "m"
    parameters: ClassVar[Mapping[str, str]] = _SEMI_AXES

    def value(self, x: Numbers) -> Numbers:
        n, axes = x[..., 1, :], x[..., 3:6, :]
        _, reach = _reach(self, n, axes)
        return (dot(n, x[..., 2, :] - x[..., 0, :]) - reach)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        n, axes = x[..., 1, :], x[..., 3:6, :]
        weighed, reach = _reach(self, n, axes)
        share = weighed / reach[..., None]
        of_normal = x[..., 2, :] - x[..., 0, :] - (share[..., None] * axes).sum(axis=-2)
        of_axes = -share[..., None] * n[..., None, :]
        own = np.stack([-n, of_normal, n], axis=-2)
        return np.concatenate([own, of_axes], axis=-2)[..., None, :, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        n, axes, n_dot, axes_dot = x[..., 1, :], x[..., 3:6, :], x_dot[..., 1, :], x_dot[..., 3:6, :]
        weighed, reach = _reach(self, n, axes)
        rate = dot(n_dot[..., None, :], axes) + dot(n[..., None, :], axes_dot)
        stretch = dot(weighed, rate) / reach
        bend = dot(_squares(self) * rate, rate) + 2.0 * dot(weighed, dot(n_dot[..., None, :], axes_dot))
        moved = 2.0 * dot(n_dot, x_dot[..., 2, :] - x_dot[..., 0, :])
        return (moved - (bend - stretch * stretch) / reach)[..., None]


@final
@dataclass(frozen=True)
class EllipsoidSlip(Slip):
    """The slip of an ellipsoid with the axes x2, y2, z2 on a plane with the normal z1, along x1."""

    semi_axes_1: float
    semi_axes_2: float
    semi_axes_3: float

    parameters: ClassVar[Mapping[str, str]] = _SEMI_AXES

    def contact(self, x: Numbers) -> tuple[Numbers, Numbers]:
        axes = x[..., 5:8, :]
        weighed, reach = _reach(self, x[..., 3, :], axes)
        return -((weighed / reach[..., None])[..., None] * axes).sum(axis=-2), x[..., 1, :]


def _squares(of: EllipsoidHeight | EllipsoidSlip) -> Numbers:
    return np.array([of.semi_axes_1, of.semi_axes_2, of.semi_axes_3]) ** 2


def _reach(of: EllipsoidHeight | EllipsoidSlip, n: Numbers, axes: Numbers) -> tuple[Numbers, Numbers]:
    """Return a² n·b (..., 3) and h (...)."""
    along = dot(n[..., None, :], axes)
    weighed = _squares(of) * along
    return weighed, np.sqrt(dot(weighed, along))
