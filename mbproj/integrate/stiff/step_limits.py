"""The limits of a step in a run with error control: the error of the step by bodies and states, or the force or state
that limits it for stability alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import may_overflow
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.errors import SimulationError
from mbproj.integrate.formulations.choice import choose
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.formulations.stage_equations import StageEquations
from mbproj.integrate.loop.carried import attempted
from mbproj.integrate.loop.step_end import first_point
from mbproj.integrate.loop.step_size import error_norm
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.steppers.methods import stepper_of
from mbproj.integrate.stiff.modes_at_a_step import FastModes, against
from mbproj.model.system import System
from mbproj.registry import integrators
from mbproj.scene.records import Settings
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True)
class StepLimit:
    """A step of size `step` (s) from `time` on (s), and its error in tolerances, NaN where it cannot be made. `shares`:
    the part of each body and state in the square of the error, the largest first. `reason`: the limit other than
    accuracy, "" for none."""

    time: float
    step: float
    error: float
    shares: tuple[tuple[str, float], ...]
    reason: str


def step_limit(system: System, state: State, settings: Settings, step: float) -> StepLimit:
    """Return the limits of a step of this size from a state, by the integrator and the tolerance of `settings`. The
    full formulation is used for all runs."""
    assert settings.tolerance is not None
    full = replace(settings, formulation="full")
    choice = choose(system, state, full)
    formulation, stepper = FullFormulation.of(system, state, full, choice.redundant), stepper_of(settings.integrator)
    held = _held(FastModes(choice, system), state, settings.integrator, step)
    try:
        with may_overflow():
            point = first_point(formulation, state, Tally())
            tried = attempted(stepper, formulation, point, step)
            tried, estimates = stepper.error(StageEquations(formulation), state.t + step, tried)
    except SimulationError as error:
        return StepLimit(state.t, step, np.nan, (), ": ".join(filter(None, [error.where, error.cause])))
    layout, tolerance = formulation.layout, settings.tolerance
    scale = layout.scale
    weight = scale + np.maximum(np.abs(tried.y), np.abs(tried.y_new))
    of_bodies = (np.array(formulation.parts(estimates[0] / weight)[:2]) ** 2).reshape(2, -1, 7).sum(axis=(0, 2))
    square = np.concatenate([of_bodies, (estimates[0] / weight)[layout["states"]] ** 2])
    part = square / max(float(square.sum()), np.finfo(float).tiny)
    order = np.argsort(-part, kind="stable")
    names = (*system.names.carriers, *(f"state {name}" for name in system.names.states))
    shares = tuple((names[each], float(part[each])) for each in order)
    return StepLimit(state.t, step, error_norm(estimates, tried.y, tried.y_new, tolerance, scale), shares, held)


def _held(modes: FastModes, state: State, integrator: str, step: float) -> str:
    """Return the force or state that holds an explicit step at its limit of stability; "" for none."""
    fastest = None if integrators()[integrator].implicit else modes.fastest(state, step)
    if fastest is None:
        return ""
    found = against(integrator, step, *fastest)
    return f"{found.where}: {found.what}" if found.omega_h >= THRESHOLDS.near_limit * found.limit else ""
