"""The shapes of curves that a scene can give, as pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import atan2, hypot, inf, pi, tan
from sys import float_info
from typing import Literal, NamedTuple

from mbproj.functions.curves.laws import LAWS, Rise
from mbproj.functions.curves.piece import Form, Piece, mirrored, polynomial
from mbproj.functions.curves.plane_curve import FULL_TURN, PlaneCurve
from mbproj.functions.table import CubicTable, periodic, spline

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
