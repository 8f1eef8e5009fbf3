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

from mbproj.arrays import Numbers, cross, dot
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass

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

    def contact(self, x: Numbers) -> tuple[Numbers, Numbers]:
        return np.zeros_like(x[..., 4, :]), x[..., 7, :]
