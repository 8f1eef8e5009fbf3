"""The march of `integrator: auto`: it runs one method after the other, as its plan says."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, replace
from typing import Any, NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Flags
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.registry import WHERE_SMOOTH, WHERE_STIFF
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.samples import Samples
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.system import System
from mbproj.motion import kernel_run
from mbproj.motion.formulations.choice import Choice, choose
from mbproj.motion.kernel_run import Halted, Pauses, Standing
from mbproj.motion.marks import START, Mark, Marks, resuming
from mbproj.motion.report import Tally
from mbproj.motion.stiffness import FastModes, against, can_be_fast
from mbproj.motion.time_events import Event, Leg

# --- The plan of `integrator ------------------------------------------------------------------------------------------
# Auto`: the method in use, since when, and the next look. It is saved with a run's marks.


#: The owner of events at which the method changes.
OWNER = "integrator"
#: The most changes of the method that the report lists.
MOST_TOLD = 4


class Switch(NamedTuple):
    """A change: from `time` on (s) `method` makes the steps. For a change to the implicit method, `where` ("force
    'bush'") is the cause, with |hλ| = `omega_h` for an explicit step; else they are "" and 0."""

    time: float
    method: str
    where: str = ""
    omega_h: float = 0.0

    @property
    def event(self) -> Event:
        """The event for the results file."""
        why = f", for {self.where} (ω h = {self.omega_h:.3g})" if self.where else ""
        return Event(self.time, OWNER, f"{self.method} goes on{why}")


class Since(NamedTuple):
    """The time (s) of the last look, and the counts at it."""

    time: float = 0.0
    steps: int = 0
    evaluations: int = 0


@dataclass
class Plan:
    """The plan of one run, which changes as the run goes on.

    `due`: the number of attempted steps at the next look. `trial`: the number at which a trial is due at the latest.
    `best`: the highest speed since the last trial, in simulated s per evaluation. `failed`: the number of failed trials
    in a row. `trials` and `tried`: the number of all trials, and of their evaluations."""

    method: str = WHERE_SMOOTH
    due: int = THRESHOLDS.look_steps
    trial: int = 0
    best: float = 0.0
    failed: int = 0
    trials: int = 0
    tried: int = 0
    since: Since = field(default_factory=Since)
    switches: list[Switch] = field(default_factory=list)

    @property
    def is_stiff(self) -> bool:
        """Whether the implicit method makes the steps."""
        return self.method == WHERE_STIFF

    def is_due(self, speed: float, attempts: int, evaluations: int) -> bool:
        """Whether a run at this speed, in simulated s per evaluation, should try the other method. It should where it
        has slowed down or the last trial is long ago, unless trials have taken too much of the work."""
        self.best = max(self.best, speed)
        affordable = self.trials < 2 or self.tried < THRESHOLDS.trial_part * evaluations
        return affordable and (attempts >= self.trial or speed < THRESHOLDS.slowed * self.best)

    def take(self, switch: Switch) -> None:
        """Change to the method of `switch`."""
        self.method, self.failed = switch.method, -1
        self.switches.append(switch)

    def begin(self, speed: float, attempts: int) -> None:
        """Record the end of a trial. `speed`: the run's speed before it, in simulated s per evaluation."""
        self.failed += 1
        self.best = 0.0 if self.failed == 0 else speed
        self.trial = attempts + THRESHOLDS.look_steps * 2 ** min(self.failed, THRESHOLDS.longest_wait)

    def implicit_at(self, times: Array) -> Flags:
        """Whether the implicit method made the steps at these times, (T,)."""
        starts = np.array([switch.time for switch in self.switches])
        stiff = np.array([False, *(switch.method == WHERE_STIFF for switch in self.switches)])
        return np.asarray(stiff[np.searchsorted(starts, times, side="left")])

    def save(self) -> dict[str, Any]:
        """Return the plan as plain data."""
        return {
            "method": self.method,
            "due": self.due,
            "trial": self.trial,
            "best": self.best,
            "failed": self.failed,
            "trials": self.trials,
            "tried": self.tried,
            "since": list(self.since),
            "switches": [list(switch) for switch in self.switches],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> Plan:
        """Return the plan that was saved. Raises ValueError for data that are no plan."""
        method = str(saved["method"])
        if method not in (WHERE_SMOOTH, WHERE_STIFF):
            raise ValueError(f"{method!r} is no part of it")
        time, steps, evaluations = saved["since"]
        switches = [Switch(float(t), str(name), str(where), float(size)) for t, name, where, size in saved["switches"]]
        return cls(
            method=method,
            due=int(saved["due"]),
            trial=int(saved["trial"]),
            best=float(saved["best"]),
            failed=int(saved["failed"]),
            trials=int(saved["trials"]),
            tried=int(saved["tried"]),
            since=Since(float(time), int(steps), int(evaluations)),
            switches=switches,
        )


def methods_taken(plan: Plan) -> tuple[str, ...]:
    """Return lines on the methods that made the steps, and on the cost of trials."""
    why = f"{WHERE_STIFF} was not quicker" if plan.trials else "no force is stiff"
    lines = [_switch_line(switch) for switch in plan.switches[:MOST_TOLD]] or [f"{plan.method} throughout: {why}"]
    more = len(plan.switches) - MOST_TOLD
    if more > 0:
        lines.append(f"{more} more change{'s' * (more > 1)} of the method; {plan.method} at the end")
    if plan.trials:
        lines.append(f"{plan.trials} trial{'s' * (plan.trials > 1)} of the other method: {plan.tried} evaluations more")
    return tuple(lines)


def _switch_line(switch: Switch) -> str:
    why = f"stiff: {switch.where} (ω h = {switch.omega_h:.3g}); " if switch.where else ""
    return f"{why}{switch.method} from t = {switch.time:.4g} s on"


# --- The march of `integrator -----------------------------------------------------------------------------------------


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
        mark = self.marks.newest()
        return {**mark, "plan": self.plan} if mark else self.before


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

        def by(method: str, part_marks: Marks, counted: Tally, pauses: Pauses | None) -> Iterator[Samples | None]:
            of_method = replace(settings, integrator=method)
            return kernel_run.march(choice, system, start, of_method, tally=counted, marks=part_marks, pauses=pauses)

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
    from mbproj.motion.contacts import contacts_of

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
    speed = _speed((plan.since.time, plan.since.evaluations), (t, evaluations - sampled))
    result = LookResult()
    if plan.is_due(speed, standing.attempts, evaluations):
        other = WHERE_SMOOTH if plan.is_stiff else WHERE_STIFF
        pays, shaped = _pays(plan, standing, speed, other, march, leg.end)
        switch = None
        if pays:
            stiff = _fastest(standing, modes(standing)) if other == WHERE_STIFF else ("", 0.0)
            switch = Switch(t, other, *stiff)
            plan.take(switch)
        plan.begin(speed, standing.attempts)
        result = LookResult(switch, shaped)
    plan.due = standing.attempts + max(THRESHOLDS.look_steps, int(THRESHOLDS.look_part * standing.attempts))
    plan.since = Since(t, standing.steps, evaluations)
    return result


def _fastest(standing: Standing, modes: FastModes) -> tuple[str, float]:
    """Return the owner of the fastest mode, and ω h for an explicit step of this size; "" and 0 where all modes are
    slow."""
    fastest = modes.fastest(standing.state(), standing.mark["h"])
    return ("", 0.0) if fastest is None else (fastest[0], against(WHERE_SMOOTH, standing.mark["h"], *fastest).omega_h)


def _pays(plan: Plan, standing: Standing, speed: float, other: str, march: March, end: float) -> tuple[bool, bool]:
    """Return whether a trial of the other method is faster than this one, at its `speed`. Return also whether the
    run's end has cut the trial short. A trial goes on while its speed grows, and may end before at an event."""
    tally, reached = Tally(), [(standing.mark["t"], standing.evaluations)]
    dearer = 1.0 / THRESHOLDS.implicit_cost if plan.is_stiff else THRESHOLDS.implicit_cost
    enough, shaped = THRESHOLDS.quicker * dearer * speed, False

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
