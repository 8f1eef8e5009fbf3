"""A curve in a plane: its places, the foot of a point on it, and its arc length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dataclass import dataclass
from mbproj.functions.curves.evaluated import Pieces
from mbproj.functions.curves.pairs import Run, runs_of, touching
from mbproj.functions.curves.piece import Piece, scaled
from mbproj.functions.program import COORDINATE, Program, variable
from mbproj.functions.standard import tabulated
from mbproj.functions.table import CubicTable
from mbproj.thresholds import THRESHOLDS

#: Nodes and weights of Gauss and Legendre on [-1, 1]: between two places they give arc lengths to round-off.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
#: Of the largest parameter; Newton squares it.
SETTLED = 1e-9
#: From points (k, 2) and the piece held to parameters and pieces near the feet; a step of Newton's method from there.
Start: TypeAlias = "Callable[[Array, int], tuple[Array, Integers]]"
Step: TypeAlias = "Callable[[Numbers, Numbers, Integers], Numbers]"
#: No piece is held: the foot is looked for on all of them.
FREE = -1


class Places(NamedTuple):
    """Points (m, 2) along a curve: their parameters, pieces, arc lengths from its beginning and the angles of their
    tangents, which grow past a turn, (m,). Each piece has its own, from end to end."""

    s: Array
    piece: Integers
    point: Array
    length: Array
    angle: Array


def knots_at(start: Sequence[float], period: float) -> Program:
    """The parameter itself as a table of pieces that begin there; `period`: 0 of a curve that is open."""
    knots = tuple(start if period else [-np.inf, *start[1:]])
    # each piece is its own number, so that no two are taken for one
    rows = tuple((float(at % 2), 0.0, 0.0, 0.0) for at in range(len(start)))
    return Program(tabulated(CubicTable(knots, tuple(start), rows, period), variable(COORDINATE)))


@dataclass(frozen=True)
class PlaneCurve:
    """Pieces one after another, in m, until the parameter is `end`. A closed one begins again there.

    A piece goes on beyond its ends as its functions do, so that a step may look beyond a knot.
    """

    pieces: tuple[Piece, ...]
    end: float
    closed: bool

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        """Of all numbers, once: a curve is looked up by each row that follows it."""
        return hash((self.pieces, self.end, self.closed))

    def scaled(self, k: float) -> PlaneCurve:
        """The same k times as large, with the same parameter."""
        pieces = tuple(replace(each, f=scaled(each.f, k), g=scaled(each.g, k)) for each in self.pieces)
        return replace(self, pieces=pieces)

    @cached_property
    def contacts(self) -> dict[tuple[object, ...], Any]:
        """Feet of the last points, for whoever asks again."""
        return {}

    @cached_property
    def arrays(self) -> Pieces:
        """The pieces as arrays."""
        return Pieces(self.pieces)

    @property
    def start(self) -> float:
        """The parameter with which it begins."""
        return self.pieces[0].start

    @cached_property
    def period(self) -> float:
        """Of the parameter; 0 of a curve that is open."""
        return self.end - self.start if self.closed else 0.0

    @property
    def length(self) -> float:
        """From its beginning to its end, in m."""
        return float(self.places.length[-1])

    @property
    def turn(self) -> float:
        """By how much its tangent turns from its beginning to its end, in rad."""
        return float(self.places.angle[-1] - self.places.angle[0])

    @cached_property
    def turns_left(self) -> bool:
        """Whether a closed one goes around its inside counterclockwise."""
        x, y = self.places.point.T
        return bool(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0.0)

    @cached_property
    def places(self) -> Places:
        """Points so near to each other that the one nearest to a point is next to that one's foot."""
        ends = [*self.arrays.start[1:].tolist(), self.end]
        lengths = [
            self._length_of(start, end, at) for at, (start, end) in enumerate(zip(self.arrays.start, ends, strict=True))
        ]
        found = []
        for at, (start, end) in enumerate(zip(self.arrays.start.tolist(), ends, strict=True)):
            count = max(1, int(np.ceil(THRESHOLDS.places * lengths[at] / sum(lengths))), self._turn_of(start, end, at))
            found.append((np.linspace(start, end, count + 1), np.full(count + 1, at, dtype=np.intp)))
        s, piece = (np.concatenate(part) for part in zip(*found, strict=True))
        steps = self._lengths(s[:-1], s[1:], piece[:-1])
        steps[piece[1:] != piece[:-1]] = 0.0
        (x, y), (x1, y1), *_ = self.arrays.derivatives(s, piece)
        point, length = np.column_stack([x, y]), np.concatenate([[0.0], np.cumsum(steps)])
        return Places(s, piece, point, length, np.unwrap(np.arctan2(y1, x1)))

    def _turn_of(self, start: float, end: float, piece: int) -> int:
        """Into how many parts a piece is taken so that none turns by more than `place_turn`."""
        s = np.linspace(start, end, 65)
        tangent = self.arrays.derivatives(s, np.full(65, piece))[1]
        angle = np.unwrap(np.arctan2(tangent[1], tangent[0]))
        return int(np.ceil(64.0 * np.abs(np.diff(angle)).max() / THRESHOLDS.place_turn))

    def _length_of(self, start: float, end: float, piece: int) -> float:
        """Of a piece, roughly."""
        s = np.linspace(start, end, 33)
        return float(self._lengths(s[:-1], s[1:], np.full(32, piece)).sum())

    def _lengths(self, start: Numbers, end: Numbers, piece: Integers) -> Numbers:
        """Arc lengths from start to end (...), on these pieces; either may be complex."""
        half = 0.5 * (end - start)
        s = (start + half)[..., None] + half[..., None] * NODES
        slope = self.arrays.derivatives(s, np.broadcast_to(piece[..., None], s.shape))[1]
        return half * (np.sqrt(slope[0] ** 2 + slope[1] ** 2) * WEIGHTS).sum(axis=-1)

    @cached_property
    def knots(self) -> Program:
        """The parameter itself as a table whose pieces are those of the curve: its switches are the curve's knots."""
        return knots_at([each.start for each in self.pieces], self.period)

    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """The point and its first three derivatives at parameters (...) of these pieces, (4, 2, ...)."""
        return self.arrays.derivatives(s, piece)

    def at(self, s: Numbers) -> Integers:
        """The pieces at parameters (...)."""
        return np.clip(np.searchsorted(self.arrays.start, s.real, side="right") - 1, 0, len(self.pieces) - 1)

    def foot(self, d: Numbers, held: int = FREE) -> tuple[Numbers, Integers]:
        """The parameters of the places nearest to points d (..., 2), and their pieces: of one piece where that is
        `held`, beyond its ends too. What a point's foot is depends on no other point."""
        return self._settled(d, self._nearest, self._newton, held)

    def facing(self, m: Numbers, held: int = FREE) -> tuple[Numbers, Integers]:
        """The same of the places whose outward normals point along m (..., 2); of a closed curve that is convex."""
        return self._settled(m, self._turned, self._newton_facing, held)

    def touching(
        self, other: PlaneCurve, d: Numbers, angle: Numbers, opposite: bool, held: tuple[int, int] = (FREE, FREE)
    ) -> tuple[Numbers, Integers]:
        """The parameters of the feet (..., 2) on this curve and another one, which is turned by angles (...) and moved
        by d (..., 2), and their pieces. Their tangents are parallel there, or `opposite`."""
        return touching((self, other), d, angle, opposite, held)

    @cached_property
    def runs(self) -> tuple[Run, ...]:
        """Of places along which the tangent turns one way."""
        return runs_of(self.places.angle)

    def _settled(self, d: Numbers, near: Start, newton: Step, held: int) -> tuple[Numbers, Integers]:
        """The parameters at which Newton's method ends for each of d (..., 2), and their pieces."""
        flat = d.reshape(-1, 2)
        s, piece = near(flat.real, held)
        active, reach = np.arange(len(flat)), self.reach
        for _ in range(THRESHOLDS.foot_passes):
            point = flat[active].real
            step = np.clip(newton(point, s[active], piece[active]), -reach, reach)
            s[active], piece[active] = self.moved(s[active] + step, piece[active], held)
            active = active[np.abs(step) > self.settled]  # the step after would be round-off
            if not len(active):
                break
        found: Numbers = s
        if np.iscomplexobj(d):
            for _ in range(2):  # the first brings the derivative, the second what the first has rounded
                found = found + newton(flat, found, piece)
        return found.reshape(d.shape[:-1]), piece.reshape(d.shape[:-1])

    def _nearest(self, point: Array, held: int) -> tuple[Array, Integers]:
        """The places nearest to points (k, 2)."""
        places = self.places
        own = np.arange(len(places.s)) if held == FREE else np.flatnonzero(places.piece == held)
        apart = np.empty(len(point), dtype=np.intp)
        for block in range(0, len(point), 256):
            line = point[block : block + 256, None, :] - places.point[own]
            apart[block : block + 256] = np.argmin((line * line).sum(axis=-1), axis=-1)
        return places.s[own[apart]].copy(), places.piece[own[apart]].copy()

    def _turned(self, m: Array, held: int) -> tuple[Array, Integers]:
        """The places whose outward normals are nearest to directions (k, 2)."""
        own = np.arange(len(self.places.s)) if held == FREE else np.flatnonzero(self.places.piece == held)
        angle = self.places.angle[own] - (0.5 if self.turns_left else -0.5) * np.pi
        at = np.argmax(m[:, :1] * np.cos(angle) + m[:, 1:] * np.sin(angle), axis=-1)
        return self.places.s[own[at]].copy(), self.places.piece[own[at]].copy()

    def moved(self, s: Array, piece: Integers, held: int) -> tuple[Array, Integers]:
        """Parameters and the pieces that they are on."""
        if held != FREE:
            return s, piece
        if self.closed:
            s = self.start + np.mod(s - self.start, self.period)
        return s, self.at(s)

    def _newton(self, d: Numbers, s: Numbers, piece: Integers) -> Numbers:
        """The step to (d - c)·c' = 0; by the slope of Gauss and Newton where that of Newton leads away."""
        (x, y), (x1, y1), (x2, y2), _ = self.arrays.derivatives(s, piece)
        u, w, speed2 = d[..., 0] - x, d[..., 1] - y, x1 * x1 + y1 * y1
        slope = u * x2 + w * y2 - speed2
        return -(u * x1 + w * y1) / np.where(slope.real < 0.0, slope, -speed2)

    def _newton_facing(self, m: Numbers, s: Numbers, piece: Integers) -> Numbers:
        """The step to m·c' = 0, where m·c'' < 0."""
        _, (x1, y1), (x2, y2), _ = self.arrays.derivatives(s, piece)
        slope = m[..., 0] * x2 + m[..., 1] * y2
        return -(m[..., 0] * x1 + m[..., 1] * y1) / np.where(slope.real < 0.0, slope, -(x1 * x1 + y1 * y1))

    @cached_property
    def reach(self) -> float:
        """How far a step may go: as far as places are from each other."""
        return float(np.abs(np.diff(self.places.s)).max())

    @property
    def settled(self) -> float:
        """A step of Newton's method that is smaller is the last."""
        return SETTLED * max(abs(self.start), abs(self.end))

    def length_at(self, s: Numbers, piece: Integers) -> Numbers:
        """The arc length from the beginning to parameters (...) of these pieces, which may be complex; beyond the ends
        of an open curve it goes on."""
        before = self._before(s, piece)
        return self.places.length[before] + self._lengths(self.places.s[before], s, piece)

    def angle_at(self, s: Numbers, piece: Integers) -> Numbers:
        """By how much the tangent has turned until there from the beginning, likewise: a turn with each round."""
        before = self._before(s, piece)
        slope = self.arrays.derivatives(s, piece)[1]
        cosine, sine = np.cos(self.places.angle[before]), np.sin(self.places.angle[before])
        across, along = cosine * slope[1] - sine * slope[0], cosine * slope[0] + sine * slope[1]
        return self.places.angle[before] - self.places.angle[0] + np.arctan(across / along)

    def _before(self, s: Numbers, piece: Integers) -> Integers:
        """The places before parameters (...) on these pieces."""
        places = self.places
        first = np.searchsorted(places.piece, piece)
        last = np.searchsorted(places.piece, piece, side="right") - 2
        return np.clip(np.searchsorted(places.s, s.real, side="right") - 1, first, last)
