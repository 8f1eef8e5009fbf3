"""Pieces of a plane curve. A piece has two functions, each a polynomial plus a sine, which give its points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from enum import IntEnum
from functools import cached_property
from typing import Any, Protocol, TypeAlias

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.program import COORDINATE, Program, variable
from mbproj.functions.standard import tabulated
from mbproj.functions.table import CubicTable

#: Numbers of a function: c0 to c7, then a, w and p of a sin(w u + p).
TERMS = 8
NUMBERS = TERMS + 3


class Form(IntEnum):
    """The form in which two functions f and g of u give a point. The parameter is s = origin + u.

    cartesian  (f, g)
    polar      f (cos s, sin s): f is the radius at the polar angle s
    support    f n + f' t with n = (cos s, sin s), t = (-sin s, cos s): f is the distance of the tangent line from the
               origin, s the direction of its normal; the form of curves that a flat face touches
    """

    CARTESIAN = 0
    POLAR = 1
    SUPPORT = 2


@dataclass(frozen=True)
class Piece:
    """A part of a curve, from the parameter `start` on. Its functions f and g are of u = s - origin and have `NUMBERS`
    numbers each."""

    start: float
    origin: float
    form: Form
    f: tuple[float, ...]
    g: tuple[float, ...] = (0.0,) * NUMBERS


def polynomial(coefficients: Sequence[float], wave: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[float, ...]:
    """The numbers of the function Σ c_k u^k + a sin(w u + p). `wave` is (a, w, p)."""
    return (*coefficients, *(0.0,) * (TERMS - len(coefficients)), *wave)


def scaled(numbers: Sequence[float], k: float) -> tuple[float, ...]:
    """The numbers of k times the function."""
    *coefficients, a, w, p = numbers
    return (*(k * c for c in coefficients), k * a, w, p)


def mirrored(numbers: Sequence[float]) -> tuple[float, ...]:
    """The numbers of the function of -u."""
    *coefficients, a, w, p = numbers
    return (*((-1.0) ** k * c for k, c in enumerate(coefficients)), a, -w, p)


# --- The common base of curves in a plane and in space ----------------------------------------------------------------
# A sequence of pieces, places along them, and arc lengths.


#: Gauss-Legendre nodes and weights on [-1, 1]. They give the arc length between two places to round-off.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
#: Newton's method ends after a step below this part of the largest parameter: the next step would square it.
SETTLED = 1e-9
#: No piece is held: the foot is sought on all pieces.
FREE = -1
#: A function of points (k, axes) and the held piece that returns parameters and pieces near the feet, and one that
#: returns a step of Newton's method from there.
Start: TypeAlias = "Callable[[Array, int], tuple[Array, Integers]]"
Step: TypeAlias = "Callable[[Numbers, Numbers, Integers], Numbers]"


class CurvePlaces(Protocol):
    """Interface of m places along a curve: their parameters, pieces, points (m, axes), and arc lengths in m, (m,)."""

    @property
    def s(self) -> Array: ...
    @property
    def piece(self) -> Integers: ...
    @property
    def point(self) -> Array: ...
    @property
    def length(self) -> Array: ...


class PiecedCurve(ABC):
    """A sequence of pieces in m, up to the parameter `end`. A `closed` curve starts again there.

    The functions of a piece continue beyond its ends, so that a time step may evaluate it past a knot.
    """

    pieces: tuple[Any, ...]
    end: float
    closed: bool

    @cached_property
    def hash_of_numbers(self) -> int:
        """The hash of all numbers. It is computed once, since each row that follows a curve looks it up."""
        return hash((self.pieces, self.end, self.closed))

    @cached_property
    def contacts(self) -> dict[tuple[object, ...], Any]:
        """A cache of the feet of the last points."""
        return {}

    @property
    @abstractmethod
    def places(self) -> CurvePlaces:
        """Points on the curve, so dense that the one nearest to a point is next to the point's foot."""

    @abstractmethod
    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """The point and its first three derivatives by s at parameters (...) of these pieces, (4, axes, ...)."""

    @cached_property
    def starts(self) -> Array:
        """The parameters at which the pieces start, (n,)."""
        return np.array([each.start for each in self.pieces])

    @property
    def start(self) -> float:
        """The parameter at the start of the curve."""
        return float(self.pieces[0].start)

    @cached_property
    def period(self) -> float:
        """The period of the parameter; 0 for an open curve."""
        return self.end - self.start if self.closed else 0.0

    @property
    def length(self) -> float:
        """The arc length of the curve in m."""
        return float(self.places.length[-1])

    @cached_property
    def knots(self) -> Program:
        """The parameter as a table with the pieces of the curve. The switches of this program are the curve's knots."""
        return knots_at(self.starts.tolist(), self.period)

    @cached_property
    def reach(self) -> float:
        """The largest step of Newton's method: the largest distance between neighbouring places, as a parameter."""
        return float(np.abs(np.diff(self.places.s)).max())

    @property
    def settled(self) -> float:
        """Newton's method ends after a step smaller than this."""
        return SETTLED * max(abs(self.start), abs(self.end))

    def at(self, s: Numbers) -> Integers:
        """The pieces at parameters (...)."""
        return np.clip(np.searchsorted(self.starts, s.real, side="right") - 1, 0, len(self.pieces) - 1)

    def in_period(self, s: Array, piece: Integers, held: int) -> tuple[Array, Integers]:
        """Parameters within the period of a closed curve, and their pieces. Neither changes where a piece is `held`."""
        if held != FREE:
            return s, piece
        if self.closed:
            s = self.start + np.mod(s - self.start, self.period)
        return s, self.at(s)

    def _settled(self, d: Numbers, near: Start, newton: Step, held: int) -> tuple[Numbers, Integers]:
        """The parameters at which Newton's method ends for each of d (..., axes), and their pieces."""
        flat = d.reshape(-1, d.shape[-1])
        s, piece = near(flat.real, held)
        active, reach = np.arange(len(flat)), self.reach
        for _ in range(THRESHOLDS.most_passes):
            point = flat[active].real
            step = np.clip(newton(point, s[active], piece[active]), -reach, reach)
            s[active], piece[active] = self.in_period(s[active] + step, piece[active], held)
            active = active[np.abs(step) > self.settled]  # the next step would be round-off
            if not len(active):
                break
        feet: Numbers = s
        if np.iscomplexobj(d):
            for _ in range(2):  # the first step brings the derivative, the second corrects the first's round-off
                feet = feet + newton(flat, feet, piece)
        return feet.reshape(d.shape[:-1]), piece.reshape(d.shape[:-1])

    def _nearest(self, point: Array, held: int) -> tuple[Array, Integers]:
        """The parameters and pieces of the places nearest to points (k, axes)."""
        places = self.places
        allowed = np.arange(len(places.s)) if held == FREE else np.flatnonzero(places.piece == held)
        nearest = np.empty(len(point), dtype=np.intp)
        for block in range(0, len(point), 256):
            line = point[block : block + 256, None, :] - places.point[allowed]
            nearest[block : block + 256] = np.argmin((line * line).sum(axis=-1), axis=-1)
        return places.s[allowed[nearest]].copy(), places.piece[allowed[nearest]].copy()

    def length_at(self, s: Numbers, piece: Integers) -> Numbers:
        """The arc length from the start to parameters (...), which may be complex, of these pieces. It continues beyond
        the ends of an open curve."""
        before = self.places_before(s, piece)
        return self.places.length[before] + self.lengths(self.places.s[before], s, piece)

    def places_before(self, s: Numbers, piece: Integers) -> Integers:
        """The numbers of the places before parameters (...) on these pieces."""
        places = self.places
        first = np.searchsorted(places.piece, piece)
        last = np.searchsorted(places.piece, piece, side="right") - 2
        return np.clip(np.searchsorted(places.s, s.real, side="right") - 1, first, last)

    def lengths(self, start: Numbers, end: Numbers, piece: Integers) -> Numbers:
        """The arc lengths from `start` to `end` (...) on these pieces; both may be complex."""
        half = 0.5 * (end - start)
        s = (start + half)[..., None] + half[..., None] * NODES
        slope = self.derivatives(s, np.broadcast_to(piece[..., None], s.shape))[1]
        return np.asarray(half * (np.sqrt((slope * slope).sum(axis=0)) * WEIGHTS).sum(axis=-1))


def knots_at(start: Sequence[float], period: float) -> Program:
    """The parameter as a table of pieces that begin at `start`. `period` is 0 for an open curve."""
    knots = tuple(start if period else [-np.inf, *start[1:]])
    # neighbouring pieces have different values, else the table would join them
    rows = tuple((float(at % 2), 0.0, 0.0, 0.0) for at in range(len(start)))
    return Program(tabulated(CubicTable(knots, tuple(start), rows, period), variable(COORDINATE)))
