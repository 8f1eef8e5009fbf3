"""Two curves in a plane, one of each body, that touch: their distance, and the place of contact on each."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from types import MappingProxyType
from typing import ClassVar, Literal, NamedTuple, TypeVar, final

import numpy as np

from mbproj.arrays import Integers, Numbers, dot
from mbproj.constraints.basic import Angle
from mbproj.constraints.curves.profile import FREE, MOST_KEPT, PlaneCurveShape
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass

ANGLE = Angle()


class Feet(NamedTuple):
    """The geometry at the feet s (..., 2) and their `piece`: at the first the unit tangent t and the distance φ to the
    left along n. `q_t`, `q_n`: the components along t and n of q = R c2, the second curve's point turned with it. `κ`,
    `κ_σ`: the curvatures of both curves and their derivatives by the arc length."""

    s: Numbers
    piece: Integers
    t: tuple[Numbers, Numbers]
    φ: Numbers
    q_t: Numbers
    q_n: Numbers
    κ: tuple[Numbers, Numbers]
    κ_σ: tuple[Numbers, Numbers]


class Rates(NamedTuple):
    """The rates in a motion: d' along t and across it, along n, and ω. `*_bias`: the parts of d'' and ω' without second
    derivatives of x."""

    along: Numbers
    across: Numbers
    ω: Numbers
    along_bias: Numbers
    across_bias: Numbers
    ω_bias: Numbers


Own = TypeVar("Own", bound="TwoCurves")


@dataclass(frozen=True)
class TwoCurves(Primitive):
    """A primitive that depends on where two curves touch: on d = (u·ℓ, w·ℓ), ℓ = p2 - p1, and the angle θ from u
    towards w of the second curve's axis m. Each curve lies on the other's side ±1, the left or the right.

    At the feet t1·Δ = 0 and R t2 = ε t1, ε = -side other_side, Δ = d + R c2 - c1. Both feet move by (κ1 φ - 1) σ1' + ε
    σ2' = -t1·(d' + ω z × q), κ1 σ1' - κ2 σ2' = ω.
    """

    curve: PlaneCurveShape
    other: PlaneCurveShape
    piece: int = FREE
    other_piece: int = FREE
    side: float = 1.0
    other_side: float = 1.0

    slots = ("vector", "vector", "vector", "point", "point")
    rows = 1
    follows = "two curves"
    unit: ClassVar[Literal["m"]] = "m"
    parameters = MappingProxyType({"side": "", "other_side": ""})

    @property
    def ε(self) -> float:
        """1 where the tangents agree, -1 where they are opposite."""
        return -self.side * self.other_side

    def on_pieces(self: Own, number: int, piece: int) -> Own:
        """Return the primitive with a piece held of the first curve (0) or the second (1)."""
        return replace(self, piece=piece) if number == 0 else replace(self, other_piece=piece)

    def foot(self, x: Numbers) -> Numbers:
        """Return the parameters of both feet, (..., k, 2)."""
        return self.feet(x).s

    def feet(self, x: Numbers) -> Feet:
        """Return the feet. The last feet are cached, because the row, its gradient and its curvature at one pose use
        them."""
        line = x[..., 4, :] - x[..., 3, :]
        d = np.stack([dot(x[..., 0, :], line), dot(x[..., 1, :], line)], axis=-1)
        θ = ANGLE.value(x[..., :3, :])[..., 0]
        held, seen = (self.piece, self.other_piece), self.curve.contacts
        key = (id(self.other), *held, self.ε, d.dtype.char, d.shape, d.tobytes(), θ.tobytes())
        if key not in seen:
            if len(seen) >= MOST_KEPT:
                seen.clear()
            seen[key] = self._feet(d, θ, held)
        of_pose: Feet = seen[key]
        return of_pose

    def _feet(self, d: Numbers, θ: Numbers, held: tuple[int, int]) -> Feet:
        s, piece = self.curve.touching(self.other, d, θ, self.ε < 0.0, held)
        first, second = (
            curve.derivatives(s[..., k], piece[..., k]) for k, curve in enumerate((self.curve, self.other))
        )
        (κ1, κ1_σ), (κ2, κ2_σ) = _bend(first), _bend(second)
        (c0, c1), (x1, y1) = first[:2]
        speed, cosine, sine = np.sqrt(x1 * x1 + y1 * y1), np.cos(θ), np.sin(θ)
        t = x1 / speed, y1 / speed
        q = cosine * second[0, 0] - sine * second[0, 1], sine * second[0, 0] + cosine * second[0, 1]
        φ = t[0] * (d[..., 1] + q[1] - c1) - t[1] * (d[..., 0] + q[0] - c0)
        return Feet(s, piece, t, φ, t[0] * q[0] + t[1] * q[1], t[0] * q[1] - t[1] * q[0], (κ1, κ2), (κ1_σ, κ2_σ))

    @staticmethod
    def _gradient_along(x: Numbers, e: tuple[Numbers, Numbers], by_angle: Numbers) -> Numbers:
        """Return ∂(e·d + by_angle θ)/∂x with e and by_angle fixed, (..., k, 1, 5, 3)."""
        line = x[..., 4, :] - x[..., 3, :]
        first, second = (each[..., None] for each in e)
        across = first * x[..., 0, :] + second * x[..., 1, :]
        turned = by_angle[..., None, None] * ANGLE.gradient(x[..., :3, :])[..., 0, :, :]
        parts = [first * line + turned[..., 0, :], second * line + turned[..., 1, :], turned[..., 2, :]]
        return np.stack([*parts, -across, across], axis=-2)[..., None, :, :]

    @staticmethod
    def _rates(x: Numbers, x_dot: Numbers, at: Feet) -> Rates:
        line, line_dot = x[..., 4, :] - x[..., 3, :], x_dot[..., 4, :] - x_dot[..., 3, :]
        rate = [dot(x_dot[..., k, :], line) + dot(x[..., k, :], line_dot) for k in (0, 1)]
        bias = [2.0 * dot(x_dot[..., k, :], line_dot) for k in (0, 1)]
        (a, b), angle, angle_dot = at.t, x[..., :3, :], x_dot[..., :3, :]
        along, across = ([a * each[0] + b * each[1], a * each[1] - b * each[0]] for each in (rate, bias))
        ω, ω_bias = ANGLE.rate(angle, angle_dot)[..., 0], ANGLE.curvature(angle, angle_dot)[..., 0]
        return Rates(along[0], along[1], ω, across[0], across[1], ω_bias)

    def _solved(self, at: Feet, first: Numbers, second: Numbers) -> tuple[Numbers, Numbers]:
        """Return σ1 and σ2 of (κ1 φ - 1) σ1 + ε σ2 = first, κ1 σ1 - κ2 σ2 = second."""
        (κ1, κ2), lever = at.κ, at.κ[0] * at.φ - 1.0
        determinant = -κ2 * lever - self.ε * κ1
        return (-κ2 * first - self.ε * second) / determinant, (lever * second - κ1 * first) / determinant

    def _moves(self, at: Feet, rates: Rates) -> tuple[Numbers, Numbers]:
        """Return σ1' and σ2'."""
        return self._solved(at, -(rates.along - rates.ω * at.q_n), rates.ω)


@final
@dataclass(frozen=True)
class Gap(TwoCurves):
    """C = side φ - reach in metres: the distance of the profiles. `reach` is the distance of the curves less that."""

    reach: float = 0.0

    parameters = MappingProxyType({**TwoCurves.parameters, "reach": "m"})

    def value(self, x: Numbers) -> Numbers:
        return (self.side * self.feet(x).φ - self.reach)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        at = self.feet(x)
        return self._gradient_along(x, (-self.side * at.t[1], self.side * at.t[0]), self.side * at.q_t)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at = self.feet(x)
        rates = self._rates(x, x_dot, at)
        first, second = self._moves(at, rates)
        slides = rates.along - rates.ω * at.q_n
        own = rates.across_bias + rates.ω_bias * at.q_t + rates.ω * (self.ε * second - rates.ω * at.q_n)
        return (self.side * (own - at.κ[0] * first * slides))[..., None]


@dataclass(frozen=True)
class PlaceOfTwo(TwoCurves):
    """A function of the arc lengths σ1 and σ2 of the feet on both curves from their beginnings, in metres."""

    @abstractmethod
    def _sum(self, first: Numbers, second: Numbers) -> Numbers:
        """Return the weighted sum of σ1 and σ2, or of their derivatives."""

    def value(self, x: Numbers) -> Numbers:
        at, curves = self.feet(x), (self.curve, self.other)
        return self._sum(*(each.length_at(at.s[..., k], at.piece[..., k]) for k, each in enumerate(curves)))[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        at, one = self.feet(x), np.ones(1)
        by_place = self._sum(*self._solved(at, -one, 0.0 * one))
        by_angle = self._sum(*self._solved(at, at.q_n, one))
        return self._gradient_along(x, (by_place * at.t[0], by_place * at.t[1]), by_angle)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at = self.feet(x)
        rates = self._rates(x, x_dot, at)
        first, second = self._moves(at, rates)
        apart = rates.across + rates.ω * at.q_t
        own = 2.0 * at.κ[0] * first * apart + at.κ_σ[0] * at.φ * first**2
        own = own + rates.along_bias - rates.ω_bias * at.q_n - rates.ω**2 * at.q_t
        turns = rates.ω_bias - at.κ_σ[0] * first**2 + at.κ_σ[1] * second**2
        return self._sum(*self._solved(at, -own, turns))[..., None]


@final
@dataclass(frozen=True)
class PlaceOnFirst(PlaceOfTwo):
    """The place on the curve of the first body."""

    def _sum(self, first: Numbers, second: Numbers) -> Numbers:
        return first


@final
@dataclass(frozen=True)
class PlaceOnSecond(PlaceOfTwo):
    """The place on the curve of the second body."""

    def _sum(self, first: Numbers, second: Numbers) -> Numbers:
        return second


@final
@dataclass(frozen=True)
class SlipOfTwo(PlaceOfTwo):
    """σ1 - ε σ2, whose rate is that of sliding of the second curve along the first. The distance slid is no function of
    the pose on closed curves. So the value is 0, with the imaginary part of a complex step alone."""

    def _sum(self, first: Numbers, second: Numbers) -> Numbers:
        return first - self.ε * second

    def value(self, x: Numbers) -> Numbers:
        way = super().value(x)
        return way - way.real


def _bend(c: Numbers) -> tuple[Numbers, Numbers]:
    """Return the curvature, and its derivative by the arc length."""
    _, (x1, y1), (x2, y2), (x3, y3) = c
    speed2, turn = x1 * x1 + y1 * y1, x1 * y2 - y1 * x2
    change = (x1 * y3 - y1 * x3 - 3.0 * turn * (x1 * x2 + y1 * y2) / speed2) / speed2**2
    return turn / speed2**1.5, change
