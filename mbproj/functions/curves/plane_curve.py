"""Plane curves: their places, the foot of a point, and the arc length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from math import pi
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dataclass import dataclass
from mbproj.functions.curves.pairs import TurningRun, runs_of, touching
from mbproj.functions.curves.piece import NUMBERS, TERMS, Form, Piece, scaled
from mbproj.functions.curves.pieced import FREE, PiecedCurve
from mbproj.thresholds import THRESHOLDS

#: The point with its derivatives, 0 to 3, and the derivatives of f and g that these need, 0 to 4.
POINT_ORDERS, ORDERS = 4, 5


class Places(NamedTuple):
    """Points (m, 2) along a curve: their parameters, pieces, arc lengths from the start in m, and the angles of their
    tangents in rad, (m,) each. The angles count whole turns. Each piece has places at both of its ends."""

    s: Array
    piece: Integers
    point: Array
    length: Array
    angle: Array


@dataclass(frozen=True)
class PlaneCurve(PiecedCurve):
    """A curve in a plane."""

    pieces: tuple[Piece, ...]
    end: float
    closed: bool

    def __hash__(self) -> int:
        return self.hash_of_numbers

    def scaled(self, k: float) -> PlaneCurve:
        """The curve k times as large, with the same parameter."""
        pieces = tuple(replace(each, f=scaled(each.f, k), g=scaled(each.g, k)) for each in self.pieces)
        return replace(self, pieces=pieces)

    @cached_property
    def arrays(self) -> Pieces:
        """The pieces as arrays."""
        return Pieces(self.pieces)

    @property
    def turn(self) -> float:
        """The angle in rad by which the tangent turns from start to end."""
        return float(self.places.angle[-1] - self.places.angle[0])

    @cached_property
    def turns_left(self) -> bool:
        """Whether a closed curve runs counterclockwise."""
        x, y = self.places.point.T
        return bool(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0.0)

    @cached_property
    def places(self) -> Places:
        """Points on the curve, so dense that the one nearest to a point is next to the point's foot."""
        ends = [*self.arrays.start[1:].tolist(), self.end]
        parts = []
        for at, (start, end) in enumerate(zip(self.arrays.start.tolist(), ends, strict=True)):
            count = max(1, self._turn_of(start, end, at))
            parts.append((np.linspace(start, end, count + 1), np.full(count + 1, at, dtype=np.intp)))
        s, piece = (np.concatenate(part) for part in zip(*parts, strict=True))
        steps = self.lengths(s[:-1], s[1:], piece[:-1])
        steps[piece[1:] != piece[:-1]] = 0.0
        (x, y), (x1, y1), *_ = self.arrays.derivatives(s, piece)
        point, length = np.column_stack([x, y]), np.concatenate([[0.0], np.cumsum(steps)])
        return Places(s, piece, point, length, np.unwrap(np.arctan2(y1, x1)))

    def _turn_of(self, start: float, end: float, piece: int) -> int:
        """The number of equal parts into which a piece is divided, so that none turns by more than `place_turn` rad."""
        s = np.linspace(start, end, 65)
        tangent = self.arrays.derivatives(s, np.full(65, piece))[1]
        angle = np.unwrap(np.arctan2(tangent[1], tangent[0]))
        return int(np.ceil(64.0 * np.abs(np.diff(angle)).max() / THRESHOLDS.place_turn))

    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """The point and its first three derivatives at parameters (...) of these pieces, (4, 2, ...)."""
        return self.arrays.derivatives(s, piece)

    def foot(self, d: Numbers, held: int = FREE) -> tuple[Numbers, Integers]:
        """The parameters of the feet of points d (..., 2), and their pieces. Where a piece is `held` the feet are on
        it, or on its continuation beyond the ends. The foot of a point depends on no other point."""
        return self._settled(d, self._nearest, self._newton, held)

    def facing(self, m: Numbers, held: int = FREE) -> tuple[Numbers, Integers]:
        """The parameters and pieces at which the outward normal of a closed convex curve points along m (..., 2)."""
        return self._settled(m, self._places_facing, self._newton_facing, held)

    def touching(
        self, other: PlaneCurve, d: Numbers, angle: Numbers, opposite: bool, held: tuple[int, int] = (FREE, FREE)
    ) -> tuple[Numbers, Integers]:
        """The parameters (..., 2) of the feet on this curve and the `other` one, and their pieces. The other curve is
        turned by `angle` (...) and moved by d (..., 2). The tangents there are parallel, or `opposite`."""
        return touching((self, other), d, angle, opposite, held)

    @cached_property
    def runs(self) -> tuple[TurningRun, ...]:
        """The runs of places along which the tangent turns one way."""
        return runs_of(self.places.angle)

    def _places_facing(self, m: Array, held: int) -> tuple[Array, Integers]:
        """The parameters and pieces of the places whose outward normals are nearest to directions (k, 2)."""
        allowed = np.arange(len(self.places.s)) if held == FREE else np.flatnonzero(self.places.piece == held)
        angle = self.places.angle[allowed] - (0.5 if self.turns_left else -0.5) * np.pi
        at = np.argmax(m[:, :1] * np.cos(angle) + m[:, 1:] * np.sin(angle), axis=-1)
        return self.places.s[allowed[at]].copy(), self.places.piece[allowed[at]].copy()

    def _newton(self, d: Numbers, s: Numbers, piece: Integers) -> Numbers:
        """The Newton step to (d - c)·c' = 0; the Gauss-Newton step where Newton's would lead away from the minimum."""
        (x, y), (x1, y1), (x2, y2), _ = self.arrays.derivatives(s, piece)
        u, w, speed2 = d[..., 0] - x, d[..., 1] - y, x1 * x1 + y1 * y1
        slope = u * x2 + w * y2 - speed2
        return -(u * x1 + w * y1) / np.where(slope.real < 0.0, slope, -speed2)

    def _newton_facing(self, m: Numbers, s: Numbers, piece: Integers) -> Numbers:
        """The Newton step to m·c' = 0 with m·c'' < 0."""
        _, (x1, y1), (x2, y2), _ = self.arrays.derivatives(s, piece)
        slope = m[..., 0] * x2 + m[..., 1] * y2
        return -(m[..., 0] * x1 + m[..., 1] * y1) / np.where(slope.real < 0.0, slope, -(x1 * x1 + y1 * y1))

    def angle_at(self, s: Numbers, piece: Integers) -> Numbers:
        """The angle in rad by which the tangent has turned from the start to parameters (...) of these pieces."""
        before = self.places_before(s, piece)
        slope = self.arrays.derivatives(s, piece)[1]
        cosine, sine = np.cos(self.places.angle[before]), np.sin(self.places.angle[before])
        across, along = cosine * slope[1] - sine * slope[0], cosine * slope[0] + sine * slope[1]
        return self.places.angle[before] - self.places.angle[0] + np.arctan(across / along)


