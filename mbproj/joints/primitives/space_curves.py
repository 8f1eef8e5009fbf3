"""A curve in space of one body and a point of another: the point's distances beside the curve, and its place along
it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, TypeVar, final

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers, dot
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Line, Primitive
from mbproj.joints.primitives.plane_curves import FREE, MOST_KEPT


class SpaceCurveShape(Protocol):
    """Interface of a curve of pieces, each of which continues beyond its ends."""

    @property
    def knots(self) -> object:
        """The program whose switches are the ends of the pieces."""

    @property
    def contacts(self) -> dict[tuple[object, ...], SpaceFoot]:
        """The contacts of the last points."""

    @property
    def axes(self) -> Array:
        """A direction normal to the tangents of each piece, (n, 3)."""

    def foot(self, d: Numbers, held: int = FREE) -> tuple[Numbers, Integers]:
        """Return the parameters of the places nearest to points d (..., 3), which may be complex, and their pieces."""

    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """Return the point and its first three derivatives by the parameter, (4, 3, ...)."""

    def length_at(self, s: Numbers, piece: Integers) -> Numbers:
        """Return the arc length from the beginning."""


class SpaceFoot(NamedTuple):
    """The foot s of d, its piece, the line from there to d, and the curve's derivatives, (..., 3) each."""

    s: Numbers
    piece: Integers
    line: Numbers
    c1: Numbers
    c2: Numbers
    c3: Numbers

    @property
    def denominator(self) -> Numbers:
        """|c'|² - c''·line, by which s' = c'·d' / left."""
        return np.asarray(dot(self.c1, self.c1) - dot(self.c2, self.line))


Own = TypeVar("Own", bound="InSpace")


@dataclass(frozen=True)
class InSpace(Primitive):
    """A primitive that depends on the foot of d = (x·ℓ, y·ℓ, z·ℓ), ℓ = p2 - p1, on a curve whose axes are x, y and z.
    `piece`: the piece on which the foot is held, or FREE."""

    curve: SpaceCurveShape
    piece: int = FREE

    slots = ("vector", "vector", "vector", "point", "point")
    rows = 1
    follows = "space curve"
    off_plane = "follows a curve in space"
    unit: ClassVar[Literal["m"]] = "m"

    @classmethod
    def lines(cls, curve: Any) -> tuple[Line, ...]:
        """Return the curve."""
        return (Line(curve.places.point, curve.closed),)

    def on_piece(self: Own, piece: int) -> Own:
        """Return the primitive with this piece held."""
        return replace(self, piece=piece)

    def foot(self, x: Numbers) -> Numbers:
        """Return the parameter of the foot, (..., k)."""
        return self.contact(x).s

    def contact(self, x: Numbers) -> SpaceFoot:
        """Return the foot. The last contacts are cached, because both rows, their gradients and their curvatures at one
        pose use them."""
        line = x[..., 4, :] - x[..., 3, :]
        d = np.stack([dot(x[..., k, :], line) for k in range(3)], axis=-1)
        if d.size > 3 * MOST_KEPT:
            return self._contact(d)
        key, seen = (self.piece, d.dtype.char, d.shape, d.tobytes()), self.curve.contacts
        if key not in seen:
            if len(seen) >= MOST_KEPT:
                seen.clear()
            seen[key] = self._contact(d)
        return seen[key]

    def _contact(self, d: Numbers) -> SpaceFoot:
        s, piece = self.curve.foot(d, self.piece)
        c, c1, c2, c3 = np.moveaxis(self.curve.derivatives(s, piece), 1, -1)
        return SpaceFoot(s, piece, d - c, c1, c2, c3)

    @staticmethod
    def _gradient_along(x: Numbers, e: Numbers) -> Numbers:
        """Return ∂(e·d)/∂x with e (..., k, 3) fixed, (..., k, 1, 5, 3)."""
        line = x[..., 4, :] - x[..., 3, :]
        across = (e[..., None] * x[..., :3, :]).sum(axis=-2)
        parts = [*(e[..., k, None] * line for k in range(3)), -across, across]
        return np.stack(parts, axis=-2)[..., None, :, :]

    @staticmethod
    def _rates(x: Numbers, x_dot: Numbers) -> tuple[Numbers, Numbers]:
        """Return d', and the part of d'' without second derivatives of x, (..., k, 3)."""
        line, line_dot = x[..., 4, :] - x[..., 3, :], x_dot[..., 4, :] - x_dot[..., 3, :]
        rate = [dot(x_dot[..., k, :], line) + dot(x[..., k, :], line_dot) for k in range(3)]
        bias = [2.0 * dot(x_dot[..., k, :], line_dot) for k in range(3)]
        return np.stack(rate, axis=-1), np.stack(bias, axis=-1)

    @staticmethod
    def _moves(at: SpaceFoot, rate: Numbers, bias: Numbers) -> tuple[Numbers, Numbers]:
        """Return s', and the part of s'' without second derivatives of x."""
        s_dot = dot(at.c1, rate) / at.denominator
        tangential = dot(at.c1, bias) + 2.0 * s_dot * dot(at.c2, rate)
        tangential = tangential + s_dot**2 * (dot(at.c3, at.line) - 3.0 * dot(at.c1, at.c2))
        return s_dot, tangential / at.denominator


