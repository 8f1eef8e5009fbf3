"""Slip: a component of the relative velocity of two bodies at their point of contact.

At the point P of contact the body 2 with the triad x2, y2, z2 and the point p2 moves at p2' + ω2 × (P - p2). The rates
of its vectors give its rotation: ω2 × (P - p2) = Σ ((P - p2)·b) b' over b = x2, y2, z2; likewise body 1. A row of slip
is

    e·(p2' + Σ ((P - p2)·b) b' - p1' - Σ ((P - p1)·c) c') = 0,      c = x1, y1, z1,


with P and the direction e functions of the pose. It is not the rate of any function of the pose (Neimark and Fufaev
1972).

It is a row at velocity level: A(x) x' = 0, where A is the gradient of no function.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from mbproj.base.arrays import Numbers, cross, dot
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Primitive

#: A complex step, whose square vanishes beside 1.
STEP = 1e-100


class VelocityRow(Primitive):
    """A row that is not integrable, in m/s. Its value is 0: the projection of a position requires A δ = 0 of it."""

    rows = 1
    unit = "m"
    integrable = False

    def value(self, x: Numbers) -> Numbers:
        return np.zeros((*x.shape[:-2], 1), dtype=x.dtype)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return A' x': the complex step of the gradient along the motion, exact to round-off (Squire and Trapp
        1998)."""
        bent = self.gradient(x + 1j * STEP * x_dot).imag / STEP
        return np.asarray((bent * x_dot[..., None, :, :]).sum(axis=(-2, -1)))


class Slip(VelocityRow):
    """The slip of body 2 against body 1, by their points and triads."""

    off_plane = "rolls out of the plane"
    slots = ("point", "vector", "vector", "vector", "point", "vector", "vector", "vector")

    @abstractmethod
    def contact(self, x: Numbers) -> tuple[Numbers, Numbers]:
        """Return P - p2 and e, (..., 3) each."""

    def gradient(self, x: Numbers) -> Numbers:
        arm, e = self.contact(x)
        away = x[..., 4, :] + arm - x[..., 0, :]
        parts = [-e, *(-dot(away, x[..., c, :])[..., None] * e for c in (1, 2, 3))]
        parts += [e, *(dot(arm, x[..., b, :])[..., None] * e for b in (5, 6, 7))]
        return np.stack(parts, axis=-2)[..., None, :, :]


class WheelSlip(Slip):
    """The slip of a wheel with the axis z2 on a plane with the normal z1, at its lowest point."""

    radius: float

    parameters: ClassVar[Mapping[str, str]] = MappingProxyType({"radius": "m"})

    def heading(self, x: Numbers) -> tuple[Numbers, Numbers]:
        """Return P - p2, and the direction z2 × z1 in which the wheel rolls where it turns about z2."""
        axis = x[..., 7, :]
        along = cross(axis, x[..., 3, :])
        along = along / np.sqrt(dot(along, along))[..., None]
        return self.radius * cross(axis, along), along


@final
@dataclass(frozen=True)
class WheelSlipAlong(WheelSlip):
    """The slip along the direction in which the wheel rolls."""

    radius: float

    def contact(self, x: Numbers) -> tuple[Numbers, Numbers]:
        return self.heading(x)


@final
@dataclass(frozen=True)
class WheelSlipAcross(WheelSlip):
    """The slip across that direction, in the plane."""

    radius: float

    def contact(self, x: Numbers) -> tuple[Numbers, Numbers]:
        arm, along = self.heading(x)
        return arm, cross(x[..., 3, :], along)


@final
@dataclass(frozen=True)
class BallSlip(Slip):
    """The slip of a ball on a plane with the normal z1, along x1."""

    radius: float

    parameters: ClassVar[Mapping[str, str]] = MappingProxyType({"radius": "m"})

    def contact(self, x: Numbers) -> tuple[Numbers, Numbers]:
        return -self.radius * x[..., 3, :], x[..., 1, :]


@final
@dataclass(frozen=True)
class EdgeSlip(Slip):
    """The slip of the point p2 along z2, which is normal to a blade."""

    off_plane = "slides on an edge that is tilted"

    def contact(self, x: Numbers) -> tuple[Numbers, Numbers]:
        return np.zeros_like(x[..., 4, :]), x[..., 7, :]


# --- The height of a wheel's lowest point over a plane ----------------------------------------------------------------


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
    off_plane = "rolls out of the plane"
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


# --- An ellipsoid on a plane ------------------------------------------------------------------------------------------
# The height of its lowest point, and slip there.
# With its axes b, semi-axes a and the plane's normal n, the ellipsoid reaches h = |(a1 n·b1, a2 n·b2, a3 n·b3)| below
# its centre. Its lowest point is at -Σ a² (n·b) b / h from the centre.


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
    off_plane = "rolls out of the plane"
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
        of_points = np.stack([-n, of_normal, n], axis=-2)
        return np.concatenate([of_points, of_axes], axis=-2)[..., None, :, :]

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
