"""What a run counts as it goes: work done, and the largest violations at any step, recorded or not."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field, replace
from itertools import takewhile
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.integrate.events.time_events import Event

if TYPE_CHECKING:
    from mbproj.projection import Projected


@dataclass(frozen=True)
class Peak:
    """The largest value so far, the row of C that had it, and when (s)."""

    value: float = 0.0
    row: int = 0
    time: float = 0.0

    def or_larger(self, rows: Array, t: float) -> Peak:
        """This peak, or the largest of `rows` where that is larger."""
        row = int(np.argmax(rows)) if len(rows) else 0
        return Peak(float(rows[row]), row, t) if len(rows) and rows[row] > self.value else self


@dataclass(frozen=True)
class Passed:
    """A switch of a law that fixed steps pass over: whose it is, what it is, when first (s), how many times."""

    owner: str
    what: str
    first: float
    times: int


@dataclass(frozen=True)
class Halved:
    """Fixed steps that were halved for want of the same: whose forces or motion Newton's method did not find ("force
    'spring'", "body 'A'"), when first (s), how many times."""

    where: str
    first: float
    times: int


@dataclass(frozen=True)
class RowsKept:
    """What the rows of the energy balance and of momenta did: how many `steps` they closed, at how many they were left
    near `rest`, or `refused`; the energy in J that they have `given`, signed, how far that has been from nothing at the
    `furthest`, and in sum `moved`; their `largest` change of the velocities, as a part of them; `momenta`: how many are
    kept. None of them asked for: all 0."""

    steps: int = 0
    rest: int = 0
    refused: int = 0
    given: float = 0.0
    moved: float = 0.0
    furthest: float = 0.0
    largest: float = 0.0
    momenta: int = 0

    @classmethod
    def of(cls, saved: Mapping[str, Any]) -> RowsKept:
        """From what a mark says."""
        if not saved:
            return cls()
        steps, rest, refused = map(int, saved["often"])
        given, moved, furthest, largest = map(float, saved["sizes"])
        return cls(steps, rest, refused, given, moved, furthest, largest, len(saved["momenta"]))

    def plus(self, other: RowsKept) -> RowsKept:
        """With those of another leg."""
        counted = (self.steps + other.steps, self.rest + other.rest, self.refused + other.refused)
        furthest = max(self.furthest, abs(self.given) + other.furthest)
        energy = self.given + other.given, self.moved + other.moved, furthest
        return RowsKept(*counted, *energy, max(self.largest, other.largest), max(self.momenta, other.momenta))


def with_another(halved: Sequence[Halved], one: Halved) -> list[Halved]:
    """What was halved, and this with it."""
    found = {each.where: each for each in halved}
    same = found.get(one.where, replace(one, times=0))
    found[one.where] = Halved(one.where, min(one.first, same.first), one.times + same.times)
    return list(found.values())


@dataclass
class Tally:
    """Counters since the start; the peaks of |C|, of |C'|, and of |C| over the joints' rows alone; the seconds of each
    phase of the steps, where they were measured, in a sample of the steps. `met`: the events in the state where steps
    ended; `passed`: what fixed steps passed over; `halved`: for want of what they were halved; `rows`: what
    those of the energy and of momenta did; `reached`: where a run is that came back without samples, s."""

    steps: int = 0
    rejected_steps: int = 0
    evaluations: int = 0
    projections: int = 0
    projection_iterations: int = 0
    velocity_iterations: int = 0
    projection_failures: int = 0
    projection_fallbacks: int = 0
    factorisations: int = 0
    position_peak: Peak = field(default_factory=Peak)
    velocity_peak: Peak = field(default_factory=Peak)
    joint_peak: Peak = field(default_factory=Peak)
    phases: dict[str, float] = field(default_factory=dict)
    met: list[Event] = field(default_factory=list)
    passed: list[Passed] = field(default_factory=list)
    halved: list[Halved] = field(default_factory=list)
    rows: RowsKept = field(default_factory=RowsKept)
    reached: float = 0.0

    def counters(self) -> dict[str, int]:
        """The counters by name."""
        return {name: value for name, value in vars(self).items() if isinstance(value, int)}

    def set_counters(self, values: Iterable[int]) -> None:
        """Takes the counters, in the order of the fields, from who counted them."""
        for name, value in zip(self.counters(), values, strict=True):
            setattr(self, name, value)

    def reject_accepted(self) -> None:
        """Counts a step as rejected that was counted as one made."""
        self.steps -= 1
        self.rejected_steps += 1

    def halve(self, where: str, t: float) -> None:
        """Counts a fixed step from t that is to be made in halves."""
        self.rejected_steps += 1
        self.halved = with_another(self.halved, Halved(where, t, 1))

    def join(self, own: Tally) -> None:
        """Takes in what belongs to a leg as a whole: its events, what it halved and passed over, seconds of phases.

        A leg that begins at an event may see it once more."""
        last = list(takewhile(lambda each: each.time == self.met[-1].time, reversed(self.met)))
        self.met += [each for each in own.met if each not in last]
        self.rows = self.rows.plus(own.rows)
        for name, seconds in own.phases.items():
            self.phases[name] = self.phases.get(name, 0.0) + seconds
        for halved in own.halved:
            self.halved = with_another(self.halved, halved)
        for each in own.passed:
            same = [one for one in self.passed if (one.owner, one.what) == (each.owner, each.what)]
            first = min([each.first, *(one.first for one in same)])
            times = each.times + sum(one.times for one in same)
            others = [one for one in self.passed if one not in same]
            self.passed = [*others, replace(each, first=first, times=times)]

    def count_evaluations(self, number: int) -> None:
        """Adds evaluations of the accelerations, each with a factorisation of its own."""
        self.evaluations += number
        self.factorisations += number

    def count_projection(self, projected: Projected) -> None:
        """Adds the work of one projection."""
        self.projections += projected.projections
        self.projection_iterations += projected.position_iterations
        self.velocity_iterations += projected.velocity_iterations
        self.projection_failures += projected.failures
        self.projection_fallbacks += projected.fallbacks
        self.factorisations += projected.position_iterations + projected.velocity_iterations

    def watch(self, position: Array, velocity: Array, joints: slice, t: float) -> None:
        """Takes in |C| and |C'| (m,) of a step; the rows `joints` are the joints'."""
        self.position_peak = self.position_peak.or_larger(position, t)
        self.joint_peak = self.joint_peak.or_larger(position[joints], t)
        self.velocity_peak = self.velocity_peak.or_larger(velocity, t)
