"""Whether another method would get on faster: asked where the fastest mode of the forces lets expect it, and told by a
trial of some steps, of which the run itself knows nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from mbproj.dynamics.observe.samples import Samples
from mbproj.errors import SimulationError
from mbproj.integrate.automatic.plan import Plan, Since, Switch
from mbproj.integrate.events.halts import Halted
from mbproj.integrate.loop.looks import Looks, Standing
from mbproj.integrate.outcome.marks import Mark
from mbproj.integrate.outcome.stiff_words import Stiffness
from mbproj.integrate.outcome.tally import Tally
from mbproj.integrate.steppers.methods import stepper_of
from mbproj.integrate.stiff.modes_at_a_step import FastModes, against
from mbproj.registry import WHERE_SMOOTH, WHERE_STIFF
from mbproj.thresholds import THRESHOLDS

#: Steps of a method from a mark on, with a tally of their own, to where somebody ends it.
March = Callable[[str, Mark, Tally, Looks], Iterator[Samples | None]]


def handed_over(standing: Standing) -> Mark:
    """The mark from which another method goes on: what is its own it finds anew, and it knows of no error before."""
    return {**standing.mark, "anew": True, "previous_error": THRESHOLDS.least_error_before, "rejected": False}


class Found(NamedTuple):
    """What a look has found: the other method, where that is quicker from here on, and whether the run's end has
    `shaped` the answer: a longer run may find another one."""

    switch: Switch | None = None
    shaped: bool = False


def decide(plan: Plan, standing: Standing, modes: FastModes, march: March, end: float) -> Found:
    """Whether the other method is quicker from here on; the plan takes note of the look. `end`: of the leg."""
    mode = _fastest(standing, modes)
    other = WHERE_SMOOTH if plan.is_stiff else WHERE_STIFF
    found = Found()
    if _lets_through(plan, standing, mode) if plan.is_stiff else _holds_up(plan, standing, mode):
        pays, shaped = _pays(plan, standing, other, march, end)
        switch = None
        if pays:
            stiff = mode if other == WHERE_STIFF else None
            switch = Switch(standing.state.t, other, *((stiff.where, stiff.omega_h) if stiff else ()))
            plan.method, plan.failed = other, 0
            plan.switches.append(switch)
        else:
            plan.failed += 1
        found = Found(switch, shaped)
    plan.due = standing.attempts + plan.wait
    plan.since = Since(standing.state.t, standing.steps, standing.evaluations)
    return found


def _fastest(standing: Standing, modes: FastModes) -> Stiffness | None:
    """The fastest mode against explicit steps of the size at hand; None where all are slow."""
    found = modes.fastest(standing.state, standing.h)
    return None if found is None else against(WHERE_SMOOTH, standing.h, *found)


def _holds_up(plan: Plan, standing: Standing, found: Stiffness | None) -> bool:
    """Whether explicit steps, the next one or those since the last look, are at the limit of their stability."""
    if found is None:
        return False
    steps, passed = standing.steps - plan.since.steps, standing.state.t - plan.since.time
    longer = max(1.0, passed / (steps * standing.h)) if steps else 1.0
    return found.omega_h * longer >= THRESHOLDS.near_limit * found.limit


def _lets_through(plan: Plan, standing: Standing, found: Stiffness | None) -> bool:
    """Whether stability lets explicit steps get on as fast as the implicit ones do for their evaluations."""
    if found is None:
        return True
    explicit, steps = stepper_of(WHERE_SMOOTH), standing.steps - plan.since.steps
    own = THRESHOLDS.implicit_cost * (standing.evaluations - plan.since.evaluations) / max(steps, 1)
    return found.limit / found.omega_h * own >= explicit.attempt_cost + explicit.error_cost + 1


def _pays(plan: Plan, standing: Standing, other: str, march: March, end: float) -> tuple[bool, bool]:
    """Whether a trial of the other method gets on faster than this one has since the last look, for its evaluations;
    and whether the run's end has cut it short. It may halt at an event before."""
    tally, reached = Tally(), [(standing.state.t, standing.evaluations)]
    half, shaped = THRESHOLDS.trial_steps // 2, False

    def look(there: Standing) -> bool:
        nonlocal shaped
        shaped = shaped or there.shaped
        reached.append((there.state.t, there.evaluations))
        looks.due = there.attempts + half
        return len(reached) > 2

    looks = Looks(standing.attempts + half, look)
    try:
        for _ in march(other, handed_over(standing), tally, looks):
            pass
        if len(reached) <= 2:
            shaped = True
            reached.append((end, tally.evaluations))
    except Halted as halted:
        shaped = shaped or halted.standing.shaped
        reached.append((halted.standing.state.t, tally.evaluations))
    except SimulationError:
        reached.clear()
    plan.trials += 1
    plan.tried += tally.evaluations - standing.evaluations
    if not reached:
        return False, shaped
    own = _speed((plan.since.time, plan.since.evaluations), reached[0])
    dearer = 1.0 / THRESHOLDS.implicit_cost if plan.is_stiff else THRESHOLDS.implicit_cost
    return _speed(*reached[-2:]) > THRESHOLDS.quicker * dearer * own, shaped


def _speed(before: tuple[float, int], after: tuple[float, int]) -> float:
    """Simulated time for an evaluation, s."""
    return (after[0] - before[0]) / max(after[1] - before[1], 1)
