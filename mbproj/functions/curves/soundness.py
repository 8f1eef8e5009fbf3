"""What is wrong with a curve, or with a roller on it: crossings, cusps, places where it does not fit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.functions.curves.plane_curve import PlaneCurve
from mbproj.thresholds import THRESHOLDS

#: What is looked for among places is found to this part.
ROUGHLY = 1e-6


class At(NamedTuple):
    """A place of a curve (x, y) in m, and what was found there."""

    x: float
    y: float
    found: float


def crossing(curve: PlaneCurve) -> At | None:
    """Where a curve crosses itself: the middle of one of two chords that do; None where none do."""
    point = curve.places.point
    start, end = point[:-1], point[1:]
    length = np.linalg.norm(end - start, axis=1)
    chord = np.flatnonzero(length > ROUGHLY * length.max())  # none from the end of a piece to the start of the next
    start, end = start[chord], end[chord]
    of_start, of_end = _sides(start, end, start), _sides(start, end, end)
    apart = of_start * of_end < 0.0
    both = np.triu(apart & apart.T, 2)
    both[0, -1] &= not curve.closed  # neighbours
    found = np.argwhere(both)
    if not len(found):
        return None
    i = int(found[0, 0])
    return _at(0.5 * (start[i] + end[i]), curve.places.s[chord[i]])


def _at(point: Array, found: float) -> At:
    return At(float(point[0]), float(point[1]), float(found))


def _sides(start: Array, end: Array, point: Array) -> Array:
    """Of which side of the line of chord i (m,) each point j (m,) is, (m, m)."""
    line, to = (end - start)[:, None, :], point[None, :, :] - start[:, None, :]
    return np.asarray(line[..., 0] * to[..., 1] - line[..., 1] * to[..., 0])


def corner(curve: PlaneCurve) -> At | None:
    """A knot at which the tangent turns; None where there is none."""
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


def curvature(curve: PlaneCurve) -> Array:
    """κ at the places, (m,), positive where it turns to the left."""
    _, (x1, y1), (x2, y2), _ = curve.derivatives(curve.places.s, curve.places.piece)
    return np.asarray((x1 * y2 - y1 * x2) / (x1 * x1 + y1 * y1) ** 1.5)


def least_bent(curve: PlaneCurve) -> At:
    """Where a closed curve bulges outward least, and its curvature there times its size; negative: hollow."""
    outward = curvature(curve) * (1.0 if curve.turns_left else -1.0)
    worst = int(np.argmin(outward))
    return _at(curve.places.point[worst], outward[worst] * float(np.ptp(curve.places.point, axis=0).max()))


def undercut(curve: PlaneCurve, distance: float) -> At | None:
    """Where 1 - κφ is smallest at a distance φ to the left of the curve, if it is below `least_undercut` there."""
    left = 1.0 - curvature(curve) * distance
    worst = int(np.argmin(left))
    if left[worst] >= THRESHOLDS.least_undercut:
        return None
    return _at(curve.places.point[worst], left[worst])


def touches_twice(curve: PlaneCurve, distance: float) -> At | None:
    """A place from which a circle at that distance to the left, which touches the curve there, goes through it."""
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


def largest_roller(curve: PlaneCurve, left: bool, offset: float = 0.0) -> float:
    """The largest radius that fits on the side `left` or right of a curve whose profile is `offset` to its left: up to
    `least_undercut`, and without touching twice."""
    side = 1.0 if left else -1.0
    size = float(np.ptp(curve.places.point, axis=0).max())

    def fits(radius: float) -> bool:
        distance = side * radius + offset
        return undercut(curve, distance) is None and touches_twice(curve, distance) is None

    if fits(size):
        return np.inf
    low, high = 0.0, size
    while high - low > ROUGHLY * size:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
