"""When a stop is met, or friction sticks or slips: the size of the step that ends there, found on the step itself, so
that its order is that of the method."""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.integrate.events.halts import (
    THROUGH,
    Ends,
    Watched,
    closed_inside,
    cubic,
    lowest,
    may_pass,
    slowest,
    slowest_at,
    watched_gaps,
    watched_rows,
)
from mbproj.integrate.stops.legs import Reached
from mbproj.model.system import System

#: A step is tried so often at most.
MOST_TRIES = 80


@dataclass(frozen=True, eq=False)
class Margins:
    """What is watched at a state, (k,): gaps and rates with their signs, then what forces are short of, none negative
    while nothing is met; and the rates of the gaps, NaN of all others. `places` and `speeds` of gaps and rates: their
    coordinates and what these change by."""

    value: Array
    rate: Array
    slack: Array
    places: Array
    speeds: Array

    @property
    def is_below(self) -> bool:
        """Whether something is below what it may be."""
        return bool((self.value < -self.slack).any())

    @property
    def worst(self) -> int:
        """Which is furthest below what it may be, by its slack."""
        with np.errstate(over="ignore"):
            return int(np.argmin(self.value / self.slack))


@dataclass(frozen=True, eq=False)
class Met:
    """The size h of a step that ends where something is met, the end, and which of the watched things it is; None where
    nothing is after all."""

    h: float
    end: Reached
    which: int | None


def margins(system: System, watched: Watched, reached: Reached) -> Margins:
    """At the end of a step."""
    place, speed = watched_gaps(system, watched, reached.state)
    of_rate = np.array([each.of_rate for each in watched.gaps], dtype=bool)
    force = watched_rows(system, watched, reached.state, reached.multipliers)
    slack = np.array([each.slack for each in watched.gaps] + [each.slack for each in watched.rows])
    idle = np.array([each.idle for each in watched.gaps])
    value = np.concatenate([np.where(of_rate, speed + idle, place), force])
    rate = np.concatenate([np.where(of_rate, np.nan, speed), np.full(len(force), np.nan)])
    return Margins(value, rate, slack, place, speed)


def locate(
    at: Callable[[float], Margins], reach: Callable[[float], Reached], h: float, grain: float, watched: Watched
) -> Met:
    """The first time in a step of size h at which something that is `watched` is met, to within `grain` s. `at` gives
    the margins after a step of a size, 0 too, and `reach` its end."""
    first, last = at(0.0), at(h)
    if last.is_below:
        high: float | None = next((theta * h for theta in watched.looks(h) if at(theta * h).is_below), h)
    else:
        high = _dip(at, first, last, h, watched)
    if high is None:
        return Met(h, reach(h), None)
    below = at(high)
    which = below.worst
    guess = high * _crossing(first, below, which, high)
    low, high, which = _inside(at, first, which, high, guess, grain)
    if low is None:
        return Met(0.0, reach(min(h, grain)), which)
    found, which = _root(at, low, high, guess, which, grain)
    return Met(found, reach(found), which)


def _crossing(first: Margins, last: Margins, k: int, h: float) -> float:
    """The part of a step of size h at which the cubic through both ends falls below zero, last of all; along a line
    where there are no rates."""
    start, end = float(first.value[k]), float(last.value[k])
    a, b = h * float(first.rate[k]), h * float(last.rate[k])
    if not np.isfinite(a + b):
        return start / (start - end) if start > 0.0 else 0.5
    change = end - start
    roots = np.roots([a + b - 2.0 * change, 3.0 * change - 2.0 * a - b, a, start])
    inside = roots[np.isreal(roots)].real
    inside = inside[(inside > 0.0) & (inside < 1.0)]
    return float(inside.max(initial=0.0)) or 0.5


def _dip(at: Callable[[float], Margins], first: Margins, last: Margins, h: float, watched: Watched) -> float | None:
    """A size at which something is met that is inside again at the end; None where nothing is."""
    looks: list[float] = []
    idle = first.value[: len(first.places)] - first.speeds
    for k in range(len(first.places)):
        ends = first.places[k], first.speeds[k], last.places[k], last.speeds[k]
        if np.isnan(first.rate[k]):
            looks += [slowest_at(*ends, h)] if slowest(*ends, h) + idle[k] < -first.slack[k] else []
            continue
        theta = lowest(*ends, h)
        looks += [theta] if theta > 0.0 and cubic(*ends, h, theta) < -first.slack[k] else []
        looks += THROUGH if may_pass(*ends, h) else ()

    def watched_at(theta: float) -> Ends:
        there = at(theta * h)
        return there.places, there.speeds

    inside = closed_inside(watched, watched_at, (first.places, first.speeds), (last.places, last.speeds), h)
    for theta in chain(looks, watched.looks(h), inside):
        if at(theta * h).is_below:
            return theta * h
    return None


def _inside(
    at: Callable[[float], Margins], first: Margins, which: int, high: float, guess: float, grain: float
) -> tuple[float | None, float, int]:
    """A size before that of a crossing at which nothing is met yet, None where it is met from the start on; the
    smallest size found at which something is met, and which. A contact pushes at the start, how much is not known."""
    if first.value[which] > first.slack[which]:
        return 0.0, high, which
    size = guess
    while size > grain and not first.rate[which] <= 0.0:
        size *= 0.5
        there = at(size)
        if there.is_below:
            high, which = size, there.worst
            if first.value[which] > first.slack[which]:
                return 0.0, high, which
        elif there.value[which] > 0.0:
            return size, high, which
    return None, high, which


def _root(
    at: Callable[[float], Margins], low: float, high: float, guess: float, which: int, grain: float
) -> tuple[float, int]:
    """Where the margin that is least crosses zero, between sizes with it above and below: Newton's method where it has
    a rate, else a parabola through three of its values (Chandrupatla 1997). The ends stay around it, and no guess is
    nearer to one than half a grain: so they meet soon after one of them is there."""
    above, below = at(low), at(high)
    y_low, y_high, wide = float(above.value[which]), float(below.value[which]), high - low
    old, y_old = high, y_high
    for tried in range(MOST_TRIES):
        if high - low <= grain:
            break
        if not low < guess < high:
            guess = _between(low, y_low, high, y_high, old, y_old)
        if tried % 6 == 5:
            guess = guess if high - low <= 0.5 * wide else 0.5 * (low + high)
            wide = high - low
        guess = min(max(guess, low + 0.5 * grain), high - 0.5 * grain)
        there = at(guess)
        if there.worst != which and there.value[there.worst] < -there.slack[there.worst]:
            which, old = there.worst, low
            y_low = y_old = float(above.value[which])
        value = float(there.value[which])
        if abs(value) <= 1e-3 * there.slack[which]:
            return guess, which
        if value > 0.0:
            old, y_old, low, y_low, above = low, y_low, guess, value, there
        else:
            old, y_old, high, y_high = high, y_high, guess, value
        guess -= float(value / there.rate[which])
    return high, which


def _between(low: float, y_low: float, high: float, y_high: float, old: float, y_old: float) -> float:
    """Where the parabola x(y) through three points is at zero, if that is a good guess; else the line through the
    ends."""
    line = high - y_high * (high - low) / (y_high - y_low)
    if old in (low, high) or y_old in (y_low, y_high):
        return line
    bend = (old - low) / (y_old - y_low) - (high - low) / (y_high - y_low)
    guess = line + y_low * y_high * bend / (y_old - y_high)
    return guess if low < guess < high else line
