"""What holds and what slides from one state on, of stops that touch and of dry frictions: as much sticks as can.

Where rows of stops depend on each other, or on those of frictions at rest, many forces may hold the same. What sticks
does so while some share within all cones carries the load, and how it is shared is the law of `contact_problem`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.friction.balance import TINY, Balance, forces
from mbproj.dynamics.friction.problem import Cone, contact_problem, independent
from mbproj.dynamics.friction.shares import Shares, shares_of
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Balanced:
    """The forces y (S+K,); arrays (K,) of the frictions: which are `stuck`, each by a row of its own; the `direction`
    in which each slides, 0 at rest; and the `part` of its static force that one bears which others hold. `shares`: how
    the stops that touch share their pushes, None where each has a row of its own."""

    y: Array
    stuck: Flags
    direction: Array
    part: Array
    shares: Shares | None = None


class Unbalanced(Exception):
    """No forces were found that fulfil all conditions: the numbers of frictions at rest that are part of it."""

    def __init__(self, frictions: Integers) -> None:
        super().__init__("no balance")
        self.frictions = frictions


def balanced(problem: Balance) -> Balanced:
    """What holds, and what slides from now on: as much sticks as can. Raises Unbalanced."""
    while True:
        shared = _shared(problem)
        yielding = None if shared is not None else _yielding(problem)
        y = next((each for each in (shared, yielding) if each is not None), None)
        y = forces(problem) if y is None else y
        if y is None:
            raise Unbalanced(np.flatnonzero(problem.rests))
        stuck, slips = _held_and_slipping(problem, y, all_hold=shared is not None, yields=yielding is not None)
        if shared is not None or not slips.any():
            shares = shares_of(problem.A[: problem.stops], y[: problem.stops], problem.pushed)
            return Balanced(y, stuck, problem.direction, _parts(problem, y, stuck), shares)
        problem = replace(problem, direction=problem.direction + slips)


def _shared(problem: Balance) -> Array | None:
    """y where rows of stops that touch depend on each other or on those of frictions at rest, and all can hold. None
    where no rows do, or not all can."""
    if not _depend(problem):
        return None
    m, B, rests, pushes = problem.stops, problem.A @ problem.A.T, _able_at_rest(problem), _able(problem)
    y, loads, slides = np.zeros(len(problem.b)), np.zeros(0), ~problem.rests & (problem.stop < 0)
    for _ in range(THRESHOLDS.most_load_passes):
        before, loads = loads, problem.loads(y)
        if len(before) and np.abs(loads - before).max(initial=0.0) <= THRESHOLDS.slips * np.abs(loads).max(initial=0.0):
            return y
        given = np.append(np.zeros(m), np.where(slides, -problem.direction * problem.sliding * loads, 0.0))
        found = contact_problem(B, problem.b + B @ given, _cones(problem, pushes, rests, loads))
        if found is None:
            return None
        y = found + given
    return None


def _able(problem: Balance) -> Integers:
    """The stops that something can move against."""
    return np.flatnonzero(problem.size[: problem.stops] > 0.0)


def _able_at_rest(problem: Balance) -> Flags:
    """The frictions at rest that something can move against, (K,)."""
    return problem.rests & (problem.size[problem.stops :] > 0.0)


def _depend(problem: Balance) -> bool:
    """Whether rows of stops depend on each other, or on those of frictions at rest."""
    pushes = _able(problem)
    held = np.concatenate([pushes, problem.stops + np.flatnonzero(_able_at_rest(problem))])
    return len(pushes) > 0 and len(independent(problem.A @ problem.A.T, held)) < len(held)


def _yielding(problem: Balance) -> Array | None:
    """y of rows that depend on each other where not all can hold: of springs that give by next to nothing. What
    friction bears goes by the pushes of the pass before (Haslinger 1983). None where no rows
    do, where joints have friction too, or where passes do not settle."""
    m, pushes, rests = problem.stops, _able(problem), _able_at_rest(problem)
    if not _depend(problem) or (problem.stop < 0).any():
        return None
    B, y = problem.A @ problem.A.T, np.zeros(len(problem.b))
    first = [k for k in np.flatnonzero(rests).tolist() if not problem.in_plane[k] or problem.partner[k] > k]
    of_pushes = _cones(problem, pushes, np.zeros_like(rests), y[m:])
    for _ in range(THRESHOLDS.most_load_passes):
        before, most = y, (1.0 - THRESHOLDS.slips_beyond) * problem.static * problem.loads(y)
        cones = [Cone(-1, _with_other(problem, k), float(most[k])) for k in first]
        found = contact_problem(
            B, problem.b, [*of_pushes, *cones], THRESHOLDS.springs_give * float(np.diagonal(B).max())
        )
        if found is None:
            return None
        y = found
        if np.abs(y - before).max() <= THRESHOLDS.springs_give * np.abs(y).max():
            part = problem.static * problem.loads(y) / np.where(most > 0.0, most, 1.0)
            y[m:] *= np.where(rests, part, 1.0)  # what slips goes by the push at hand
            return y
    return None


def _with_other(problem: Balance, k: int) -> tuple[int, ...]:
    """The rows of a friction and of the one it acts with in a plane."""
    m = problem.stops
    return (m + k, m + int(problem.partner[k])) if problem.in_plane[k] else (m + k,)


def _cones(problem: Balance, pushes: Integers, rests: Flags, loads: Array) -> list[Cone]:
    """What each contact can do; of what rests a little less, so that it holds for a while."""
    m, most = problem.stops, (1.0 - THRESHOLDS.slips) * problem.static
    found = []
    for stop in pushes.tolist():
        own = np.flatnonzero(problem.stop == stop)
        slides = [k for k in own.tolist() if not problem.rests[k]]
        if slides:
            parts = -problem.direction[slides] * problem.sliding[slides]
            found.append(Cone(stop, tuple(m + k for k in slides), slides=tuple(parts.tolist())))
        else:
            able = tuple(m + k for k in own.tolist() if rests[k])
            found.append(Cone(stop, able, float(most[own].max(initial=0.0))))
    of_joints = np.flatnonzero(rests & (problem.stop < 0)).tolist()
    return [*found, *(Cone(-1, (m + k,), float(most[k] * loads[k])) for k in of_joints)]


def _held_and_slipping(problem: Balance, y: Array, *, all_hold: bool, yields: bool) -> tuple[Flags, Array]:
    """The frictions at rest that hold by independent rows, and the direction in which others begin to slide: none where
    `all_hold`; against their forces where it `yields`, since they hardly move."""
    m, K, size = problem.stops, len(problem.static), problem.size
    bounds, force = problem.bounds(y), problem.with_partner(y[m:])
    inside = (
        problem.rests & (size[m:] > 0.0) & (all_hold | (force < (1.0 - THRESHOLDS.slips) * bounds)) & (bounds > 0.0)
    )
    span, stuck = _Span(problem.A[:m][y[:m] > 0.0]), np.zeros(K, dtype=bool)
    used = np.where(bounds > 0.0, force / np.where(bounds > 0.0, bounds, 1.0), 1.0)
    for k in np.argsort(used, kind="stable"):
        stuck[k] = inside[k] and span.takes(problem.A[m + k])
    acceleration = problem.accelerations(y)[m:]
    moves = problem.with_partner(acceleration) > THRESHOLDS.no_push * np.abs(problem.b).max(initial=0.0)
    begins = problem.with_partner(acceleration) > problem.still
    slips = np.zeros(K)
    for k in np.flatnonzero(problem.rests & ~inside & (not all_hold)).tolist():
        pair = [k, int(problem.partner[k])] if problem.in_plane[k] else [k]
        if size[m + k] == 0.0:
            slips[k] = np.sign(acceleration[k]) if moves[k] and begins[k] else 0.0
        elif (moves[k] and begins[k] and not yields) or not all(span.holds(problem.A[m + each]) for each in pair):
            way = acceleration if (moves[k] and not yields) or force[k] == 0.0 else -y[m:]
            slips[k] = way[k] / max(float(np.linalg.norm(way[pair])), TINY)
    return stuck, slips


def _parts(problem: Balance, y: Array, stuck: Flags) -> Array:
    """Of frictions that rest because others hold them, the part of the static force that they bear; 0 of others."""
    bounds, force = problem.bounds(y), y[problem.stops :]
    bears = problem.rests & ~stuck & (problem.size[problem.stops :] > 0.0) & (bounds > 0.0)
    return np.where(bears, np.clip(force / np.where(bounds > 0.0, bounds, 1.0), -1.0, 1.0), 0.0)


class _Span:
    """What some rows span, which grows by those that it takes."""

    def __init__(self, rows: Array) -> None:
        self._basis: list[Array] = []
        for row in rows:
            self.takes(row)

    def takes(self, row: Array) -> bool:
        """Whether a row was outside; it is inside from now on."""
        rest = self._beyond(row)
        if np.linalg.norm(rest) <= THRESHOLDS.half_digits * np.linalg.norm(row):
            return False
        self._basis.append(rest / np.linalg.norm(rest))
        return True

    def holds(self, row: Array) -> bool:
        """Whether a row is inside."""
        return bool(np.linalg.norm(self._beyond(row)) <= THRESHOLDS.half_digits * np.linalg.norm(row))

    def _beyond(self, row: Array) -> Array:
        for _ in range(2):  # once is not enough for rows that are almost inside (Björck 1994)
            for unit in self._basis:
                row = row - (row @ unit) * unit
        return row
