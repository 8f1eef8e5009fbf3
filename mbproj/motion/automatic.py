"""The march of `integrator: auto`: it runs one method after the other, as its plan says."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field, replace
from typing import Any, NamedTuple

from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Samples
from mbproj.errors import InputError, SimulationError
from mbproj.integrate import kernel_run
from mbproj.integrate.automatic.plan import Plan, Since, Switch, methods_taken
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.choice import Choice, choose
from mbproj.integrate.kernel_run import Halted, Pauses, Standing
from mbproj.integrate.reporting.marks import START, Mark, Marks, resuming
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.stiff.modes_at_a_step import FastModes, against, can_be_fast
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.system import System
from mbproj.registry import WHERE_SMOOTH, WHERE_STIFF
from mbproj.scene.records import Settings
from mbproj.thresholds import THRESHOLDS

#: Function that returns the fast modes where a run stands, with the contacts there.
Modes = Callable[[Standing], FastModes]
#: Function that yields samples by a method, from a mark on, until a pause ends them.
By = Callable[[str, Marks, Tally, Pauses | None], Iterator[Samples | None]]


@dataclass
class _Part:
    """The part of a run that one method makes.

    `marks` are its marks, and `plan` belongs to the newest of them. `before` is the mark to use until `marks` has one.
    `left` is the mark from which another method continues. `final` is the mark to use once the run's end has influenced
    the plan."""

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


class AutomaticMarch:
    """One run by `integrator: auto`, with its plan."""

    def __init__(self) -> None:
        self.plan = Plan()

    def methods_taken(self) -> tuple[str, ...]:
        """Return lines for the report on the methods used."""
        return methods_taken(self.plan)

    def march(
        self, choice: Choice, system: System, start: State, settings: Settings, tally: Tally, marks: Marks
    ) -> Iterator[Samples | None]:
        """Yield samples from a start, or from a mark on."""

        def by(method: str, own: Marks, counted: Tally, pauses: Pauses | None) -> Iterator[Samples | None]:
            of_method = replace(settings, integrator=method)
            return kernel_run.march(choice, system, start, of_method, tally=counted, marks=own, pauses=pauses)

        def modes(standing: Standing) -> FastModes:
            if not system.has_contacts:
                return FastModes(choice, system)
            return _with_contacts(choice, settings, system, standing)

        leg = Leg.whole(system, settings, start.t)
        mark, before, final = marks.resumed, START, None
        if mark:
            with resuming():
                self.plan = Plan.restore(mark["plan"])
        may_be_stiff = system.has_contacts or can_be_fast(system)
        while True:
            part = _Part(Marks(mark, marks.wanted), self.plan.save(), before, final=final)
            marks.newest = part.newest
            pauses = self._pauses(part, modes, by, leg) if may_be_stiff else None
            yield from by(self.plan.method, part.marks, tally, pauses)
            if not part.left:
                return
            mark, before, final = part.left, part.before, part.final

    def _pauses(self, part: _Part, modes: Modes, by: By, leg: Leg) -> Pauses:
        def trial(method: str, mark: Mark, counted: Tally, pauses: Pauses) -> Iterator[Samples | None]:
            return by(method, Marks(mark), counted, pauses)

        def look(standing: Standing) -> bool:
            newest = part.newest()
            result = decide(self.plan, standing, modes, trial, leg)
            pauses.due = self.plan.due
            if result.shaped:
                part.final = newest
            if result.switch is not None:
                part.left, part.before = handed_over(standing), newest
            elif not standing.shaped:
                part.plan = self.plan.save()
            return result.switch is not None

        pauses = Pauses(self.plan.due, look)
        return pauses


def _with_contacts(choice: Choice, settings: Settings, system: System, standing: Standing) -> FastModes:
    """Return the fast modes with the contacts where a run stands. Raises SimulationError where its equations have no
    unique solution."""
    from mbproj.integrate.stops.inside import contacts_of

    contacts, at = contacts_of(system, standing.mark["contacts"]), standing.state()
    now, rows = in_contact(system, contacts), in_contact(system, Contacts(contacts.held, stuck=contacts.stuck))
    settings = settings if choice.name == "planar" else replace(settings, formulation=choice.name)
    try:
        chosen = choice if rows is system else choose(rows, at, settings)
    except InputError as error:
        cause = f"with a stop in contact, or a friction that sticks: {error.problems[0].message}"
        raise SimulationError(at.t, cause) from error
    assert chosen.compiled is not None
    return FastModes(replace(chosen, compiled=chosen.compiled.with_system(now)), now)


# --- Decides by a trial whether the other method would be faster ------------------------------------------------------
# A trial makes some steps that do not enter the run. It is made where the run has become slower, and else where
# trials have taken little of the work so far. No model of stability is used.


#: Function that makes the steps of a method from a mark on, with a separate tally, until the `Pauses` end them.
March = Callable[[str, Mark, Tally, Pauses], Iterator[Samples | None]]


def handed_over(standing: Standing) -> Mark:
    """Return the mark from which the other method continues, without data of this method and without an error of the
    last step."""
    return {**standing.mark, "anew": True, "previous_error": THRESHOLDS.least_error_before, "rejected": False}


class LookResult(NamedTuple):
    """The result of a look: the switch to the other method, None where this one stays. `shaped`: whether the run's end
    has influenced the result, so that a longer run may give another one."""

    switch: Switch | None = None
    shaped: bool = False


def decide(
    plan: Plan, standing: Standing, modes: Callable[[Standing], FastModes], march: March, leg: Leg
) -> LookResult:
    """Decide whether the other method makes the steps from here on in a leg; the plan records the look."""
    t, evaluations = standing.mark["t"], standing.evaluations
    sampled = int((t - plan.since.time) / leg.interval)  # samples cost the same with any method
    own = _speed((plan.since.time, plan.since.evaluations), (t, evaluations - sampled))
    result = LookResult()
    if plan.is_due(own, standing.attempts, evaluations):
        other = WHERE_SMOOTH if plan.is_stiff else WHERE_STIFF
        pays, shaped = _pays(plan, standing, own, other, march, leg.end)
        switch = None
        if pays:
            stiff = _fastest(standing, modes(standing)) if other == WHERE_STIFF else ("", 0.0)
            switch = Switch(t, other, *stiff)
            plan.take(switch)
        plan.begin(own, standing.attempts)
        result = LookResult(switch, shaped)
    plan.due = standing.attempts + max(THRESHOLDS.look_steps, int(THRESHOLDS.look_part * standing.attempts))
    plan.since = Since(t, standing.steps, evaluations)
    return result


def _fastest(standing: Standing, modes: FastModes) -> tuple[str, float]:
    """Return the owner of the fastest mode, and ω h for an explicit step of this size; "" and 0 where all modes are
    slow."""
    fastest = modes.fastest(standing.state(), standing.mark["h"])
    return ("", 0.0) if fastest is None else (fastest[0], against(WHERE_SMOOTH, standing.mark["h"], *fastest).omega_h)


def _pays(plan: Plan, standing: Standing, own: float, other: str, march: March, end: float) -> tuple[bool, bool]:
    """Return whether a trial of the other method is faster than this one, at the speed `own`. Return also whether the
    run's end has cut the trial short. A trial goes on while its speed grows, and may end before at an event."""
    tally, reached = Tally(), [(standing.mark["t"], standing.evaluations)]
    dearer = 1.0 / THRESHOLDS.implicit_cost if plan.is_stiff else THRESHOLDS.implicit_cost
    enough, shaped = THRESHOLDS.quicker * dearer * own, False

    def look(there: Standing) -> bool:
        nonlocal shaped
        shaped = shaped or there.shaped
        reached.append((there.mark["t"], there.evaluations))
        pauses.due = there.attempts + THRESHOLDS.trial_steps
        if len(reached) == 2:
            return False
        now, before = _speed(*reached[-2:]), _speed(*reached[-3:-1])
        return now > enough or now < THRESHOLDS.quicker * before or len(reached) > THRESHOLDS.trial_parts

    pauses = Pauses(standing.attempts + THRESHOLDS.trial_steps, look, sampled=False)
    try:
        for _ in march(other, handed_over(standing), tally, pauses):
            pass
        if len(reached) == 1 or tally.evaluations > reached[-1][1]:
            shaped = True
            reached.append((end, tally.evaluations))
    except Halted as halted:
        shaped = shaped or halted.shaped
        reached.append((halted.t, tally.evaluations))
    except SimulationError:
        reached.clear()
    plan.trials += 1
    plan.tried += tally.evaluations - standing.evaluations
    return bool(reached) and _speed(*reached[-2:]) > enough, shaped


def _speed(before: tuple[float, int], after: tuple[float, int]) -> float:
    """Return the simulated time for one evaluation, in s."""
    return (after[0] - before[0]) / max(after[1] - before[1], 1)
