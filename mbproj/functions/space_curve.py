"""Curves in space: cubic pieces through points, the foot of a point, and the arc length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise, product
from math import dist
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.curve_pieces import FREE, PiecedCurve
from mbproj.functions.plane_curve import PlaneCurve
from mbproj.functions.table import periodic, spline

Point3 = tuple[float, float, float]
#: Candidates for the direction of each piece that is farthest from its tangents.
DIRECTIONS = np.array([each for each in product((-1.0, 0.0, 1.0), repeat=3) if each > (0.0, 0.0, 0.0)])


class SpacePiece(NamedTuple):
    """A piece from the parameter `start` on: the coefficients of x, y and z as cubic functions of s - origin."""

    start: float
    origin: float
    coefficients: tuple[tuple[float, ...], ...]


class SpacePlaces(NamedTuple):
    """Points (m, 3) along a curve: their parameters, pieces and arc lengths from the start in m, (m,) each."""

    s: Array
    piece: Integers
    point: Array
    length: Array


@dataclass(frozen=True)
class SpaceCurve(PiecedCurve):
    """A curve in space, of cubic pieces."""

    pieces: tuple[SpacePiece, ...]
    end: float
    closed: bool

    def __hash__(self) -> int:
        return self.hash_of_numbers

    def scaled(self, k: float) -> SpaceCurve:
        """The curve k times as large, with the same parameter."""
        pieces = tuple(
            each._replace(coefficients=tuple(tuple(k * c for c in row) for row in each.coefficients))
            for each in self.pieces
        )
        return replace(self, pieces=pieces)

    @cached_property
    def origins(self) -> Array:
        """The origins of the pieces' parameters, (n,)."""
        return np.array([each.origin for each in self.pieces])

    @cached_property
    def coefficients(self) -> Array:
        """The coefficients of the pieces, (n, 3, 4)."""
        return np.array([each.coefficients for each in self.pieces])

    @cached_property
    def axes(self) -> Array:
        """A direction for each piece to which its tangents are never parallel, (n, 3)."""
        directions, ends = [], [*self.starts[1:].tolist(), self.end]
        for at, (start, end) in enumerate(zip(self.starts.tolist(), ends, strict=True)):
            slope = self.derivatives(np.linspace(start, end, 33), np.full(33, at))[1]
            tangent = slope / np.linalg.norm(slope, axis=0)
            unit = DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1)[:, None]
            directions.append(unit[np.argmin(np.abs(unit @ tangent).max(axis=1))])
        return np.array(directions)

    @cached_property
    def places(self) -> SpacePlaces:
        """Points on the curve, so dense that the one nearest to a point is next to the point's foot."""
        ends, parts = [*self.starts[1:].tolist(), self.end], []
        for at, (start, end) in enumerate(zip(self.starts.tolist(), ends, strict=True)):
            slope = self.derivatives(np.linspace(start, end, 65), np.full(65, at))[1]
            tangent = slope / np.linalg.norm(slope, axis=0)
            turn = np.arccos(np.clip((tangent[:, 1:] * tangent[:, :-1]).sum(axis=0), -1.0, 1.0)).max()
            count = max(2, int(np.ceil(64.0 * turn / THRESHOLDS.place_turn)))
            parts.append((np.linspace(start, end, count + 1), np.full(count + 1, at, dtype=np.intp)))
        s, piece = (np.concatenate(part) for part in zip(*parts, strict=True))
        steps = self.lengths(s[:-1], s[1:], piece[:-1])
        steps[piece[1:] != piece[:-1]] = 0.0
        return SpacePlaces(s, piece, self.derivatives(s, piece)[0].T, np.concatenate([[0.0], np.cumsum(steps)]))

    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """The point and its first three derivatives at parameters (...) of these pieces, (4, 3, ...)."""
        u = s - self.origins[piece]
        c = np.moveaxis(self.coefficients[piece], (-2, -1), (0, 1))  # (3, 4, ...)
        return np.stack(
            [
                c[:, 0] + u * (c[:, 1] + u * (c[:, 2] + u * c[:, 3])),
                c[:, 1] + u * (2.0 * c[:, 2] + u * 3.0 * c[:, 3]),
                2.0 * c[:, 2] + 6.0 * u * c[:, 3],
                6.0 * c[:, 3] + 0.0 * u,
            ]
        )

    def foot(self, d: Numbers, held: int = FREE) -> tuple[Numbers, Integers]:
        """The parameters of the feet of points d (..., 3), which may be complex, and their pieces. Where a piece is
        `held` the feet are on it, or on its continuation beyond the ends."""
        return self._settled(d, self._nearest, self._newton, held)

    def _newton(self, d: Numbers, s: Numbers, piece: Integers) -> Numbers:
        """The Newton step to (d - c)·c' = 0; the Gauss-Newton step where Newton's would lead away from the minimum."""
        c, c1, c2, _ = self.derivatives(s, piece)
        line, speed2 = d.T - c, (c1 * c1).sum(axis=0)
        slope = (line * c2).sum(axis=0) - speed2
        return np.asarray(-(line * c1).sum(axis=0) / np.where(slope.real < 0.0, slope, -speed2))


def through_space(points: Sequence[Point3], closed: bool) -> SpaceCurve:
    """The cubic spline through points, with natural ends or `closed`. Its parameter is the sum of the chords in m."""
    whole = [*points, points[0]] if closed else [*points]
    s = [0.0]
    for one, other in pairwise(whole):
        s.append(s[-1] + dist(one, other))
    tables = [
        periodic(rows[:-1], s[-1]) if closed else spline(rows, "natural")
        for rows in ([(at, point[k]) for at, point in zip(s, whole, strict=True)] for k in range(3))
    ]
    pieces = [
        SpacePiece(knot, origin, tuple(tuple(table.pieces[at]) for table in tables))
        for at, (knot, origin) in enumerate(zip(tables[0].knots, tables[0].origins, strict=True))
    ]
    return SpaceCurve(tuple(pieces if closed else pieces[1:-1]), s[-1], closed)


# --- Named curves of a scene, with the follower for which each was made -----------------------------------------------


@dataclass(frozen=True)
class Track:
    """A curve in a plane. `line` is the curve that is followed. For a curve that was made for a `roller` of this radius
    in m, it is the path of the roller's centre; the profile then lies inside, at this distance to the left. `rows` are
    the points, or angles and radii, from which it was drawn. `flat`: whether it was made for a flat face."""

    name: str
    line: PlaneCurve
    roller: float = 0.0
    rows: tuple[tuple[float, float], ...] = ()
    flat: bool = False

    def scaled(self, k: float) -> Track:
        """The track k times as large."""
        return Track(self.name, self.line.scaled(k), k * self.roller, flat=self.flat)

    def is_left(self, side: str | None) -> bool:
        """Whether a follower on this `side`, by default the outside, is on the left of the curve."""
        if side in ("left", "right"):
            return side == "left"
        return (side == "inside") == self.line.turns_left

    def distance(self, side: str | None, radius: float) -> float:
        """The distance in m to the left of the line of the centre of a roller that touches the profile."""
        return (radius if self.is_left(side) else -radius) + self.roller


@dataclass(frozen=True)
class SpaceTrack:
    """A curve in space."""

    name: str
    line: SpaceCurve

    def scaled(self, k: float) -> SpaceTrack:
        """The track k times as large."""
        return SpaceTrack(self.name, self.line.scaled(k))
