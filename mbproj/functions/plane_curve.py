"""Plane curves: their places, the foot of a point, and the arc length."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from math import atan2, cos, hypot, inf, pi, sin, tan
from sys import float_info
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.curve_pieces import FREE, NUMBERS, TERMS, Form, Piece, PiecedCurve, mirrored, polynomial, scaled
from mbproj.functions.table import CubicTable, periodic, spline

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


# --- The feet of two curves -------------------------------------------------------------------------------------------
# The points where their tangents are parallel and the line between them is normal to both. There the curves touch, or
# are nearest to touching. The first curve is fixed; the second is turned by an angle and then moved by d. The places
# of both curves are passed side by side, in the order of the angles of their tangents. Newton's method starts where
# the line from the first to the second place changes from forward to backward along the tangent. It also starts at
# the ends, since a piece continues beyond them. Of several solutions the one with the smallest distance counts.


FULL_TURN = 2.0 * np.pi
#: A number for each of two curves: of a place or of a piece.
TwoNumbers: TypeAlias = "tuple[int, int]"


class TurningRun(NamedTuple):
    """The places from `first` to `last`, along which the tangent turns one way: to the `left`, or to the right."""

    first: int
    last: int
    left: bool


class RelativePose(NamedTuple):
    """The pose of the second curve: its offset d (2, ...) in m, its angle (...) in rad, and whether the tangents at the
    feet are `opposite`."""

    d: Numbers
    angle: Numbers
    opposite: bool

    def only(self, some: Integers) -> RelativePose:
        """The poses with these numbers."""
        return RelativePose(self.d[:, some], self.angle[some], self.opposite)

    def turned(self, vector: Numbers) -> Numbers:
        """A vector (2, ...) of the second curve in the axes of the first."""
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        return np.stack([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


def runs_of(angle: Array) -> tuple[TurningRun, ...]:
    """All places divided into turning runs, from the angles of their tangents, (m,) in rad."""
    turn = np.diff(angle)
    runs, first, way = list[TurningRun](), 0, 0.0
    for at, step in enumerate(turn.tolist()):
        if abs(step) <= THRESHOLDS.rounding:
            continue
        if way * step < 0.0:
            runs.append(TurningRun(first, at, way > 0.0))
            first = at
        way = step
    return (*runs, TurningRun(first, len(turn), way >= 0.0))


def touching(
    curves: tuple[PlaneCurve, PlaneCurve], d: Numbers, angle: Numbers, opposite: bool, held: TwoNumbers
) -> tuple[Numbers, Integers]:
    """The parameters of the two feet (..., 2), and their pieces (..., 2). The second curve is turned by `angle` (...)
    and moved by d (..., 2); both may be complex. A foot stays on the `held` piece of its curve."""
    flat, turn = d.reshape(-1, 2), angle.reshape(-1)
    real = RelativePose(flat.real.T, turn.real, opposite)
    at = np.array(
        [_nearest(curves, RelativePose(flat[k].real, turn[k].real, opposite), held) for k in range(len(flat))]
    )
    s = np.stack([curve.places.s[nearest] for curve, nearest in zip(curves, at.T, strict=True)])
    piece = np.stack([curve.places.piece[nearest] for curve, nearest in zip(curves, at.T, strict=True)])
    reach, settled = np.array([[[curve.reach], [curve.settled]] for curve in curves]).swapaxes(0, 1)
    active = np.arange(len(flat))
    for _ in range(THRESHOLDS.most_passes):
        step = np.clip(_newton(curves, real.only(active), s[:, active], piece[:, active]), -reach, reach)
        for k, curve in enumerate(curves):
            s[k, active], piece[k, active] = curve.in_period(s[k, active] + step[k], piece[k, active], held[k])
        active = active[(np.abs(step) > settled).any(axis=0)]
        if not len(active):
            break
    feet: Numbers = s
    if np.iscomplexobj(d) or np.iscomplexobj(angle):
        for _ in range(2):  # the first step brings the derivative, the second corrects the first's round-off
            feet = feet + _newton(curves, RelativePose(flat.T, turn, opposite), feet, piece)
    return feet.T.reshape(*angle.shape, 2), piece.T.reshape(*angle.shape, 2)


def _newton(curves: tuple[PlaneCurve, PlaneCurve], pose: RelativePose, s: Numbers, piece: Integers) -> Numbers:
    """The steps (2, k) of Newton's method to c1'·Δ = 0 and c1' × c2' = 0; Δ is the line from the first foot to the
    second."""
    (c, c1, c2, _), second = (curve.derivatives(s[k], piece[k]) for k, curve in enumerate(curves))
    e, e1, e2, _ = (pose.turned(each) for each in second)
    line, speed2 = pose.d + e - c, _dot(c1, c1)
    a, b = _dot(c2, line) - speed2, _dot(c1, e1)
    turn, bend = _cross(c2, e1), _cross(c1, e2)
    forward, apart = _dot(c1, line), _cross(c1, e1)
    determinant = a * bend - b * turn
    straight = abs(determinant) <= THRESHOLDS.rounding * (abs(a * bend) + abs(b * turn))
    divisor = np.where(straight, 1.0, determinant)
    first = np.where(straight, forward / speed2, (b * apart - bend * forward) / divisor)
    return np.stack([first, np.where(straight, 0.0, (turn * forward - a * apart) / divisor)])


def _dot(one: Numbers, other: Numbers) -> Numbers:
    return np.asarray(one[0] * other[0] + one[1] * other[1])


def _cross(one: Numbers, other: Numbers) -> Numbers:
    return np.asarray(one[0] * other[1] - one[1] * other[0])


def _nearest(curves: tuple[PlaneCurve, PlaneCurve], pose: RelativePose, held: TwoNumbers) -> TwoNumbers:
    """The numbers of the places next to the two feet."""
    best, least = None, np.inf
    for i, j, forward, apart in _walks(curves, pose, held):
        for k in np.flatnonzero(forward[:-1] * forward[1:] <= 0.0).tolist():
            at = k if abs(forward[k]) < abs(forward[k + 1]) else k + 1
            if abs(apart[at]) < least:
                best, least = (int(i[at]), int(j[at])), abs(apart[at])
        for at in (0, -1):
            if (distance := float(np.hypot(forward[at], apart[at]))) < least:
                best, least = (int(i[at]), int(j[at])), distance
    return best or _closest(curves, pose, held)


def _closest(curves: tuple[PlaneCurve, PlaneCurve], pose: RelativePose, held: TwoNumbers) -> TwoNumbers:
    """The two places that are nearest to each other: the start where no walk finds one."""
    first, second = (
        np.arange(len(curve.places.s)) if number < 0 else np.flatnonzero(curve.places.piece == number)
        for curve, number in zip(curves, held, strict=True)
    )
    there = (pose.d[:, None] + pose.turned(curves[1].places.point[second].T)).T
    line = there[None, :, :] - curves[0].places.point[first][:, None, :]
    i, j = np.unravel_index(np.argmin((line * line).sum(axis=-1)), (len(first), len(second)))
    return int(first[i]), int(second[j])


def _walks(
    curves: tuple[PlaneCurve, PlaneCurve], pose: RelativePose, held: TwoNumbers
) -> Iterator[tuple[Integers, Integers, Array, Array]]:
    """Places of both curves side by side, (k,) each, and the line between them: its components along the tangent of the
    first curve, and across it."""
    turn = float(pose.angle) + (np.pi if pose.opposite else 0.0)
    (first, second), there = (
        (curve.places for curve in curves),
        (pose.d[:, None] + pose.turned(curves[1].places.point.T)).T,
    )
    for one in _runs(curves[0], held[0]):
        for other in _runs(curves[1], held[1]):
            a, b = first.angle[one], second.angle[other] + turn
            more = THRESHOLDS.place_turn
            low, high = np.ceil((a[0] - b[-1] - more) / FULL_TURN), np.floor((a[-1] - b[0] + more) / FULL_TURN)
            for turns in np.arange(low, high + 1.0).tolist():
                i, j = (run[at] for run, at in zip((one, other), _merged(a, b + FULL_TURN * turns), strict=True))
                line = there[j] - first.point[i]
                cosine, sine = np.cos(first.angle[i]), np.sin(first.angle[i])
                yield i, j, cosine * line[:, 0] + sine * line[:, 1], cosine * line[:, 1] - sine * line[:, 0]


def _runs(curve: PlaneCurve, held: int) -> Iterator[Integers]:
    """The numbers of the places of each run, ordered so that the angles grow. Only those on the `held` piece, if
    any."""
    for run in curve.runs:
        places = np.arange(run.first, run.last + 1)
        if held >= 0:
            places = places[curve.places.piece[places] == held]
        if len(places) > 1:
            yield places if run.left else places[::-1]


def _merged(a: Array, b: Array) -> tuple[Integers, Integers]:
    """The positions in two ascending sequences while their numbers are passed in order. The walk begins where both
    sequences have begun, and ends with the first that ends."""
    both = np.concatenate([a, b])
    order = np.argsort(both, kind="stable")
    of_first = order < len(a)
    i, j = np.cumsum(of_first) - 1, np.cumsum(~of_first) - 1
    begun = (i >= 0) & (j >= 0)
    inside = begun & (both[order] <= min(a[-1], b[-1]))
    inside[np.argmax(begun)] = True
    return i[inside], j[inside]


# --- Lift laws of cams ------------------------------------------------------------------------------------------------
# A follower rises from 0 to 1 while x goes from 0 to 1 (Norton 2009, Cam Design, ch. 3).


class LawPiece(NamedTuple):
    """A piece of a law, from x = `start` on: Σ c_k x^k + a sin(w x + p). `wave` is (a, w, p)."""

    start: float
    coefficients: tuple[float, ...]
    wave: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def numbers(self, first: float, rise: float, duration: float) -> tuple[float, ...]:
        """The numbers of first + rise · law(u / duration) for a `Piece`."""
        c0, *others = [rise * c / duration**k for k, c in enumerate((*self.coefficients, *(0.0,) * TERMS)[:TERMS])]
        a, w, p = self.wave
        return polynomial([c0 + first, *others], (rise * a, w / duration, p))


class Rise(NamedTuple):
    """A part of a lift law: over `angle` in rad the follower moves to the lift `to` in m, by a law of LAWS."""

    angle: float
    to: float
    law: str


class _Acceleration(NamedTuple):
    """y'' = constant + a sin(w x + p) from x = `start` on."""

    start: float
    constant: float
    a: float = 0.0
    w: float = 1.0
    p: float = 0.0


def _by_acceleration(*accelerations: _Acceleration) -> tuple[LawPiece, ...]:
    """The law whose acceleration is proportional to the given one. It is 0 with zero slope at x = 0, and 1 at x = 1."""
    parts, y, slope = [], 0.0, 0.0
    for each, end in zip(accelerations, [*(after.start for after in accelerations[1:]), 1.0], strict=True):
        start, k, (a, w, p) = each.start, each.constant, each[2:]
        wave = (-a / w**2, w, p)
        c1 = slope - k * start + a / w * cos(w * start + p)
        c0 = y - c1 * start - 0.5 * k * start**2 - wave[0] * sin(w * start + p)
        parts.append(LawPiece(start, (c0, c1, 0.5 * k), wave))
        y = c0 + c1 * end + 0.5 * k * end**2 + wave[0] * sin(w * end + p)
        slope = c1 + k * end - a / w * cos(w * end + p)
    return tuple(
        LawPiece(each.start, tuple(c / y for c in each.coefficients), (each.wave[0] / y, *each.wave[1:]))
        for each in parts
    )


_EIGHTH = 0.125
LAWS: Mapping[str, tuple[LawPiece, ...]] = MappingProxyType(
    {
        "dwell": (LawPiece(0.0, ()),),
        "cycloidal": _by_acceleration(_Acceleration(0.0, 0.0, 1.0, 2.0 * pi)),
        "harmonic": _by_acceleration(_Acceleration(0.0, 0.0, 1.0, pi, 0.5 * pi)),
        "polynomial_345": (LawPiece(0.0, (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)),),
        "polynomial_4567": (LawPiece(0.0, (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)),),
        "modified_sine": _by_acceleration(
            _Acceleration(0.0, 0.0, 1.0, 4.0 * pi),
            _Acceleration(_EIGHTH, 0.0, 1.0, 4.0 * pi / 3.0, pi / 3.0),
            _Acceleration(7.0 * _EIGHTH, 0.0, 1.0, 4.0 * pi),
        ),
        "modified_trapezoid": _by_acceleration(
            _Acceleration(0.0, 0.0, 1.0, 4.0 * pi),
            _Acceleration(_EIGHTH, 1.0),
            _Acceleration(3.0 * _EIGHTH, 0.0, 1.0, 4.0 * pi, -pi),
            _Acceleration(5.0 * _EIGHTH, -1.0),
            _Acceleration(7.0 * _EIGHTH, 0.0, 1.0, 4.0 * pi),
        ),
    }
)


# --- The shapes of curves that a scene can give, as pieces ------------------------------------------------------------


Point = tuple[float, float]
#: A line is dropped where the arcs at its ends leave less than this part of it.
ROUND_OFF = 64.0 * float_info.epsilon


class CamFollower(NamedTuple):
    """The follower that touches a cam: a point, a roller of `radius` m, or a flat face."""

    kind: Literal["point", "roller", "flat"] = "point"
    radius: float = 0.0


def through(points: Sequence[Point], closed: bool) -> PlaneCurve:
    """The cubic spline through points, with natural ends or `closed`. Its parameter is the sum of the chords in m."""
    whole = [*points, points[0]] if closed else [*points]
    s = [0.0]
    for (x0, y0), (x1, y1) in pairwise(whole):
        s.append(s[-1] + hypot(x1 - x0, y1 - y0))
    x, y = (
        periodic(rows[:-1], s[-1]) if closed else spline(rows, "natural")
        for rows in ([(at, point[k]) for at, point in zip(s, whole, strict=True)] for k in (0, 1))
    )
    pieces = [
        Piece(knot, origin, Form.CARTESIAN, polynomial(first), polynomial(second))
        for knot, origin, first, second in zip(x.knots, x.origins, x.pieces, y.pieces, strict=True)
    ]
    return PlaneCurve(tuple(pieces if closed else pieces[1:-1]), s[-1], closed)


def ellipse(half_axes: Point) -> PlaneCurve:
    """The ellipse about the origin, counterclockwise from the end of its first half axis. `half_axes` are in m."""
    x, y = (polynomial((), (half, 1.0, phase)) for half, phase in zip(half_axes, (0.5 * pi, 0.0), strict=True))
    return PlaneCurve((Piece(0.0, 0.0, Form.CARTESIAN, x, y),), FULL_TURN, True)


def involute(base: float, start: float, end: float) -> PlaneCurve:
    """The involute of the circle of radius `base` m about the origin, between two roll angles in rad. It is the path of
    the end of a cord that is unrolled from the x axis on: counterclockwise, or clockwise at negative angles."""
    quarter = 0.5 * pi
    piece = Piece(start - quarter, -quarter, Form.SUPPORT, polynomial((0.0, base)))
    return PlaneCurve((piece,), end - quarter, False)


def polyline(points: Sequence[Point], fillet: float, closed: bool) -> PlaneCurve:
    """Straight lines from point to point, with an arc of radius `fillet` m in each corner. The parameter is the arc
    length. Raises ValueError with the number of the corner where the arc does not fit."""
    count = len(points)
    corners = [_corner(points, at, fillet, closed) for at in range(count)]
    pieces, s = list[Piece](), 0.0
    for at in range(count if closed else count - 1):
        start, end, here, after = points[at], points[(at + 1) % count], corners[at], corners[(at + 1) % count]
        dx, dy = end[0] - start[0], end[1] - start[1]
        whole = hypot(dx, dy)
        length, (tx, ty) = whole - here.cut - after.cut, (dx / whole, dy / whole)
        if length < -ROUND_OFF * whole:
            raise ValueError((at + 1) % count)
        if length > ROUND_OFF * whole:
            x, y = start[0] + here.cut * tx, start[1] + here.cut * ty
            pieces.append(Piece(s, s, Form.CARTESIAN, polynomial((x, tx)), polynomial((y, ty))))
            s += length
        if after.cut:
            side = 1.0 if after.turn > 0.0 else -1.0
            x, y = end[0] - after.cut * tx - side * fillet * ty, end[1] - after.cut * ty + side * fillet * tx
            angle, rate = atan2(ty, tx) - side * 0.5 * pi, side / fillet
            pieces.append(
                Piece(
                    s,
                    s,
                    Form.CARTESIAN,
                    polynomial((x,), (fillet, rate, angle + 0.5 * pi)),
                    polynomial((y,), (fillet, rate, angle)),
                )
            )
            s += fillet * abs(after.turn)
    return PlaneCurve(tuple(pieces), s, closed)


class _Corner(NamedTuple):
    """The angle `turn` in rad of a corner, and the length `cut` in m that its arc takes from both lines."""

    turn: float = 0.0
    cut: float = 0.0


def _corner(points: Sequence[Point], at: int, fillet: float, closed: bool) -> _Corner:
    if not closed and at in (0, len(points) - 1):
        return _Corner()
    before, here, after = points[at - 1], points[at], points[(at + 1) % len(points)]
    first, second = (here[0] - before[0], here[1] - before[1]), (after[0] - here[0], after[1] - here[1])
    turn = atan2(first[0] * second[1] - first[1] * second[0], first[0] * second[0] + first[1] * second[1])
    return _Corner(turn, abs(fillet * tan(0.5 * turn)) if abs(turn) < pi else inf)


def polar(rows: Sequence[Point]) -> PlaneCurve:
    """The periodic cubic spline through (angle in rad, radius in m). The last row is the first one a turn later."""
    table: CubicTable = periodic(rows[:-1], FULL_TURN)
    pieces = [
        Piece(knot, origin, Form.POLAR, polynomial(cubic))
        for knot, origin, cubic in zip(table.knots, table.origins, table.pieces, strict=True)
    ]
    return PlaneCurve(tuple(pieces), table.knots[0] + FULL_TURN, True)


def of_law(base: float, rises: Sequence[Rise], followed: CamFollower, clockwise: bool) -> PlaneCurve:
    """The curve of a cam with the base radius `base` in m: the path of the point or of the roller's centre, or, for a
    flat face, the profile. The lift is a function of the angle about the axis from x, counterclockwise or `clockwise`.
    The follower moves on a line through the axis."""
    first = base + followed.radius
    form = Form.SUPPORT if followed.kind == "flat" else Form.POLAR
    pieces, s, lift = list[Piece](), 0.0, rises[-1].to
    for each in rises:
        for part in LAWS[each.law]:
            numbers = part.numbers(first + lift, each.to - lift, each.angle)
            pieces.append(Piece(s + part.start * each.angle, s, form, numbers))
        s, lift = s + each.angle, each.to
    whole = PlaneCurve(tuple(pieces), FULL_TURN, True)
    return reflected(whole) if clockwise else whole


def reflected(curve: PlaneCurve) -> PlaneCurve:
    """The mirror image of a curve whose parameter is an angle: the point at s moves to 2π - s."""
    ends = [*(each.start for each in curve.pieces[1:]), curve.end]
    pieces = [
        replace(each, start=FULL_TURN - end, origin=FULL_TURN - each.origin, f=mirrored(each.f))
        for each, end in zip(curve.pieces, ends, strict=True)
    ]
    return PlaneCurve(tuple(reversed(pieces)), FULL_TURN, True)


def points_along(curve: PlaneCurve, distance: float = 0.0) -> list[Point]:
    """Points along a curve, or along its offset curve at this `distance` in m to the left."""
    places = curve.places
    slope = curve.arrays.derivatives(places.s, places.piece)[1]
    across = distance / (slope[0] ** 2 + slope[1] ** 2) ** 0.5
    x, y = places.point[:, 0] - across * slope[1], places.point[:, 1] + across * slope[0]
    return list(zip(x.tolist(), y.tolist(), strict=True))
