"""Primitives of curves in a plane of one body: followed by a point, touched by a flat face, or by the curve of another
body.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from types import MappingProxyType
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, TypeVar, final

import numpy as np

from mbproj.base.arrays import Integers, Numbers, dot
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Angle, Primitive

# --- A point that follows a curve: its distance from the curve, and its place along it --------------------------------

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
    acts_in_plane = True
    off_plane: ClassVar[str] = "follows a curve that is not in the plane"
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

    def _gradient_along(self, x: Numbers, e: tuple[Numbers, Numbers], factor: Numbers | float) -> Numbers:
        """Return ∂(factor e·d)/∂x with e and the factor fixed, (..., k, 1, s, 3)."""
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
        tangential = _product(at.t, bias) + (2.0 * at.κ * φ_dot + at.κ_σ * at.φ * σ_dot) * σ_dot
        return σ_dot, tangential / stretch


@dataclass(frozen=True)
class Profile(OnCurve):
    """C = ±φ - R in metres: a roller of radius R, 0 for a point, touches the curve from its left (`side` 1) or from its
    right (-1). `reach` is R, less the distance of the curve from the profile."""

    side: float = 1.0
    reach: float = 0.0

    is_held = True
    parameters = MappingProxyType({"side": "", "reach": "m"})

    def value(self, x: Numbers) -> Numbers:
        return (self.side * self.contact(x).φ - self.reach)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        return self._gradient_along(x, self.contact(x).n, self.side)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at, (rate, bias) = self.contact(x), self._rates(x, x_dot)
        along, bent = _product(at.t, rate), _product(at.n, bias)
        return (self.side * (bent - at.κ / (1.0 - at.κ * at.φ) * along**2))[..., None]


@dataclass(frozen=True)
class Arc(OnCurve):
    """The arc length σ of the foot along the curve from its beginning, in metres."""

    off_plane = "counts along a curve that is not in the plane"

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
    off_plane = "counts along a curve that is not in the plane"
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


# --- A closed convex curve in a plane of one body and a flat face of another ------------------------------------------
# Their distance, and their point of contact.


@dataclass(frozen=True)
class OnFace(OnCurve):
    """A primitive that depends on where a face with the normal m touches: where the outward normal of the curve points
    along (a, b) = (u·m, w·m). The foot does not depend on the face's point p2.

    The foot moves by σ' = ω/κ, with the rate ω = ±t·(a', b')/√(a² + b²) at which m turns in the plane; the sign is κ's.
    """

    slots = ("vector", "vector", "vector", "point", "point")  # type: ignore[assignment]  # those of a point are four
    meets: ClassVar[str] = "face"

    def _place(self, x: Numbers) -> Numbers:
        return np.stack([dot(x[..., 0, :], x[..., 2, :]), dot(x[..., 1, :], x[..., 2, :])], axis=-1)

    def _foot(self, d: Numbers) -> tuple[Numbers, Integers]:
        return self.curve.facing(d, self.piece)

    @staticmethod
    def _line(x: Numbers) -> Numbers:
        return x[..., 4, :] - x[..., 3, :]

    def _size(self, x: Numbers) -> Numbers:
        """Return r = √(a² + b²): 1 for a face normal to the plane."""
        a, b = np.moveaxis(self._place(x), -1, 0)
        return np.sqrt(a * a + b * b)

    def _turning(self, x: Numbers, x_dot: Numbers, at: FootGeometry) -> tuple[Numbers, Numbers]:
        """Return ω, and the part of ω' without second derivatives of x."""
        r, rates = self._size(x), []
        for k in (0, 1):
            rates.append(dot(x_dot[..., k, :], x[..., 2, :]) + dot(x[..., k, :], x_dot[..., 2, :]))
        bent = [2.0 * dot(x_dot[..., k, :], x_dot[..., 2, :]) for k in (0, 1)]
        side = np.sign(at.κ.real)
        ω, d = side * _face_product(at.t, rates) / r, self._place(x)
        growth = (rates[0] * d[..., 0] + rates[1] * d[..., 1]) / r
        return ω, (side * _face_product(at.t, bent) - 2.0 * ω * growth) / r


