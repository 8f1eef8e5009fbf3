"""Halts of a run: conditions that end the current contacts and frictions within a step, and the state at a halt."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, Flags, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.gaps import counted_values, gap_rates, gaps
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.dynamics.observe.bearings import load, supports
from mbproj.functions.series import run
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: The watched values at a state, and their rates.
Ends = tuple[Array, Array]
#: The parts of a step at which a passage of one body through another is searched.
THROUGH = (0.5, 0.25, 0.75, 0.375, 0.625)


class WatchedGap(NamedTuple):
    """A condition that halts a run: `sign` (s - bound) of a stop below -`slack`, or `sign` s' where `of_rate`.

    The sign is the stop's side where its gap closes, and the opposite where it opens. The numbers of frictions follow
    those of stops, with bounds of 0. `other_sign` times the value of an `other` one is added, unless that is -1.
    `idle`: the rate that a coordinate at rest without friction may have. A coordinate is at rest, which also halts a
    run, where |s'| stays within the slack over a step no shorter than `rests_over`, in s."""

    stop: int
    sign: float
    slack: float
    of_rate: bool = False
    other: int = -1
    other_sign: float = 0.0
    rests_over: float = np.inf
    idle: float = 0.0


class WatchedRow(NamedTuple):
    """A condition that halts a run: `bound` + `part` · load + `sign` λ of a row of C, after the norm rows, below
    -`slack`.

    The load is that of a `bearing`, none for -1. With an `other` row, not -1, minus |λ| of both rows replaces `sign` λ.
    `bound` and `part` are multiplied by the value of a `program` of forces, if any."""

    row: int
    sign: float
    slack: float
    bound: float = 0.0
    part: float = 0.0
    bearing: int = -1
    other: int = -1
    program: int = -1


@dataclass(frozen=True)
class Watched:
    """All conditions that halt a run. Forces are evaluated in the middle of each step, and at least every `spacing`
    s."""

    gaps: tuple[WatchedGap, ...] = ()
    rows: tuple[WatchedRow, ...] = ()
    spacing: float = 1.0

    def looks(self, h: float) -> list[float]:
        """Return the parts of a step of size h at which forces are evaluated."""
        count = max(1, int(np.ceil(h / self.spacing)) - 1) if self.rows else 0
        return [look / (count + 1) for look in range(1, count + 1)]


@dataclass(frozen=True, eq=False)
class HaltedAt:
    """The state at which a run has halted, and the size of the step that it has not made, in s. `work`: the integrals
    there in J, of work, dissipation and separate losses of laws; may be empty. `shaped`: whether the run's end has
    influenced that step, so that a longer run gets there with other round-off."""

    state: State
    h: float
    work: Array
    shaped: bool


class Halted(Exception):
    """Raised where a watched condition halts a run, with the state reached."""

    def __init__(self, standing: HaltedAt) -> None:
        super().__init__(f"halted at t = {standing.state.t:.6g} s")
        self.standing = standing


def watched_gaps(system: System, watched: Watched, state: State) -> tuple[Array, Array]:
    """Return sign (s - bound) of the watched coordinates, and their rates, (k,) each."""
    stops, frictions, pose = system.stops, system.frictions, pose_of(state.q)
    twist, value, rate = twist_of(pose, state.v), [np.zeros(0)], [np.zeros(0)]
    if stops is not None:
        value.append(stops.side * gaps(stops, pose, state.turns))
        rate.append(stops.side * gap_rates(stops, pose, twist))
    if frictions is not None:
        value.append(counted_values(frictions.coordinates, frictions.joint_coordinate, pose, state.turns))
        rate.append(set_velocity(frictions.coordinates, pose, twist))
    which, sign = [each.stop for each in watched.gaps], np.array([each.sign for each in watched.gaps])
    other, other_sign = [each.other for each in watched.gaps], np.array([each.other_sign for each in watched.gaps])
    own = (np.concatenate(part) for part in (value, rate))
    places, speeds = (sign * part[which] + other_sign * part[other] for part in own)
    return places, speeds


def resting(watched: Watched, first: Ends, last: Ends, h: float) -> int | None:
    """Return the first watched coordinate that was at rest over a step of size h; None without one."""
    for k, each in enumerate(watched.gaps):
        if h >= each.rests_over and max(abs(first[1][k]), abs(last[1][k])) <= each.slack:
            return k
    return None


def watched_rows(system: System, watched: Watched, state: State, multipliers: Array) -> Array:
    """Return bound + part · load + sign λ of the watched rows, (k,), with λ of the rows of C after the norm rows."""
    loads, bearings = np.zeros(1), system.bearings
    if bearings is not None and any(each.part for each in watched.rows):
        found = load(bearings, supports(system, bearings, pose_of(state.q), multipliers))
        loads = np.append(found, 0.0)
    times = _given(system, [each.program for each in watched.rows], state)
    bounds = (each.bound + each.part * loads[each.bearing] for each in watched.rows)
    return np.array(
        [k * own + _force(each, multipliers) for k, own, each in zip(times, bounds, watched.rows, strict=True)]
    )


def _given(system: System, programs: list[int], state: State) -> list[float]:
    """Return the values of programs of forces at a state; 1 for no program, -1."""
    if all(program < 0 for program in programs):
        return [1.0] * len(programs)
    instant = state.instant(system)
    variables = instant.variables()
    return [float(run(system.forces.programs, each, variables)[0]) if each >= 0 else 1.0 for each in programs]


