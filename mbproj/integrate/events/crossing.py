"""The first crossing in a step: one of several arguments leaves the interval in which it is held.

The arguments and the consequences of a crossing are the caller's. The first use is for kinks of laws.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.thresholds import THRESHOLDS

#: Returns the arguments (K,) at the part θ of a step.
Path = Callable[[float], Array]
#: The parts of a step at which the arguments are evaluated.
LOOKS = (0.25, 0.5, 0.75, 1.0)
#: An argument that starts outside of its interval, by round-off, is evaluated down to a part of 0.5 to this power.
HALVINGS = 40
#: The most evaluations to find a crossing.
MOST_LOOKS = 100


@dataclass(frozen=True, eq=False)
class Bounds:
    """The intervals in which K arguments are held, (K,) each."""

    low: Array
    high: Array

    def excess(self, x: Array) -> Array:
        """Return the excess of each argument beyond its interval; negative inside."""
        return np.maximum(self.low - x, x - self.high)


@dataclass(frozen=True, eq=False)
class Crossing:
    """A crossing at the part `theta` of a step: the argument `leader`, with those in `leaving` (K,), leaves its
    interval.

    `direction` (K,) is upwards (1) or downwards (-1). `at_once`: whether it is so near to the start of the step that no
    step ends there. `rate`: the rate of the leader's excess, per step; positive."""

    theta: float
    at_once: bool
    leader: int
    leaving: npt.NDArray[np.bool_]
    direction: Integers
    rate: float


def first_crossing(path: Path, bounds: Bounds, together: float, shortest: float) -> Crossing | None:
    """Return the first crossing along a path. Arguments that leave within a part `together` of the step leave as one;
    an argument that leaves before the part `shortest` leaves at once."""

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
    """Return the last point, halving the distance from θ to `at`, at which one of the arguments is inside; None without
    one."""
    for halving in range(1, HALVINGS):
        look = at + (theta - at) * 0.5**halving
        if excess(look)[which].max() < 0.0:
            return look
    return None


def _root(excess: Path, which: npt.NDArray[np.bool_], low: float, high: float) -> float:
    """Return the root of the largest of these excesses, negative at `low` and positive at `high`, by the Illinois rule.
    It is the upper end of the last interval."""
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