@dataclass(frozen=True)
class BesideCurve(InSpace):
    """C = e·(d - c) in metres. e is one of two normals of the curve at the foot: N / |N| with N = a × c', or t × N /
    |N|; a is the direction of the piece in `axes`."""

    is_second: ClassVar[bool]

    def value(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        return np.asarray(dot(self._normals(at)[0], at.line))[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        e, e1, _ = self._normals(at)
        return self._gradient_along(x, e + (dot(e1, at.line) / at.denominator)[..., None] * at.c1)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at = self.contact(x)
        (rate, bias), (e, e1, e2) = self._rates(x, x_dot), self._normals(at)
        s_dot, s_bias = self._moves(at, rate, bias)
        across = dot(e, bias) + 2.0 * s_dot * dot(e1, rate) + s_bias * dot(e1, at.line)
        return np.asarray(across + s_dot**2 * (dot(e2, at.line) - dot(e1, at.c1)))[..., None]

    def _normals(self, at: SpaceFoot) -> tuple[Numbers, Numbers, Numbers]:
        """Return the normal e and its two derivatives by s."""
        a = self.curve.axes[at.piece]
        first = _unit(*(_cross(a, each) for each in (at.c1, at.c2, at.c3)))
        if not self.is_second:
            return first
        (t, t1, t2), (e, e1, e2) = _unit(at.c1, at.c2, at.c3), first
        bent = _cross(t2, e) + 2.0 * _cross(t1, e1) + _cross(t, e2)
        return _cross(t, e), _cross(t1, e) + _cross(t, e1), bent


@final
@dataclass(frozen=True)
class BesideFirst(BesideCurve):
    """The component along the first normal. Feet of this row are held on pieces."""

    is_second = False
    is_held = True


@final
@dataclass(frozen=True)
class BesideSecond(BesideCurve):
    """The component along the second normal."""

    is_second = True


@final
@dataclass(frozen=True)
class SpaceArc(InSpace):
    """The arc length σ of the foot along the curve from its beginning, in metres."""

    def value(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        return self.curve.length_at(at.s, at.piece)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        return self._gradient_along(x, (np.sqrt(dot(at.c1, at.c1)) / at.denominator)[..., None] * at.c1)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at = self.contact(x)
        s_dot, s_bias = self._moves(at, *self._rates(x, x_dot))
        speed = np.sqrt(dot(at.c1, at.c1))
        return np.asarray(speed * s_bias + dot(at.c1, at.c2) / speed * s_dot**2)[..., None]


def _cross(one: Numbers, other: Numbers) -> Numbers:
    """Return the vector product of (..., 3), which may be complex."""
    x, y, z = (one[..., k] for k in range(3))
    u, v, w = (other[..., k] for k in range(3))
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)


def _unit(n: Numbers, n1: Numbers, n2: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Return n / |n| and its two derivatives, from those of n."""
    size = np.sqrt(dot(n, n))[..., None]
    e = n / size
    grows = np.asarray(dot(e, n1))[..., None]
    e1 = (n1 - e * grows) / size
    bends = np.asarray(dot(e1, n1) + dot(e, n2))[..., None]
    return e, e1, (n2 - 2.0 * e1 * grows - e * bends) / size
