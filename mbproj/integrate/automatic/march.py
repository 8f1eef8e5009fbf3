"""The march of `integrator: auto`: by one method after the other, as its plan says."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.automatic.decision import decide, handed_over
from mbproj.integrate.automatic.plan import Plan, told
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.loop.looks import Looks, Standing
from mbproj.integrate.outcome.marks import START, Mark, Marks, resuming
from mbproj.integrate.outcome.tally import Tally
from mbproj.integrate.stiff.modes_at_a_step import FastModes, can_be_fast
from mbproj.model.system import System

#: The modes where a run stands, with the contacts there.
Modes = Callable[[Standing], FastModes]
#: Samples by a method, from a mark on, to where looks end them.
By = Callable[[str, Marks, Tally, Looks | None], Iterator[Samples | None]]


@dataclass
class _Part:
    """Scratch of the part of a leg that one method makes: its marks; the plan that belongs to the newest of them; the
    mark that holds until there is one; from where another method goes on. `final`: the mark that holds once the end has
    had a say in the plan."""

    marks: Marks
    plan: dict[str, Any]
    before: Mark
    left: Mark = field(default_factory=dict)
    final: Mark | None = None

    def newest(self) -> Mark:
        """Where a longer run goes on from."""
        if self.final is not None:
            return self.final
        own = self.marks.newest()
        return {**own, "plan": self.plan} if own else self.before


class Automatic:
    """Scratch of a run: its plan, which is kept from leg to leg, and whether the run's end has shaped that."""

    def __init__(self) -> None:
        self.plan, self.shaped = Plan(), False

    def told(self) -> tuple[str, ...]:
        """What its methods have done, for the report."""
        return told(self.plan)

    def march(
        self, system: System, modes: Modes, by: By, leg: Leg, tally: Tally, marks: Marks
    ) -> Iterator[Samples | None]:
        """Samples of a leg from its start to its end, or from a mark on, by methods that step on `by` themselves."""
        mark, before, final = marks.resumed, START, None
        if mark:
            with resuming():
                self.plan = Plan.restore(mark["plan"])
        while True:
            part = _Part(Marks(mark, marks.wanted), self.plan.save(), before, final=final)
            marks.newest = part.newest
            looks = self._looks(part, modes, by, leg) if can_be_fast(system) else None  # else nothing can be stiff
            yield from by(self.plan.method, part.marks, tally, looks)
            if not part.left:
                return
            mark, before, final = part.left, part.before, part.final

    def _looks(self, part: _Part, modes: Modes, by: By, leg: Leg) -> Looks:
        def trial(method: str, mark: Mark, counted: Tally, looks: Looks) -> Iterator[Samples | None]:
            return by(method, Marks(mark), counted, looks)

        def look(standing: Standing) -> bool:
            newest = part.newest()
            found = decide(self.plan, standing, modes, trial, leg)
            looks.due = self.plan.due
            if found.shaped:
                part.final, self.shaped = newest, True
            if found.switch is not None:
                part.left, part.before = handed_over(standing), newest
            elif not standing.shaped:
                part.plan = self.plan.save()
            return found.switch is not None

        looks = Looks(self.plan.due, look)
        return looks
