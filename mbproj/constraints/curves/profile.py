"""A curve in a plane of one body and a point of another: the point's distance from the curve, and its place along
it."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, TypeVar, final

import numpy as np

from mbproj.arrays import Integers, Numbers, dot
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass

#: The piece number where no piece is held.
FREE = -1


#: The number of contacts in the cache, each of few points.
MOST_KEPT = 32


class PlaneCurveShape(Protocol):
    """Interface of a curve of pieces, each of which continues beyond its ends."""

    @property
    def knots(self) -> object:
        """The program whose switches are the ends of the pieces."""

    @property
    def contacts(self) -> dict[tuple[object, ...], Any]:
        """The contacts of the last points."""

    @property
    def closed(self) -> bool:
        """Whether its end is its beginning."""

    def foot(self, d: Numbers, held: int = FREE) -> tuple[Numbers, Integers]:
        """Return the parameters of the places nearest to points d (..., 2), which may be complex, and their pieces."""

    def facing(self, m: Numbers, held: int = FREE) -> tuple[Numbers, Integers]:
        """Return the parameters of the places whose outward normals point along m (..., 2), and their pieces."""

    def touching(
        self, other: Any, d: Numbers, angle: Numbers, opposite: bool, held: tuple[int, int]
    ) -> tuple[Numbers, Integers]:
        """Return the parameters (..., 2) of the feet on this curve and another one, and their pieces."""

    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """Return the point and its first three derivatives by the parameter, (4, 2, ...)."""

    def length_at(self, s: Numbers, piece: Integers) -> Numbers:
        """Return the arc length from the beginning."""

    def angle_at(self, s: Numbers, piece: Integers) -> Numbers:
        """Return the turn of the tangent from the beginning."""


class FootGeometry(NamedTuple):
    """The geometry at the foot s of d: the curve's point c, the unit tangent t, the distance φ of d to the left along
    n, the curvature κ and its derivative κ_σ by the arc length σ."""

    s: Numbers
    piece: Integers
    c: tuple[Numbers, Numbers]
    t: tuple[Numbers, Numbers]
    φ: Numbers
    κ: Numbers
    κ_σ: Numbers

    @property
    def n(self) -> tuple[Numbers, Numbers]:
        """The tangent turned by a quarter turn to the left."""
        return -self.t[1], self.t[0]


Own = TypeVar("Own", bound="OnCurve")


@dataclass(frozen=True)
class OnCurve(Primitive):
    """A primitive that depends on the foot of d = (u·ℓ, w·ℓ), ℓ = p2 - p1, on a curve whose axes are u and w.

    `piece`: the piece on which the foot is held, or FREE. The foot is the nearest place, so that the row depends on the
    pose alone, not on the past."""

    curve: PlaneCurveShape
    piece: int = FREE

    slots = ("vector", "vector", "point", "point")
    rows = 1
    follows = "curve"
    unit: ClassVar[Literal["m", "rad"]] = "m"
    #: The kind of thing that touches the curve; contacts are cached by kind.
    meets: ClassVar[str] = "point"

    def on_piece(self: Own, piece: int) -> Own:
        """Return the primitive with this piece held."""
        return replace(self, piece=piece)

    def foot(self, x: Numbers) -> Numbers:
        """Return the parameter of the foot, (..., k)."""
        return self.contact(x).s

    def _place(self, x: Numbers) -> Numbers:
        line = x[..., 3, :] - x[..., 2, :]
        return np.stack([dot(x[..., 0, :], line), dot(x[..., 1, :], line)], axis=-1)

    def contact(self, x: Numbers) -> FootGeometry:
        """Return the contact. The last contacts are cached, because the row, its gradient and its curvature at one pose
        use them."""
        d = self._place(x)
        key, seen = (self.meets, self.piece, d.dtype.char, d.shape, d.tobytes()), self.curve.contacts
        if d.size > MOST_KEPT:
            return self._contact(d)
        if key not in seen:
            if len(seen) >= MOST_KEPT:
                seen.clear()
            seen[key] = self._contact(d)
        return seen[key]

    def _foot(self, d: Numbers) -> tuple[Numbers, Integers]:
        return self.curve.foot(d, self.piece)

    def _contact(self, d: Numbers) -> FootGeometry:
        s, piece = self._foot(d)
        (c0, c1), (x1, y1), (x2, y2), (x3, y3) = self.curve.derivatives(s, piece)
        speed = np.sqrt(x1 * x1 + y1 * y1)
        t = x1 / speed, y1 / speed
        turn, turn_s = x1 * y2 - y1 * x2, x1 * y3 - y1 * x3
        κ_s = (turn_s - 3.0 * turn * (x1 * x2 + y1 * y2) / speed**2) / speed**3
        φ = t[0] * (d[..., 1] - c1) - t[1] * (d[..., 0] - c0)
        return FootGeometry(s, piece, (c0, c1), t, φ, turn / speed**3, κ_s / speed)

    @staticmethod
    def _gradient_along(x: Numbers, e: tuple[Numbers, Numbers], factor: Numbers | float) -> Numbers:
        """Return ∂(factor e·d)/∂x with e and the factor fixed, (..., k, 1, 4, 3)."""
        line = x[..., 3, :] - x[..., 2, :]
        first, second = (factor * each for each in e)
        across = first[..., None] * x[..., 0, :] + second[..., None] * x[..., 1, :]
        return np.stack([first[..., None] * line, second[..., None] * line, -across, across], axis=-2)[..., None, :, :]

    def _rates(self, x: Numbers, x_dot: Numbers) -> tuple[tuple[Numbers, Numbers], tuple[Numbers, Numbers]]:
        """Return d', and the part of d'' without second derivatives of x."""
        line, line_dot = x[..., 3, :] - x[..., 2, :], x_dot[..., 3, :] - x_dot[..., 2, :]
        axes = (0, 1)
        rates = [dot(x_dot[..., k, :], line) + dot(x[..., k, :], line_dot) for k in axes]
        bias = [2.0 * dot(x_dot[..., k, :], line_dot) for k in axes]
        return (rates[0], rates[1]), (bias[0], bias[1])

    def _changes(self, x: Numbers, x_dot: Numbers) -> tuple[Numbers, Numbers]:
        """Return σ', and the part of σ'' without second derivatives of x, for the arc length σ."""
        at, (rate, bias) = self.contact(x), self._rates(x, x_dot)
        stretch = 1.0 - at.κ * at.φ
        σ_dot, φ_dot = _product(at.t, rate) / stretch, _product(at.n, rate)
        own = _product(at.t, bias) + (2.0 * at.κ * φ_dot + at.κ_σ * at.φ * σ_dot) * σ_dot
        return σ_dot, own / stretch


