"""The limits of a step in a run with error control: the error of the step by bodies and states, or the force or state
that limits it for stability alone."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, may_overflow
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.errors import SimulationError
from mbproj.integrate.formulations.choice import Choice, choose
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.numpy_loop import attempted, error_norm, first_point
from mbproj.integrate.reporting.failures import UNSOLVED
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.steppers.runge_kutta import ExplicitRungeKutta
from mbproj.integrate.steppers.tableau import load_tableau
from mbproj.integrate.stiff.modes_at_a_step import FastModes, against
from mbproj.model.system import System
from mbproj.registry import is_explicit
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
    full = replace(settings, formulation="full", duration=step, output_step=step)
    choice = choose(system, state, full)
    held = _stiff_cause(FastModes(choice, system), state, settings.integrator, step)
    try:
        with may_overflow():
            tried = (_explicit if is_explicit(settings.integrator) else _implicit)(choice, system, state, full)
    except SimulationError as error:
        return StepLimit(state.t, step, np.nan, (), ": ".join(filter(None, [error.where, error.cause])))
    square = np.concatenate([tried.of_bodies, tried.of_states]) ** 2
    part = square / max(float(square.sum()), np.finfo(float).tiny)
    order = np.argsort(-part, kind="stable")
    names = (*system.names.carriers, *(f"state {name}" for name in system.names.states))
    shares = tuple((names[each], float(part[each])) for each in order)
    return StepLimit(state.t, step, tried.norm, shares, held)


class _TriedStep(NamedTuple):
    """The `norm` of the error of a step, in tolerances; and the sizes of its parts, of bodies (n,) and states (K,)."""

    norm: float
    of_bodies: Array
    of_states: Array


def _explicit(choice: Choice, system: System, state: State, settings: Settings) -> _TriedStep:
    """Return the error of an explicit step. Raises SimulationError where it cannot be made."""
    formulation = FullFormulation.of(system, state, settings, choice.redundant)
    stepper, step = ExplicitRungeKutta(load_tableau(settings.integrator)), settings.duration or 0.0
    point = first_point(formulation, state, Tally())
    tried = attempted(stepper, formulation.derivative, point, step)
    tried, estimates = stepper.error(formulation.derivative, state.t + step, tried)
    layout, tolerance = formulation.layout, settings.tolerance or 0.0
    part = estimates[0] / (layout.scale + np.maximum(np.abs(tried.y), np.abs(tried.y_new)))
    of_bodies = np.array(formulation.split(part)[:2]).reshape(2, -1, 7)
    norm = error_norm(estimates, tried.y, tried.y_new, tolerance, layout.scale)
    return _TriedStep(norm, np.linalg.norm(of_bodies, axis=(0, 2)), part[layout["states"]])


def _implicit(choice: Choice, system: System, state: State, settings: Settings) -> _TriedStep:
    """Return the error of an implicit step, which the kernel makes. Raises SimulationError where it cannot be made."""
    compiled, step = choice.compiled, settings.duration or 0.0
    assert compiled is not None
    run = compiled.run(state, settings)
    tried = run.try_step(step)
    if tried is None:
        raise compiled.failure(run, settings) or SimulationError(state.t, UNSOLVED)
    (y_new, error), layout, tolerance = tried, compiled.layout, settings.tolerance or 0.0
    y, own = compiled.beginning(state), layout.controlled
    part = error / (layout.scale + np.maximum(np.abs(y), np.abs(y_new)))
    norm = error_norm(error[None, own], y[own], y_new[own], tolerance, layout.scale[own])
    return _TriedStep(norm, np.linalg.norm(compiled.bodies_of(part), axis=-1), part[layout["states"]])


def _stiff_cause(modes: FastModes, state: State, integrator: str, step: float) -> str:
    """Return the force or state that holds an explicit step at its limit of stability; "" for none."""
    fastest = modes.fastest(state, step) if is_explicit(integrator) else None
    if fastest is None:
        return ""
    stiffness = against(integrator, step, *fastest)
    return (
        f"{stiffness.where}: {stiffness.what}" if stiffness.omega_h >= THRESHOLDS.near_limit * stiffness.limit else ""
    )
