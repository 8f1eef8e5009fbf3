"""The first crossing in a step: where one of several arguments leaves the interval in which it is held.

What the arguments are, and what happens where one leaves, is not known here: kinks of laws are the first use.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.thresholds import THRESHOLDS

#: Arguments at a part θ of a step, (K,).
Path = Callable[[float], Array]
#: Where in a step the arguments are looked at.
LOOKS = (0.25, 0.5, 0.75, 1.0)
#: An argument that begins outside of its interval, by round-off, is looked at up to a step's part of 0.5 to this power.
HALVINGS = 40
#: A crossing is found in so many looks at most.
MOST_LOOKS = 100


@dataclass(frozen=True, eq=False)
class Bounds:
    """The intervals in which K arguments are held, (K,) each."""

    low: Array
    high: Array

    def excess(self, x: Array) -> Array:
        """By how much each argument is outside; negative inside."""
        return np.maximum(self.low - x, x - self.high)


@dataclass(frozen=True, eq=False)
class Crossing:
    """At the part `theta` of a step the argument `leader`, and with it those in `leaving` (K,), leave their intervals:
    upwards (1) or downwards (-1) in `direction` (K,). `at_once`: so near to the start of the step that no step ends
    there. `rate`: of the leader's excess, per step; positive."""

    theta: float
    at_once: bool
    leader: int
    leaving: npt.NDArray[np.bool_]
    direction: Integers
    rate: float


def first_crossing(path: Path, bounds: Bounds, together: float, shortest: float) -> Crossing | None:
    """The first along a path. Arguments that leave within a part `together` of the step leave as one; one that leaves
    before the part `shortest` leaves at once."""

    def described(root: float, which: npt.NDArray[np.bool_]) -> Crossing:
        return _described(path, bounds, root, which, together, root <= shortest)

    def excess(theta: float) -> Array:
        return bounds.excess(path(theta))

    at, before = 0.0, excess(0.0)
    for theta in LOOKS:
        now = excess(theta)
        fresh = (now > 0.0) & ~(before > 0.0)
        back = (now > 0.0) & (before > 0.0) & (now > before)
        if fresh.any():
            return described(_root(excess, fresh, at, theta), fresh)
        if back.any():
            inside = _inside(excess, back, at, theta)
            root = at if inside is None else _root(excess, back, inside, min(theta, at + 2.0 * (inside - at)))
            return described(root, back)
        at, before = theta, now
    return None


def _inside(excess: Path, which: npt.NDArray[np.bool_], at: float, theta: float) -> float | None:
    """The last look back from θ, halving what is left to `at`, at which one of them is inside; None where none is."""
    for halving in range(1, HALVINGS):
        look = at + (theta - at) * 0.5**halving
        if excess(look)[which].max() < 0.0:
            return look
    return None


def _root(excess: Path, which: npt.NDArray[np.bool_], low: float, high: float) -> float:
    """Where the largest of these excesses, negative at `low` and positive at `high`, is zero, by the Illinois rule: the
    upper end of the last interval."""
    below, above, side = float(excess(low)[which].max()), float(excess(high)[which].max()), 0
    for _ in range(MOST_LOOKS):
        if high - low <= THRESHOLDS.bracketed:
            break
        theta = high - above * (high - low) / (above - below)
        if not low < theta < high:
            theta = 0.5 * (low + high)
        value = float(excess(theta)[which].max())
        if value > 0.0:
            high, above = theta, value
            below, side = 0.5 * below if side > 0 else below, 1
        else:
            low, below = theta, value
            above, side = 0.5 * above if side < 0 else above, -1
    return high


def _described(
    path: Path, bounds: Bounds, root: float, which: npt.NDArray[np.bool_], together: float, at_once: bool
) -> Crossing:
    first, last = max(root - THRESHOLDS.beside, 0.0), min(root + THRESHOLDS.beside, 1.0)
    slope = (path(last) - path(first)) / (last - first)
    x = path(root)
    excess, direction = bounds.excess(x), np.where(bounds.low - x > x - bounds.high, -1, 1)
    rate = direction * slope
    leader = int(np.flatnonzero(which)[np.argmax(excess[which])])
    leaving = (rate > 0.0) & (excess >= -rate * together)
    leaving[leader] = True
    return Crossing(root, at_once, leader, leaving, direction, float(max(rate[leader], 0.0)))
