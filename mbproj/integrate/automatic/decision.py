"""Decides by a trial whether the other method would be faster. A trial makes some steps that do not enter the run. It
is made where the run has become slower, and else where trials have taken little of the work so far. No model of
stability is used."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from mbproj.dynamics.observe.samples import Samples
from mbproj.errors import SimulationError
from mbproj.integrate.automatic.plan import Plan, Since, Switch
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.kernel_run import Halted, Pauses, Standing
from mbproj.integrate.reporting.marks import Mark
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.stiff.modes_at_a_step import FastModes, against
from mbproj.registry import WHERE_SMOOTH, WHERE_STIFF
from mbproj.thresholds import THRESHOLDS

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
