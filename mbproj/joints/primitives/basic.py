"""The base of constraint primitives: a scalar or vector function of a few points and vectors fixed in two bodies."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Literal, NamedTuple, final

import numpy as np

from mbproj.base.arrays import Array, Numbers, dot
from mbproj.base.dataclass import dataclass

SlotKind = Literal["point", "vector"]


class Line(NamedTuple):
    """A line through points (k, 3) in m, and whether it is closed."""

    points: Array
    closed: bool


class Primitive(ABC):
    """C(x) of the points and vectors x that it binds, its gradient, and its curvature along a motion.

    The arguments are the global points and vectors of k instances at once, `x` of shape (..., k, s, 3), where s is the
    number of `slots`. How x depends on the coordinates is not known here, so full, reduced and planar coordinates share
    this one definition. Data of a primitive beside x are the fields of its class. Fields that are numbers are its
    `parameters`, each in an SI unit; a joint's parameters have the same names. Differentiated twice along a motion
    x(t),

        C' = rate(x, x') = gradient(x)·x',    C'' = rate(x, x'') + curvature(x, x').


    The gradient g of a primitive that is not `integrable`, as in rolling without slip, is not the gradient of a
    function: ∂g/∂x is not symmetric, and does not follow from the curvature.
    """

    rows: ClassVar[int]
    #: The things beside points and vectors on which the primitive depends: a plane curve, two of them, a space curve, a
    #: rope, or coordinates.
    follows: ClassVar[Literal["", "curve", "two curves", "space curve", "rope", "coordinates"]] = ""
    integrable: ClassVar[bool] = True
    #: The name in the kernel, where that is another primitive's, which differs by its slots.
    in_kernel: ClassVar[str] = ""
    #: Whether it is a distance from a curve: its foot, the nearest point, stays on one piece of the curve in a step.
    is_held: ClassVar[bool] = False
    #: Whether it acts in a plane where all its vectors are in it. Where it has no planar form: what it does, in words
    #: that follow its joint's name.
    acts_in_plane: ClassVar[bool] = False
    off_plane: ClassVar[str] = "has no planar form"
    parameters: ClassVar[Mapping[str, str]] = MappingProxyType({})

    @property
    @abstractmethod
    def slots(self) -> tuple[SlotKind, ...]:
        """The kind of each slot, point or vector; for most primitives a constant."""

    @property
    @abstractmethod
    def unit(self) -> Literal["m", "rad"]:
        """The unit of the rows; for most primitives a constant."""

    @classmethod
    def lines(cls, curve: Any) -> tuple[Line, ...]:
        """Return the lines by which pictures show what it follows, in its frame; none where they show a plane curve."""
        return ()

    @abstractmethod
    def value(self, x: Numbers) -> Numbers:
        """Return C, shape (..., k, rows), in `unit`."""

    @abstractmethod
    def gradient(self, x: Numbers) -> Numbers:
        """Return ∂C/∂x, shape (..., k, rows, s, 3)."""

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return gradient(x)·x', shape (..., k, rows)."""
        terms: Numbers = self.gradient(x) * x_dot[..., None, :, :]
        return terms.sum(axis=(-2, -1))

    def forces(self, x: Numbers, multipliers: Numbers) -> Numbers:
        """Return gradient(x)ᵀλ, shape (..., k, s, 3), for multipliers (..., k, rows)."""
        terms: Numbers = self.gradient(x) * multipliers[..., None, None]
        return terms.sum(axis=-3)

    @abstractmethod
    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return x'ᵀ (∂²C/∂x²) x', shape (..., k, rows)."""


# --- The basic primitives, of points and vectors ----------------------------------------------------------------------
# Haug 1989, sect. 9.4; and the angle of a vector in a plane.


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
    off_plane = "keeps a distance between points at different depths"

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


@final
@dataclass(frozen=True)
class Angle(Primitive):
    """φ = atan2(u·y, u·x): the angle of u about x × y, from x towards y, in radians within (-π, π].

    x and y are fixed in one body and u in the other (Haug 1989, sect. 9.2.6: relative rotation).
    """

    slots = ("vector", "vector", "vector")
    rows = 1
    unit = "rad"
    acts_in_plane = True
    off_plane = "holds an angle that is not in the plane"

    def value(self, x: Numbers) -> Numbers:
        cosine, sine = _cosine_and_sine(x)
        # The derivative of arctan2 by the complex step needs this form: numpy.arctan2 takes real arguments only.
        real = np.arctan2(sine.real, cosine.real)
        if not np.iscomplexobj(x):
            return real[..., None]
        rate = (cosine.real * sine.imag - sine.real * cosine.imag) / (cosine.real**2 + sine.real**2)
        return (real + 1j * rate)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        cosine, sine = _cosine_and_sine(x)
        radius2 = cosine**2 + sine**2
        s, c = (sine / radius2)[..., None], (cosine / radius2)[..., None]
        first, second, u = x[..., 0, :], x[..., 1, :], x[..., 2, :]
        return np.stack([-s * u, c * u, c * second - s * first], axis=-2)[..., None, :, :]

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        cosine, sine = _cosine_and_sine(x)
        cosine_dot, sine_dot = _their_rates(x, x_dot)
        return ((cosine * sine_dot - sine * cosine_dot) / (cosine**2 + sine**2))[..., None]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        cosine, sine = _cosine_and_sine(x)
        cosine_dot, sine_dot = _their_rates(x, x_dot)
        radius2 = cosine**2 + sine**2
        first_dot, second_dot, u_dot = x_dot[..., 0, :], x_dot[..., 1, :], x_dot[..., 2, :]
        bend = 2.0 * (cosine * dot(u_dot, second_dot) - sine * dot(u_dot, first_dot)) / radius2
        rate = (cosine * sine_dot - sine * cosine_dot) / radius2
        stretch = (cosine * cosine_dot + sine * sine_dot) / radius2
        return (bend - 2.0 * rate * stretch)[..., None]


def _cosine_and_sine(x: Numbers) -> tuple[Numbers, Numbers]:
    return dot(x[..., 2, :], x[..., 0, :]), dot(x[..., 2, :], x[..., 1, :])


def _their_rates(x: Numbers, x_dot: Numbers) -> tuple[Numbers, Numbers]:
    (first, second, u), (first_dot, second_dot, u_dot) = ([each[..., k, :] for k in range(3)] for each in (x, x_dot))
    return dot(u_dot, first) + dot(u, first_dot), dot(u_dot, second) + dot(u, second_dot)
