"""Plane curves: their places, the foot of a point, and the arc length."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dataclass import dataclass
from mbproj.functions.curves.evaluated import Pieces
from mbproj.functions.curves.pairs import TurningRun, runs_of, touching
from mbproj.functions.curves.piece import Piece, scaled
from mbproj.functions.curves.pieced import FREE, PiecedCurve
from mbproj.thresholds import THRESHOLDS

#: A function of points (k, 2) and the held piece that returns parameters and pieces near the feet. `Step` is a function
#: that returns a step of Newton's method from there.
Start: TypeAlias = "Callable[[Array, int], tuple[Array, Integers]]"
Step: TypeAlias = "Callable[[Numbers, Numbers, Integers], Numbers]"


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
        return self._settled(m, self._turned, self._newton_facing, held)

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

    def _settled(self, d: Numbers, near: Start, newton: Step, held: int) -> tuple[Numbers, Integers]:
        """The parameters at which Newton's method ends for each of d (..., 2), and their pieces."""
        flat = d.reshape(-1, 2)
        s, piece = near(flat.real, held)
        active, reach = np.arange(len(flat)), self.reach
        for _ in range(THRESHOLDS.most_passes):
            point = flat[active].real
            step = np.clip(newton(point, s[active], piece[active]), -reach, reach)
            s[active], piece[active] = self.moved(s[active] + step, piece[active], held)
            active = active[np.abs(step) > self.settled]  # the next step would be round-off
            if not len(active):
                break
        feet: Numbers = s
        if np.iscomplexobj(d):
            for _ in range(2):  # the first step brings the derivative, the second corrects the first's round-off
                feet = feet + newton(flat, feet, piece)
        return feet.reshape(d.shape[:-1]), piece.reshape(d.shape[:-1])

    def _nearest(self, point: Array, held: int) -> tuple[Array, Integers]:
        """The parameters and pieces of the places nearest to points (k, 2)."""
        places = self.places
        allowed = np.arange(len(places.s)) if held == FREE else np.flatnonzero(places.piece == held)
        nearest = np.empty(len(point), dtype=np.intp)
        for block in range(0, len(point), 256):
            line = point[block : block + 256, None, :] - places.point[allowed]
            nearest[block : block + 256] = np.argmin((line * line).sum(axis=-1), axis=-1)
        return places.s[allowed[nearest]].copy(), places.piece[allowed[nearest]].copy()

    def _turned(self, m: Array, held: int) -> tuple[Array, Integers]:
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
        before = self.before(s, piece)
        slope = self.arrays.derivatives(s, piece)[1]
        cosine, sine = np.cos(self.places.angle[before]), np.sin(self.places.angle[before])
        across, along = cosine * slope[1] - sine * slope[0], cosine * slope[0] + sine * slope[1]
        return self.places.angle[before] - self.places.angle[0] + np.arctan(across / along)