def _force(watched: WatchedRow, multipliers: Array) -> float:
    """Return sign λ, or minus |λ| of two rows."""
    own = float(multipliers[watched.row])
    return watched.sign * own if watched.other < 0 else -float(np.hypot(own, multipliers[watched.other]))


def may_pass(value: Numbers, rate: Numbers, value_after: Numbers, rate_after: Numbers, h: float) -> Flags:
    """Whether gaps may be passed within a step: they would be if they closed as at its start and opened as at its end.
    A body may have gone through another one."""
    return np.asarray((value > 0.0) & (value + h * rate < 0.0) & (value_after - h * rate_after < 0.0))


def least_watched(watched: Watched, first: tuple[Array, Array], last: tuple[Array, Array], h: float) -> Array:
    """Return the least gaps and rates (k,) within a step."""
    of_rate = np.array([each.of_rate for each in watched.gaps], dtype=bool)
    slow = np.array([slowest(*ends, h) for ends in zip(*first, *last, strict=True)]).reshape(of_rate.shape)
    return np.where(of_rate, slow, least(first, last, h))


def closed_inside(
    watched: Watched, at: Callable[[float], Ends], first: Ends, last: Ends, h: float, x: float = 0.0, x_to: float = 1.0
) -> Iterator[float]:
    """Parts of a step of size h at which a gap may be closed that closes and opens again between its parts x and x_to.

    The cubic through both ends may not show that. Where the middle is not on the cubic, each half is examined. `at`
    returns the watched values at a part of the step, each angle by its own count of turns."""
    gaps = [(k, each.slack) for k, each in enumerate(watched.gaps) if not each.of_rate]
    middle = 0.5 * (x + x_to)
    half = (middle - x) * h
    if not gaps:
        return
    found, unlike = at(middle), False
    for k, slack in gaps:
        ends = (first[0][k], first[1][k]), (found[0][k], found[1][k]), (last[0][k], last[1][k])
        expected = 0.5 * (ends[0][0] + ends[2][0]) + 0.25 * half * (ends[0][1] - ends[2][1])
        values = [end[0] for end in ends]
        unlike |= abs(values[1] - expected) > max(slack, 0.5 * min(values), THRESHOLDS.middle_unlike * max(values))
        if values[1] < -slack:
            yield middle
        for start, (one, two) in ((x, ends[:2]), (middle, ends[1:])):
            theta = lowest(*one, *two, half)
            parts = (theta,) if theta and cubic(*one, *two, half, theta) < -slack else ()
            yield from (start + part * (middle - x) for part in (THROUGH if may_pass(*one, *two, half) else parts))
    if unlike and x_to - x > 0.5**THRESHOLDS.most_halves:
        yield from closed_inside(watched, at, first, found, h, x, middle)
        yield from closed_inside(watched, at, found, last, h, middle, x_to)


def slowest(value: float, rate: float, value_after: float, rate_after: float, h: float) -> float:
    """Return the least rate within a step, on the cubic through both ends."""
    theta, ends = slowest_at(value, rate, value_after, rate_after, h), min(rate, rate_after)
    if theta == 0.0:
        return ends
    a, b, change = h * rate, h * rate_after, value_after - value
    c3, c2 = a + b - 2.0 * change, 3.0 * change - 2.0 * a - b
    return min(ends, (a + theta * (2.0 * c2 + 3.0 * theta * c3)) / h)


def slowest_at(value: float, rate: float, value_after: float, rate_after: float, h: float) -> float:
    """Return the part of a step at which the rate of its cubic has a minimum inside; 0 without one."""
    a, b, change = h * rate, h * rate_after, value_after - value
    c3, c2 = a + b - 2.0 * change, 3.0 * change - 2.0 * a - b
    theta = -c2 / (3.0 * c3) if c3 > 0.0 else 0.0
    return theta if 0.0 < theta < 1.0 else 0.0


def least(first: tuple[Array, Array], last: tuple[Array, Array], h: float) -> Array:
    """Return the least values (k,) within a step, on the cubics through both ends (value, rate); -inf where a gap may
    have been passed."""
    theta = np.array([lowest(*ends, h) for ends in zip(*first, *last, strict=True)])
    value = [cubic(*ends, h, at) for ends, at in zip(zip(*first, *last, strict=True), theta, strict=True)]
    found = np.minimum(np.minimum(first[0], last[0]), np.array(value, dtype=float).reshape(first[0].shape))
    return np.where(may_pass(*first, *last, h), -np.inf, found)


def lowest(value: float, rate: float, value_after: float, rate_after: float, h: float) -> float:
    """Return the part of a step at which its cubic has a minimum inside; 0 without one."""
    a, b, change = h * rate, h * rate_after, value_after - value
    c3, c2 = a + b - 2.0 * change, 3.0 * change - 2.0 * a - b
    root = c2 * c2 - 3.0 * c3 * a
    if not (a < 0.0 < root and c2 + np.sqrt(root) > 0.0):
        return 0.0
    theta = -a / (c2 + np.sqrt(root))
    return float(theta) if 0.0 < theta < 1.0 else 0.0


def cubic(value: float, rate: float, value_after: float, rate_after: float, h: float, theta: float) -> float:
    """Return the value, at the part θ of a step, of the cubic through both ends."""
    a, b, change = h * rate, h * rate_after, value_after - value
    return value + theta * (a + theta * (3.0 * change - 2.0 * a - b + theta * (a + b - 2.0 * change)))
