"""Counts of a run: its work, and the largest violations at any step, recorded or not."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.integrate.events.time_events import Event

if TYPE_CHECKING:
    from mbproj.projection import ProjectedState


@dataclass(frozen=True)
class Peak:
    """The largest value so far, the row of C that had it, and the time (s)."""

    value: float = 0.0
    row: int = 0
    time: float = 0.0

    def or_larger(self, rows: Array, t: float) -> Peak:
        """Return this peak, or the largest of `rows` where that is larger."""
        row = int(np.argmax(rows)) if len(rows) else 0
        return Peak(float(rows[row]), row, t) if len(rows) and rows[row] > self.value else self


@dataclass(frozen=True)
class Passed:
    """A switch of a law that fixed steps pass over: its owner, a description, the first time (s), and the number of
    passes."""

    owner: str
    what: str
    first: float
    times: int


@dataclass(frozen=True)
class Halved:
    """Fixed steps that were halved for one cause: the force or body that Newton's method did not solve ("force
    'spring'", "body 'A'"), the first time (s), and the number of halvings."""

    where: str
    first: float
    times: int


@dataclass(frozen=True)
class RowsKept:
    """Counts of the rows for the energy balance and momenta; all 0 where none is asked for.

    `steps`, `rest`, `refused`: the numbers of steps whose correction was made, left out near rest, or refused. `given`:
    the energy in J that the rows added, signed; `furthest`: its largest absolute value so far; `moved`: the sum of
    absolute values. `largest`: their largest change of the velocities, divided by the velocities. `momenta`: the number
    of momenta conserved."""

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
        """Return the counts in a mark."""
        if not saved:
            return cls()
        steps, rest, refused = map(int, saved["often"])
        given, moved, furthest, largest = map(float, saved["sizes"])
        return cls(steps, rest, refused, given, moved, furthest, largest, len(saved["momenta"]))


def with_another(halved: Sequence[Halved], one: Halved) -> list[Halved]:
    """Return the list of halved steps with one more entry, merged with that of the same cause."""
    by_place = {each.where: each for each in halved}
    same = by_place.get(one.where, replace(one, times=0))
    by_place[one.where] = Halved(one.where, min(one.first, same.first), one.times + same.times)
    return list(by_place.values())


@dataclass
class Tally:
    """Counters since the start, and the peaks of |C|, of |C'|, and of |C| over the joints' rows alone.

    `phases`: the seconds of each phase in a sample of the steps, where measured. `met`: the state events at which steps
    ended. `passed`, `halved`: the switches that fixed steps passed over, and the causes for which they were halved.
    `turned`: the numbers of frictions whose slip turned as it began. `rows`: the counts of the rows for energy and
    momenta. `reached`: the time in s of a run that has returned without samples."""

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
    turned: tuple[int, ...] = ()
    rows: RowsKept = field(default_factory=RowsKept)
    reached: float = 0.0

    def counters(self) -> dict[str, int]:
        """Return the counters by name."""
        return {name: value for name, value in vars(self).items() if isinstance(value, int)}

    def set_counters(self, values: Iterable[int]) -> None:
        """Set the counters, in the order of the fields."""
        for name, value in zip(self.counters(), values, strict=True):
            setattr(self, name, value)

    def reject_accepted(self) -> None:
        """Count the last accepted step as rejected."""
        self.steps -= 1
        self.rejected_steps += 1

    def count_evaluations(self, number: int) -> None:
        """Count evaluations of the accelerations, each with one factorisation."""
        self.evaluations += number
        self.factorisations += number

    def count_projection(self, projected: ProjectedState) -> None:
        """Count the work of one projection."""
        self.projections += projected.projections
        self.projection_iterations += projected.position_iterations
        self.velocity_iterations += projected.velocity_iterations
        self.projection_failures += projected.failures
        self.projection_fallbacks += projected.fallbacks
        self.factorisations += projected.position_iterations + projected.velocity_iterations

    def watch(self, position: Array, velocity: Array, joints: slice, t: float) -> None:
        """Take in |C| and |C'| (m,) of a step; `joints` is the slice of the joints' rows."""
        self.position_peak = self.position_peak.or_larger(position, t)
        self.joint_peak = self.joint_peak.or_larger(position[joints], t)
        self.velocity_peak = self.velocity_peak.or_larger(velocity, t)