@final
@dataclass(frozen=True)
class Profile(OnCurve):
    """C = ±φ - R in metres: a roller of radius R, 0 for a point, touches the curve from its left (`side` 1) or from its
    right (-1). `reach` is R, less the distance of the curve from the profile."""

    side: float = 1.0
    reach: float = 0.0

    parameters = MappingProxyType({"side": "", "reach": "m"})

    def value(self, x: Numbers) -> Numbers:
        return (self.side * self.contact(x).φ - self.reach)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        return self._gradient_along(x, self.contact(x).n, self.side)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at, (rate, bias) = self.contact(x), self._rates(x, x_dot)
        along, bent = _product(at.t, rate), _product(at.n, bias)
        return (self.side * (bent - at.κ / (1.0 - at.κ * at.φ) * along**2))[..., None]


@final
@dataclass(frozen=True)
class Arc(OnCurve):
    """The arc length σ of the foot along the curve from its beginning, in metres."""

    def value(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        return self.curve.length_at(at.s, at.piece)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        return self._gradient_along(x, at.t, 1.0 / (1.0 - at.κ * at.φ))

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return self._changes(x, x_dot)[1][..., None]


@final
@dataclass(frozen=True)
class Lap(OnCurve):
    """The turns of the foot round a curve, in rad: scale (σ - offset θ), with arc length σ and the turn θ of the
    tangent.

    This is `scale` times the path of a point at the distance `offset` to the left of the curve. A whole lap of a closed
    curve is 2π; the value is known up to whole laps, as an angle up to turns.

    A roller of radius r, whose centre moves along that path on the side ±1, turns by φ: without slip (lap/scale) ± r φ
    is constant.
    """

    offset: float = 0.0
    scale: float = 1.0

    unit = "rad"
    parameters = MappingProxyType({"offset": "m", "scale": ""})

    def value(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        way = self.curve.length_at(at.s, at.piece) - self.offset * self.curve.angle_at(at.s, at.piece)
        lap = self.scale * way
        return (lap - 2.0 * np.pi * np.round(lap.real / (2.0 * np.pi)) if self.curve.closed else lap)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        return self._gradient_along(x, at.t, self.scale * (1.0 - self.offset * at.κ) / (1.0 - at.κ * at.φ))

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at = self.contact(x)
        σ_dot, σ_bias = self._changes(x, x_dot)
        return (self.scale * ((1.0 - self.offset * at.κ) * σ_bias - self.offset * at.κ_σ * σ_dot**2))[..., None]


def _product(e: tuple[Numbers, Numbers], d: tuple[Numbers, Numbers]) -> Numbers:
    return e[0] * d[0] + e[1] * d[1]
