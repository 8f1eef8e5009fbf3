"""Checks of short runs with the scene's own settings: the integrator's order, the energy balance, closed joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.dynamics import State
from mbproj.integrate.events.law_switches import switches_of
from mbproj.registry import PROJECTIONS, integrators, with_fixed_steps
from mbproj.studies.measure.solve import Solution
from mbproj.studies.verify.case import Case, ShortRun
from mbproj.studies.verify.finding import Finding, Found
from mbproj.studies.verify.rounded import EPS
from mbproj.studies.verify.runs import ABOVE, Order, ShortRuns
from mbproj.thresholds import THRESHOLDS

#: An observed order is rounded to the nearest whole number.
ROUNDED = 0.5
#: An observed order with a larger uncertainty than this tells nothing.
UNTOLD = 2.0
#: The fewest runs that give an order.
FEWEST = 3
#: Energies below this part of Σm (rate × length)² count as zero.
STILL = 1e-12


def observed_order(case: Case) -> Found:
    """Check that the error at a run's end falls with the step at the integrator's order or faster. Of all motions the
    one with the lowest order counts."""
    findings = [(motion.name, _order_of(case, motion)) for motion in case.motions]
    remarked = [replace(each, remark=f"{each.remark}, {name}") for name, each in findings if isinstance(each, Finding)]
    return min(remarked, key=lambda each: each.measured - each.allowed) if remarked else findings[-1][1]


def _order_of(case: Case, motion: ShortRun) -> Found:
    runs, obstacle = motion.runs, _obstacle(case, motion)
    if obstacle:
        return obstacle
    order = runs.order(runs.errors) if len(runs.solutions) >= FEWEST else None
    if runs.failure is not None and runs.failure.status == "refused":  # the start moves into a stop
        return str(runs.failure)
    if order is None:
        unseen = "its error is no more than round-off and the projection leave: no order can be seen"
        return _stopped(case, runs) if runs.failure else unseen
    return _compared(case, order, "")


def energy_balance(case: Case) -> Found:
    """Check that the error of the energy balance falls with the step at the integrator's order, or is round-off. The
    balance is the energy less the work, plus the losses of dampers."""
    motion = case.motions[-1]
    runs, obstacle = motion.runs, _obstacle(case, motion)
    if obstacle:
        return obstacle
    if len(runs.solutions) < FEWEST:
        return _stopped(case, runs)
    size, system = max(map(_energy, runs.solutions)), case.system
    if size <= STILL * float(system.mass.sum()) * (case.rate * system.length) ** 2:
        return "nothing moves, and no energy changes"
    drifts = np.array([np.abs(each.energy_balance).max() for each in runs.solutions]) / size
    order = runs.order(drifts)
    if order is None:
        return Finding(float(drifts.min()), ABOVE * runs.floor, "of the energy, at the best step: round-off")
    return _compared(case, order, f", from {drifts[0]:.0e} of the energy to {drifts.min():.0e}")


def _compared(case: Case, order: Order, remark: str) -> Found:
    """Compare an observed order with the integrator's. It may be lower by its own uncertainty and by `ROUNDED`."""
    name = with_fixed_steps(case.scene.settings.integrator)
    wanted = integrators()[name].order
    if order.uncertainty > UNTOLD:
        return f"its errors fall too unevenly to tell an order ({order.value:.1f} ± {order.uncertainty:.1f})"
    said = f"{name} has order {wanted}, seen to ± {order.uncertainty:.1g}{remark}"
    return Finding(order.value, wanted - ROUNDED - order.uncertainty, said, at_least=True)


def joints_closed(case: Case) -> Found:
    """Compare the largest |C| after any step with the tolerance of the stop test."""
    own = case.scene.settings.projection
    if not PROJECTIONS[own.method].corrects:
        return f"'{own.method}' does not close the joints"
    if not own.position or own.every > 1 or own.threshold is not None:
        return "the scene does not project its positions after every step"
    if own.test == "paper":
        return "the paper's stop test measures corrections, not how far joints are open"
    if not case.runs.solutions:
        return _stopped(case, case.runs)
    reports = [each.report for each in case.runs.solutions if each.report is not None]
    worst = max((report.position_violation for report in reports), key=lambda each: each.value)
    largest = max(float(np.abs(each.body_position).max()) for each in case.runs.solutions) + case.system.length
    return Finding(
        worst.value, own.tolerance or max(THRESHOLDS.closed_to, 4.0 * EPS * largest), f"m or rad, {worst.owner}"
    )


def _stopped(case: Case, runs: ShortRuns) -> Found:
    """Return a failed finding for runs that do not get to their end."""
    wanted = integrators()[with_fixed_steps(case.scene.settings.integrator)].order
    return Finding(0.0, wanted - ROUNDED, f"the run stops: {runs.failure}", at_least=True)


def _energy(solution: Solution) -> float:
    """The largest kinetic energy plus the range of the potential energy, J."""
    potential = solution.potential_energy
    return float(solution.kinetic_energy.max() + potential.max() - potential.min())


def _obstacle(case: Case, motion: ShortRun) -> str | None:
    """The reason why no order can be expected; None where one can."""
    if motion.runs.split:
        return (
            f"steps are split for a shorter movement ({motion.runs.split}): then the error does not fall with the step"
        )
    if case.system.stops is not None and motion.runs.is_level:
        return "the motion meets a stop, which has steps of its own: the error does not fall with the run's step"
    passed = motion.runs.passed or _edge_at_start(case, motion.state)
    return f"fixed steps pass over edges of laws, where no method keeps its order ({passed})" if passed else None


def _edge_at_start(case: Case, state: State) -> str:
    """The switch of a law that the start lies exactly on; "" where there is none."""
    switches = switches_of(case.system)
    if switches is None:
        return ""
    free = np.flatnonzero(np.isnan(switches.branches(state.instant(case.system))))
    return f"{switches.owner(free[0])}: {switches.what(free[0])}, at the start" if len(free) else ""
