"""Faults of a curve, or of a roller on it: crossings, corners, and places where the roller does not fit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.plane_curve import PlaneCurve

#: The relative accuracy of searches among places.
ROUGHLY = 1e-6
#: The number of times that the neighbourhood of the largest curvature is divided by 8.
REFINED = 8


class At(NamedTuple):
    """A point (x, y) of a curve in m, and the `value` that is sought there."""

    x: float
    y: float
    value: float


def crossing(curve: PlaneCurve) -> At | None:
    """Where a curve crosses itself: the middle of a chord that crosses another one, and its parameter; None where no
    chords cross."""
    point = curve.places.point
    start, end = point[:-1], point[1:]
    length = np.linalg.norm(end - start, axis=1)
    chord = np.flatnonzero(length > ROUGHLY * length.max())  # not from the end of a piece to the start of the next
    start, end = start[chord], end[chord]
    of_start, of_end = _sides(start, end, start), _sides(start, end, end)
    apart = of_start * of_end < 0.0
    both = np.triu(apart & apart.T, 2)
    both[0, -1] &= not curve.closed  # neighbours
    crossings = np.argwhere(both)
    if not len(crossings):
        return None
    i = int(crossings[0, 0])
    return _at(0.5 * (start[i] + end[i]), curve.places.s[chord[i]])


def _at(point: Array, value: float) -> At:
    return At(float(point[0]), float(point[1]), float(value))


def _sides(start: Array, end: Array, point: Array) -> Array:
    """The side of the line of chord i on which point j lies, (m, m): positive on the left."""
    line, to = (end - start)[:, None, :], point[None, :, :] - start[:, None, :]
    return np.asarray(line[..., 0] * to[..., 1] - line[..., 1] * to[..., 0])


def corner(curve: PlaneCurve) -> At | None:
    """The knot at which the tangent jumps most, and the angle in rad; None where the curve is smooth."""
    ends = np.array([*(each.start for each in curve.pieces[1:]), curve.end])
    last = np.arange(len(curve.pieces))
    after = np.roll(last, -1)
    starts = np.array([each.start for each in curve.pieces])[after]
    count = len(curve.pieces) if curve.closed else len(curve.pieces) - 1
    one, other = curve.derivatives(ends, last), curve.derivatives(starts, after)
    turn = np.arctan2(one[1, 0] * other[1, 1] - one[1, 1] * other[1, 0], (one[1] * other[1]).sum(axis=0))[:count]
    worst = int(np.argmax(np.abs(turn))) if count else 0
    if not count or abs(turn[worst]) <= THRESHOLDS.half_digits:
        return None
    return _at(one[0, :, worst], turn[worst])


def curvature(curve: PlaneCurve, s: Array | None = None, piece: Integers | None = None) -> Array:
    """The curvature κ in 1/m, (m,), positive where the curve turns left: at parameters of pieces, or at the places."""
    if s is None or piece is None:
        s, piece = curve.places.s, curve.places.piece
    _, (x1, y1), (x2, y2), _ = curve.derivatives(s, piece)
    return np.asarray((x1 * y2 - y1 * x2) / (x1 * x1 + y1 * y1) ** 1.5)


def most_bent(curve: PlaneCurve, left: bool) -> float:
    """The largest curvature κ in 1/m, to the `left`; or the least, to the right. It is sought between places, too."""
    side, places = 1.0 if left else -1.0, curve.places
    k = int(np.argmax(side * curvature(curve)))
    near = np.flatnonzero(places.piece == places.piece[k])
    low, high = places.s[max(k - 1, near[0])], places.s[min(k + 1, near[-1])]
    for _ in range(REFINED):  # each time the place with the largest of its neighbours
        s = np.linspace(low, high, 17)
        bend = side * curvature(curve, s, np.full(17, places.piece[k]))
        at = int(np.argmax(bend))
        low, high = s[max(at - 1, 0)], s[min(at + 1, 16)]
    return side * float(bend[at])


def least_bent(curve: PlaneCurve) -> At:
    """Where a closed curve has its least curvature, and that curvature times the size of the curve. It is negative
    where the curve is hollow."""
    outward = curvature(curve) * (1.0 if curve.turns_left else -1.0)
    worst = int(np.argmin(outward))
    return _at(curve.places.point[worst], outward[worst] * float(np.ptp(curve.places.point, axis=0).max()))


def undercut(curve: PlaneCurve, distance: float) -> At | None:
    """Where 1 - κφ is smallest, with the `distance` φ to the left of the curve in m, and its value there. None where it
    is not below `least_undercut`."""
    left = 1.0 - curvature(curve) * distance
    worst = int(np.argmin(left))
    if left[worst] >= THRESHOLDS.least_undercut:
        return None
    return _at(curve.places.point[worst], left[worst])


def touches_twice(curve: PlaneCurve, distance: float) -> At | None:
    """Where a circle that touches the curve from the left cuts it elsewhere, and the distance of its centre from the
    curve. The radius of the circle is `distance` in m; negative: to the right. None where none does."""
    places = curve.places
    slope = curve.derivatives(places.s, places.piece)[1]
    across = np.array([-slope[1], slope[0]]) / np.sqrt(slope[0] ** 2 + slope[1] ** 2)
    centre = places.point + distance * across.T
    s, piece = curve.foot(centre)
    nearest = np.linalg.norm(np.moveaxis(curve.derivatives(s, piece)[0], 0, -1) - centre, axis=-1)
    worst = int(np.argmin(nearest))
    if nearest[worst] >= abs(distance) * (1.0 - ROUGHLY):
        return None
    return _at(places.point[worst], nearest[worst])


def largest_roller(curve: PlaneCurve, left: bool, offset: float = 0.0, margin: float = 0.0) -> float:
    """The largest radius in m of a roller on the `left` or right side of a curve whose profile is `offset` m to its
    left. The roller must not touch the curve twice, nor undercut it: 1 - κφ stays above the `margin`."""
    side = 1.0 if left else -1.0
    size = float(np.ptp(curve.places.point, axis=0).max())
    bends = {left: most_bent(curve, left) for left in (True, False)}

    def fits(radius: float) -> bool:
        distance = side * radius + offset
        return 1.0 - bends[distance > 0.0] * distance > margin and touches_twice(curve, distance) is None

    if fits(size):
        return np.inf
    low, high = 0.0, size
    while high - low > ROUGHLY * size:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