class Pieces:
    """n pieces as arrays. They are evaluated at many parameters at once; each parameter names its piece."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.start = np.array([each.start for each in pieces])
        self.origin = np.array([each.origin for each in pieces])
        self.form = np.array([each.form for each in pieces], dtype=np.intp)
        self.numbers = np.array([[each.f, each.g] for each in pieces], dtype=float).reshape(len(pieces), 2, NUMBERS)
        orders = np.arange(ORDERS)
        polynomials = [self.numbers[..., :TERMS]]
        for _ in orders[1:]:
            derivative = polynomials[-1][..., 1:] * np.arange(1, TERMS)
            polynomials.append(np.append(derivative, np.zeros((len(pieces), 2, 1)), axis=-1))
        a, self._w, p = (self.numbers[..., TERMS + k, None] for k in range(3))
        self._coefficients, self._a, self._p = np.stack(polynomials, axis=2), a * self._w**orders, p + 0.5 * pi * orders

    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """The point and its three derivatives by s (...), which may be complex: (POINT_ORDERS, 2, ...)."""
        form = self.form[piece]
        values = np.moveaxis(self._values((s - self.origin[piece])[..., None, None], piece), (-1, -2), (0, 1))
        points, f = values[:POINT_ORDERS].copy(), values[:, 0]
        if not form.any():
            return points
        bent, none = f[0] + f[2], 0.0 * s  # the radius of curvature
        outward = {
            Form.POLAR: [f[0], f[1], f[2] - f[0], f[3] - 3.0 * f[1]],
            Form.SUPPORT: [f[0], none, -bent, -2.0 * (f[1] + f[3])],
        }
        around = {
            Form.POLAR: [none, f[0], 2.0 * f[1], 3.0 * f[2] - f[0]],
            Form.SUPPORT: [f[1], bent, f[1] + f[3], f[2] + f[4] - bent],
        }
        cosine, sine = np.cos(s), np.sin(s)
        for kind in outward:
            if (form == kind).any():
                n, t = np.array(outward[kind]), np.array(around[kind])
                turned = np.stack([n * cosine - t * sine, n * sine + t * cosine], axis=1)
                points = np.where(form == kind, turned, points)
        return points

    def radius_of_curvature(self, s: Array, piece: Integers) -> Array:
        """The radius f + f'' in m at s (...), for pieces of the form SUPPORT."""
        values = self._values((s - self.origin[piece])[..., None, None], piece)
        return np.asarray(values[..., 0, 0] + values[..., 0, 2])

    def _values(self, u: Numbers, piece: Integers) -> Numbers:
        """f and g with their derivatives at u (..., 1, 1): (..., 2, ORDERS)."""
        coefficients = self._coefficients[piece]
        value = coefficients[..., -1] + 0.0 * u
        for k in reversed(range(TERMS - 1)):
            value = value * u + coefficients[..., k]
        return np.asarray(value + self._a[piece] * np.sin(self._w[piece] * u + self._p[piece]))
