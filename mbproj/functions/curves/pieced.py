"""What curves in a plane and in space have in common: pieces one after another, places along them, arc lengths."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.functions.program import COORDINATE, Program, variable
from mbproj.functions.standard import tabulated
from mbproj.functions.table import CubicTable

#: Nodes and weights of Gauss and Legendre on [-1, 1]: between two places they give arc lengths to round-off.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
#: Of the largest parameter; Newton squares it.
SETTLED = 1e-9
#: No piece is held: the foot is looked for on all of them.
FREE = -1


class CurvePlaces(Protocol):
    """Points along a curve: their parameters, pieces, and arc lengths from its beginning, (m,)."""

    @property
    def s(self) -> Array: ...
    @property
    def piece(self) -> Integers: ...
    @property
    def length(self) -> Array: ...


class PiecedCurve(ABC):
    """Pieces one after another, in m, until the parameter is `end`. A closed one begins again there.

    A piece goes on beyond its ends as its functions do, so that a step may look beyond a knot.
    """

    pieces: tuple[Any, ...]
    end: float
    closed: bool

    @cached_property
    def hash_of_numbers(self) -> int:
        """Of all numbers, once: a curve is looked up by each row that follows it."""
        return hash((self.pieces, self.end, self.closed))

    @cached_property
    def contacts(self) -> dict[tuple[object, ...], Any]:
        """Feet of the last points, for whoever asks again."""
        return {}

    @property
    @abstractmethod
    def places(self) -> CurvePlaces:
        """Points so near to each other that the one nearest to a point is next to that one's foot."""

    @abstractmethod
    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """The point and its first three derivatives at parameters (...) of these pieces, (4, axes, ...)."""

    @cached_property
    def starts(self) -> Array:
        """Where the pieces begin, (n,)."""
        return np.array([each.start for each in self.pieces])

    @property
    def start(self) -> float:
        """The parameter with which it begins."""
        return float(self.pieces[0].start)

    @cached_property
    def period(self) -> float:
        """Of the parameter; 0 of a curve that is open."""
        return self.end - self.start if self.closed else 0.0

    @property
    def length(self) -> float:
        """From its beginning to its end, in m."""
        return float(self.places.length[-1])

    @cached_property
    def knots(self) -> Program:
        """The parameter itself as a table whose pieces are those of the curve: its switches are the curve's knots."""
        return knots_at(self.starts.tolist(), self.period)

    @cached_property
    def reach(self) -> float:
        """How far a step of Newton's method may go: as far as places are from each other."""
        return float(np.abs(np.diff(self.places.s)).max())

    @property
    def settled(self) -> float:
        """A step of Newton's method that is smaller is the last."""
        return SETTLED * max(abs(self.start), abs(self.end))

    def at(self, s: Numbers) -> Integers:
        """The pieces at parameters (...)."""
        return np.clip(np.searchsorted(self.starts, s.real, side="right") - 1, 0, len(self.pieces) - 1)

    def moved(self, s: Array, piece: Integers, held: int) -> tuple[Array, Integers]:
        """Parameters and the pieces that they are on."""
        if held != FREE:
            return s, piece
        if self.closed:
            s = self.start + np.mod(s - self.start, self.period)
        return s, self.at(s)

    def length_at(self, s: Numbers, piece: Integers) -> Numbers:
        """The arc length from the beginning to parameters (...) of these pieces, which may be complex; beyond the ends
        of an open curve it goes on."""
        before = self.before(s, piece)
        return self.places.length[before] + self.lengths(self.places.s[before], s, piece)

    def before(self, s: Numbers, piece: Integers) -> Integers:
        """The places before parameters (...) on these pieces."""
        places = self.places
        first = np.searchsorted(places.piece, piece)
        last = np.searchsorted(places.piece, piece, side="right") - 2
        return np.clip(np.searchsorted(places.s, s.real, side="right") - 1, first, last)

    def lengths(self, start: Numbers, end: Numbers, piece: Integers) -> Numbers:
        """Arc lengths from start to end (...), on these pieces; either may be complex."""
        half = 0.5 * (end - start)
        s = (start + half)[..., None] + half[..., None] * NODES
        slope = self.derivatives(s, np.broadcast_to(piece[..., None], s.shape))[1]
        return np.asarray(half * (np.sqrt((slope * slope).sum(axis=0)) * WEIGHTS).sum(axis=-1))


def knots_at(start: Sequence[float], period: float) -> Program:
    """The parameter itself as a table of pieces that begin there; `period`: 0 of a curve that is open."""
    knots = tuple(start if period else [-np.inf, *start[1:]])
    # each piece is its own number, so that no two are taken for one
    rows = tuple((float(at % 2), 0.0, 0.0, 0.0) for at in range(len(start)))
    return Program(tabulated(CubicTable(knots, tuple(start), rows, period), variable(COORDINATE)))