@final
@dataclass(frozen=True)
class Face(OnFace):
    """C = m·ℓ - (a c0 + b c1) in metres: the distance of the face from the curve. The normal m points away from the
    curve."""

    is_held = True

    def value(self, x: Numbers) -> Numbers:
        c, d = self.contact(x).c, self._place(x)
        return (dot(x[..., 2, :], self._line(x)) - c[0] * d[..., 0] - c[1] * d[..., 1])[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        c, m = self.contact(x).c, x[..., 2, :]
        place = c[0][..., None] * x[..., 0, :] + c[1][..., None] * x[..., 1, :]
        parts = [-c[0][..., None] * m, -c[1][..., None] * m, self._line(x) - place, -m, m]
        return np.stack(parts, axis=-2)[..., None, :, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at = self.contact(x)
        ω, _ = self._turning(x, x_dot, at)
        place = at.c[0][..., None] * x_dot[..., 0, :] + at.c[1][..., None] * x_dot[..., 1, :]
        bent = 2.0 * dot(x_dot[..., 2, :], self._line(x_dot) - place)
        return (bent - self._size(x) * ω**2 / (np.sign(at.κ.real) * at.κ))[..., None]


@dataclass(frozen=True)
class AlongFace(OnFace):
    """p = t·(c - d) in metres, d = (u·ℓ, w·ℓ): the point of contact on the face, along the curve's direction from p2.
    Subclasses may be functions of p and of σ, the arc length of the contact along the curve."""

    off_plane = "counts along a face that is not in the plane"

    def _gradient(self, x: Numbers, *, slips: bool) -> Numbers:
        """The gradient of p, or of σ - p."""
        at, line, m = self.contact(x), self._line(x), x[..., 2, :]
        apart, sign = _face_product(at.n, self._gap(x, at)), -1.0 if slips else 1.0
        turned = np.sign(at.κ.real) * (-apart if slips else apart + 1.0 / at.κ) / self._size(x)
        first, second = (each[..., None] for each in at.t)
        along = first * x[..., 0, :] + second * x[..., 1, :]
        lever = turned[..., None] * m - sign * line
        parts = [first * lever, second * lever, turned[..., None] * along, sign * along, -sign * along]
        return np.stack(parts, axis=-2)[..., None, :, :]

    def _curvature(self, x: Numbers, x_dot: Numbers, *, slips: bool) -> Numbers:
        at, line, line_dot = self.contact(x), self._line(x), self._line(x_dot)
        (ω, ω_bias), apart = self._turning(x, x_dot, at), self._gap(x, at)
        rate = [dot(x_dot[..., k, :], line) + dot(x[..., k, :], line_dot) for k in (0, 1)]
        bias = [2.0 * dot(x_dot[..., k, :], line_dot) for k in (0, 1)]
        across = 2.0 * _face_product(at.n, rate) + ω * _face_product(at.t, apart)
        curvature = ω_bias * _face_product(at.n, apart) - ω * across - _face_product(at.t, bias)
        if slips:
            return -np.asarray(curvature)[..., None]
        return np.asarray(curvature + ω_bias / at.κ - ω**2 * at.κ_σ / at.κ**3)[..., None]

    def _gap(self, x: Numbers, at: FootGeometry) -> tuple[Numbers, Numbers]:
        """Return c - d."""
        line = self._line(x)
        return at.c[0] - dot(x[..., 0, :], line), at.c[1] - dot(x[..., 1, :], line)


@final
@dataclass(frozen=True)
class FacePlace(AlongFace):
    """p."""

    def value(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        return _face_product(at.t, self._gap(x, at))[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        return self._gradient(x, slips=False)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return self._curvature(x, x_dot, slips=False)


@final
@dataclass(frozen=True)
class FaceSlip(AlongFace):
    """σ - p, whose rate is that of sliding of the face along the curve. Its value is 0, as with `SlipOfTwo`."""

    def value(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        way = self.curve.length_at(at.s, at.piece) - _face_product(at.t, self._gap(x, at))
        return (way - way.real)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        return self._gradient(x, slips=True)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return self._curvature(x, x_dot, slips=True)


def _face_product(e: tuple[Numbers, Numbers], d: tuple[Numbers, Numbers] | list[Numbers]) -> Numbers:
    return e[0] * d[0] + e[1] * d[1]


# --- Two curves in a plane, one of each body, that touch --------------------------------------------------------------
# Their distance, and the place of contact on each.


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


OwnOfTwo = TypeVar("OwnOfTwo", bound="TwoCurves")


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
    acts_in_plane = True
    off_plane = "has curves that are not in the plane"
    parameters = MappingProxyType({"side": "", "other_side": ""})

    @property
    def ε(self) -> float:
        """1 where the tangents agree, -1 where they are opposite."""
        return -self.side * self.other_side

    def on_pieces(self: OwnOfTwo, number: int, piece: int) -> OwnOfTwo:
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

    is_held = True
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
        bias = rates.across_bias + rates.ω_bias * at.q_t + rates.ω * (self.ε * second - rates.ω * at.q_n)
        return (self.side * (bias - at.κ[0] * first * slides))[..., None]


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
        bias = 2.0 * at.κ[0] * first * apart + at.κ_σ[0] * at.φ * first**2
        bias = bias + rates.along_bias - rates.ω_bias * at.q_n - rates.ω**2 * at.q_t
        turns = rates.ω_bias - at.κ_σ[0] * first**2 + at.κ_σ[1] * second**2
        return self._sum(*self._solved(at, -bias, turns))[..., None]


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
