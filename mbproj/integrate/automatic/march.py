"""The march of `integrator: auto`: it runs one method after the other, as its plan says."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.automatic.decision import decide, handed_over
from mbproj.integrate.automatic.plan import Plan, told
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.loop.pauses import Pauses, Standing
from mbproj.integrate.reporting.marks import START, Mark, Marks, resuming
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.stiff.modes_at_a_step import FastModes, can_be_fast
from mbproj.model.system import System

#: Returns the fast modes where a run stands, with the contacts there.
Modes = Callable[[Standing], FastModes]
#: Yields samples by a method, from a mark on, until a pause ends them.
By = Callable[[str, Marks, Tally, Pauses | None], Iterator[Samples | None]]


@dataclass
class _Part:
    """Scratch for the part of a leg that one method makes.

    `marks` are its marks, and `plan` belongs to the newest of them. `before` is the mark that holds until there is one.
    `left` is the mark from which another method continues. `final` is the mark that holds once the run's end has
    influenced the plan."""

    marks: Marks
    plan: dict[str, Any]
    before: Mark
    left: Mark = field(default_factory=dict)
    final: Mark | None = None

    def newest(self) -> Mark:
        """Return the mark from which a longer run continues."""
        if self.final is not None:
            return self.final
        own = self.marks.newest()
        return {**own, "plan": self.plan} if own else self.before


class Automatic:
    """Scratch of a run: its plan, which is kept from leg to leg, and whether the run's end has influenced it
    (`shaped`)."""

    def __init__(self) -> None:
        self.plan, self.shaped = Plan(), False

    def told(self) -> tuple[str, ...]:
        """Return lines for the report on the methods used."""
        return told(self.plan)

    def march(
        self, system: System, modes: Modes, by: By, leg: Leg, tally: Tally, marks: Marks
    ) -> Iterator[Samples | None]:
        """Yield samples of a leg from its start, or from a mark on, to its end. `by` makes the steps of each method."""
        mark, before, final = marks.resumed, START, None
        if mark:
            with resuming():
                self.plan = Plan.restore(mark["plan"])
        while True:
            part = _Part(Marks(mark, marks.wanted), self.plan.save(), before, final=final)
            marks.newest = part.newest
            pauses = self._pauses(part, modes, by, leg) if can_be_fast(system) else None  # else nothing can be stiff
            yield from by(self.plan.method, part.marks, tally, pauses)
            if not part.left:
                return
            mark, before, final = part.left, part.before, part.final

    def _pauses(self, part: _Part, modes: Modes, by: By, leg: Leg) -> Pauses:
        def trial(method: str, mark: Mark, counted: Tally, pauses: Pauses) -> Iterator[Samples | None]:
            return by(method, Marks(mark), counted, pauses)

        def look(standing: Standing) -> bool:
            newest = part.newest()
            found = decide(self.plan, standing, modes, trial, leg)
            pauses.due = self.plan.due
            if found.shaped:
                part.final, self.shaped = newest, True
            if found.switch is not None:
                part.left, part.before = handed_over(standing), newest
            elif not standing.shaped:
                part.plan = self.plan.save()
            return found.switch is not None

        pauses = Pauses(self.plan.due, look)
        return pauses
