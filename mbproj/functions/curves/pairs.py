"""The feet of two curves: the points where their tangents are parallel and the line between them is normal to both.
There the curves touch, or are nearest to touching.

The first curve is fixed; the second is turned by an angle and then moved by d. The places of both curves are passed
side by side, in the order of the angles of their tangents. Newton's method starts where the line from the first to the
second place changes from forward to backward along the tangent. It also starts at the ends, since a piece continues
beyond them. Of several solutions the one with the smallest distance counts.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.functions.curves.plane_curve import PlaneCurve

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
    s = np.stack([curve.places.s[own] for curve, own in zip(curves, at.T, strict=True)])
    piece = np.stack([curve.places.piece[own] for curve, own in zip(curves, at.T, strict=True)])
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
        np.arange(len(curve.places.s)) if own < 0 else np.flatnonzero(curve.places.piece == own)
        for curve, own in zip(curves, held, strict=True)
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
                i, j = (own[at] for own, at in zip((one, other), _merged(a, b + FULL_TURN * turns), strict=True))
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
