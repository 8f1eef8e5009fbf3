"""The march of `integrator: auto`: by one method after the other, as its plan says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.automatic.decision import decide, handed_over
from mbproj.integrate.automatic.plan import Plan
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.loop.looks import Looks, Standing
from mbproj.integrate.loop.one_method import march_by_one_method
from mbproj.integrate.outcome.marks import START, Mark, Marks, resuming
from mbproj.integrate.outcome.tally import Tally
from mbproj.integrate.stiff.modes_at_a_step import FastModes
from mbproj.model.system import System
from mbproj.scene.records import Settings


@dataclass
class _Leg:
    """Scratch of the part of a run that one method makes: its marks, the plan that belongs to the newest of them, the
    mark that holds until it has one, and from where another method goes on."""

    marks: Marks
    plan: dict[str, Any]
    before: Mark
    left: Mark = field(default_factory=dict)

    def newest(self) -> Mark:
        """Where a longer run goes on from."""
        own = self.marks.newest()
        return {**own, "plan": self.plan} if own else self.before


class Automatic:
    """Scratch of a run and its plan."""

    def __init__(self, choice: Choice, system: System, state: State, settings: Settings) -> None:
        self._choice, self._system, self._state, self._settings = choice, system, state, settings
        self._modes, self.plan = FastModes(choice, system), Plan()
        self._end = state.t + (settings.duration or 0.0)

    def march(self, tally: Tally, marks: Marks) -> Iterator[Samples | None]:
        """Samples from the start to the end, or from a mark on."""
        mark, before = marks.resumed, START
        if mark:
            with resuming():
                self.plan = Plan.restore(mark["plan"])
        while True:
            leg = _Leg(Marks(mark, marks.wanted), self.plan.save(), before)
            marks.newest = leg.newest
            yield from self._by(self.plan.method, leg.marks, tally, self._looks(leg))
            if not leg.left:
                return
            mark, before = leg.left, leg.before

    def _by(self, method: str, marks: Marks, tally: Tally, looks: Looks | None) -> Iterator[Samples | None]:
        settings = replace(self._settings, integrator=method)
        return march_by_one_method(
            self._choice, self._system, self._state, settings, tally=tally, marks=marks, looks=looks
        )

    def _looks(self, leg: _Leg) -> Looks | None:
        """None without forces along coordinates: nothing can be stiff."""
        if self._system.forces is None or not self._system.forces.size:
            return None

        def trial(method: str, mark: Mark, counted: Tally, looks: Looks) -> Iterator[Samples | None]:
            return self._by(method, Marks(mark), counted, looks)

        def look(standing: Standing) -> bool:
            newest = leg.newest()
            switch = decide(self.plan, standing, self._modes, trial, self._end)
            looks.due = self.plan.due
            if switch is not None:
                leg.left, leg.before = handed_over(standing), newest
            elif not standing.shaped:
                leg.plan = self.plan.save()
            return switch is not None

        looks = Looks(self.plan.due, look)
        return looks
