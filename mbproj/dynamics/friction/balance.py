"""The forces of stops that touch and of dry frictions at one state, and which of them hold, open or slide from there.

With x in coordinates in which the kinetic energy is ½|x|², forces y along rows A change accelerations b to b + A Aᵀy.
A stop pushes, y >= 0, or opens; a friction at rest holds, s'' = 0, with |y| up to its static force, or slides against
it; one that slides has its sliding force. Forces may go by what bearings carry, which is linear in y. These conditions
are fulfilled one after another until all are (non-smooth contact dynamics, Jean and Moreau 1992).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.thresholds import THRESHOLDS

#: How often the direction of slipping is looked for.
MOST_TURNS = 50
#: Rounds of Gauss and Seidel at most.
MOST_ROUNDS = 20_000
#: A larger force has no balance.
HUGE, TINY = 1e200, float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class Balance:
    """S stops that touch and K frictions: rows A (S+K, f) and accelerations b (S+K,) without them. Arrays (K,) of the
    frictions: `static` and `sliding` force, to be multiplied by `loads(y)`; the `direction` in which each slides, 0 at
    rest; the `partner` with which it acts in a plane; the number of the `stop` whose push is its load; -1 for none. One
    that nothing can move begins to slide where its acceleration is larger than `still`."""

    A: Array
    b: Array
    static: Array
    sliding: Array
    direction: Array
    partner: Integers
    stop: Integers
    loads: Callable[[Array], Array]
    still: Array | float = 0.0

    @property
    def stops(self) -> int:
        """S."""
        return len(self.b) - len(self.static)

    @cached_property
    def size(self) -> Array:
        """|A| of each row, 0 of one that nothing can move, (S+K,)."""
        size = np.linalg.norm(self.A, axis=1)
        return np.where(size > THRESHOLDS.no_push * size.max(initial=0.0), size, 0.0)

    @cached_property
    def rests(self) -> Flags:
        """Which frictions are at rest, those in a plane together, (K,)."""
        return self.with_partner(self.direction) == 0.0

    @cached_property
    def in_plane(self) -> Flags:
        """Which frictions act together with their partner on what can move along both, (K,)."""
        able = self.size[self.stops :] > 0.0
        return (self.partner >= 0) & able & able[self.partner]

    @cached_property
    def pushed(self) -> Array:
        """What the push of each stop does together with the frictions that slide by it, (S, f): its row and theirs."""
        found = self.A[: self.stops].copy()
        for k in np.flatnonzero((self.stop >= 0) & ~self.rests):
            found[self.stop[k]] -= self.direction[k] * self.sliding[k] * self.A[self.stops + k]
        return found

    def with_partner(self, values: Array) -> Array:
        """|values| of the frictions (K,), and of those in a plane of both together."""
        both = np.hypot(values, np.where(self.partner >= 0, values[self.partner], 0.0))
        return np.asarray(np.where(self.partner >= 0, both, np.abs(values)))

    def bounds(self, y: Array) -> Array:
        """What frictions at rest hold, (K,)."""
        return self.static * self.loads(y)

    def accelerations(self, y: Array) -> Array:
        """Along all rows, (S+K,)."""
        return np.asarray(self.b + self.A @ (self.A.T @ y))


def forces(problem: Balance) -> Array | None:
    """y where frictions at rest hold if they can all, and else up to their static force; None where there is none."""
    held = _relaxed(problem, bounded=False)
    if held is None:
        return _relaxed(problem, bounded=True)
    if not _beyond(problem, held).any():
        return held
    found = _relaxed(problem, bounded=True)
    return _slipping(problem, held) if found is None else found


def _beyond(problem: Balance, y: Array) -> Flags:
    """Which frictions at rest hold more than they can, (K,)."""
    return problem.rests & (problem.with_partner(y[problem.stops :]) > problem.bounds(y))


def _slipping(problem: Balance, held: Array) -> Array | None:
    """y where those that hold more than they can slide against that: found where friction is so strong beside the push
    that it goes by that one after the other does not lead there. None where that is no answer."""
    slips, y = _beyond(problem, held), held
    for _ in range(MOST_TURNS):
        force = problem.with_partner(y[problem.stops :])
        way = np.where(slips, -y[problem.stops :] / np.where(force > 0.0, force, 1.0), 0.0)
        sliding = replace(
            problem, direction=problem.direction + way, sliding=np.where(slips, problem.static, problem.sliding)
        )
        found = _relaxed(sliding, bounded=True)
        if found is None:
            return None
        moves = sliding.accelerations(found)[problem.stops :] * way
        moves += np.where(problem.partner >= 0, moves[problem.partner], 0.0)
        if (moves[slips] < -THRESHOLDS.no_push * np.abs(problem.b).max(initial=0.0)).any():
            return None
        if np.abs(found - y).max() <= THRESHOLDS.slips * np.abs(found).max():
            return found
        y = found
    return None


def _relaxed(problem: Balance, *, bounded: bool) -> Array | None:
    """y by the method of Gauss and Seidel, projected onto what each force may be; frictions at rest hold any force
    unless `bounded`. None where it does not converge."""
    m, K, size2, rests = problem.stops, len(problem.static), problem.size**2, problem.rests
    y, x, scale = np.zeros(m + K), np.zeros(problem.A.shape[1]), float(np.abs(problem.b).max(initial=0.0))
    steps = np.array([_step(problem, k) for k in range(K)])
    gives = np.einsum("if,if->i", problem.A[:m], problem.pushed)
    slides_by = np.where(rests, -1, problem.stop)
    if (gives[size2[:m] > 0.0] <= 0.0).any():
        return None
    for _ in range(MOST_ROUNDS):
        before, loads = y.copy(), problem.loads(y)
        if not (np.isfinite(y).all() and np.abs(y).max(initial=0.0) < HUGE):
            return None
        slides = -problem.direction * problem.sliding * loads
        bound = problem.static * loads if bounded else np.full(K, np.inf)
        for i in np.flatnonzero(size2[:m]).tolist():
            new = max(y[i] - (problem.b[i] + problem.A[i] @ x) / gives[i], 0.0)
            x += (new - y[i]) * problem.pushed[i]
            y[m:] += np.where(slides_by == i, (y[i] - new) * problem.direction * problem.sliding, 0.0)
            y[i] = new
        for k in range(K):
            i = m + k
            if slides_by[k] >= 0:
                continue
            if not rests[k] or size2[i] == 0.0:
                x += _take(problem, y, i, 0.0 if rests[k] else slides[k])
            elif not problem.in_plane[k]:
                wanted = y[i] - (problem.b[i] + problem.A[i] @ x) / size2[i]
                x += _take(problem, y, i, min(max(wanted, -bound[k]), bound[k]))
            elif problem.partner[k] > k:
                pair = [i, m + int(problem.partner[k])]
                wanted = y[pair] - steps[k] * (problem.b[pair] + problem.A[pair] @ x)
                wanted = wanted * min(1.0, bound[k] / max(float(np.hypot(*wanted)), TINY))
                for at, new in zip(pair, wanted.tolist(), strict=True):
                    x += _take(problem, y, at, new)
        moved = np.abs((y - before) * size2).max(initial=0.0)
        scale = max(scale, float(np.abs(y * size2).max(initial=0.0)))
        settled = np.abs(loads - problem.loads(y)) <= THRESHOLDS.balanced_to * np.abs(loads)
        if moved <= THRESHOLDS.balanced_to * scale and settled.all():
            return y
    return None


def _take(problem: Balance, y: Array, i: int, new: float) -> Array:
    """Puts a new force into y; what that changes x by."""
    change = (new - y[i]) * problem.A[i]
    y[i] = new
    return np.asarray(change)


def _step(problem: Balance, k: int) -> float:
    """The step along both rows of friction in a plane: 1 / the largest eigenvalue of A Aᵀ."""
    if not problem.in_plane[k]:
        return 0.0
    rows = problem.A[[problem.stops + k, problem.stops + int(problem.partner[k])]]
    return 1.0 / float(np.linalg.norm(rows, 2) ** 2)
