"""Exudyn: a kinematic tree with its explicit DOPRI5, and bodies in redundant coordinates with its implicit solver.

As its documentation advises (https://exudyn.readthedocs.io): explicit solvers only for systems without constraints,
here the kinematic tree, with automatic step size; for constraints the implicit generalised-alpha solver (spectral
radius 0.9 by default) or the trapezoidal rule with constraints of index 2, both of second order and both tried;
modified Newton; the dense solver for small systems and the sparse one for long chains; nothing written to files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import product
from typing import Any

import exudyn as exu
import numpy as np

from peers.exudyn_models import Model, chain_bodies, chain_tree, slider_crank_bodies
from peers.peer import (
    NotConverged,
    Observation,
    Peer,
    Setting,
    ode_label,
    seconds_of,
    steps_per_interval,
    tolerance_label,
    tolerances,
)
from peers.problem import FIVE_BAR, Array, Chain, Mechanism

#: From so many links on the sparse solver is quicker.
SPARSE_LINKS = 20
IMPLICIT = (exu.DynamicSolverType.GeneralizedAlpha, exu.DynamicSolverType.TrapezoidalIndex2)


def _settings(duration: float, steps: int, interval: float) -> Any:
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.adaptiveStep = False  # where Newton fails the setting has failed
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = interval
    settings.parallel.numberOfThreads = 1
    return settings


def _run(model: Model, settings: Any, solver: Any) -> float:
    """Seconds of the solver's steps; the initial values of the model stay as they are."""
    explicit = solver not in IMPLICIT
    settings.timeIntegration.solverType = solver
    dynamic = exu.MainSolverExplicit() if explicit else exu.MainSolverImplicitSecondOrder()
    if solver == exu.DynamicSolverType.TrapezoidalIndex2:
        settings.timeIntegration.generalizedAlpha.useIndex2Constraints = True
        settings.timeIntegration.generalizedAlpha.useNewmark = True
    try:
        if not dynamic.InitializeSolver(model.system, settings):
            raise NotConverged("Exudyn does not start")
        seconds = seconds_of(lambda: dynamic.SolveSteps(model.system, settings))
        dynamic.FinalizeSolver(model.system, settings)
    except (RuntimeError, ValueError) as error:
        raise NotConverged(str(error)) from error
    return seconds


def _rows(model: Model, sensor: int, times: Array) -> Array:
    """A sensor's positions (T, 3) at the times."""
    rows = np.atleast_2d(model.system.GetSensorStoredData(sensor))
    where = np.searchsorted(rows[:, 0], times - 1e-9)
    if (where >= len(rows)).any() or np.abs(rows[where, 0] - times).max() > 1e-9:
        raise NotConverged("Exudyn did not reach the end")
    return np.asarray(rows[where, 1:4])


def _observe(model: Model, settings: Any, solver: Any, times: Array, columns: list[int]) -> Observation:
    _run(model, settings, solver)
    opening = None
    if model.ends is not None:
        first, second = (_rows(model, end, times) for end in model.ends)
        opening = float(np.linalg.norm(first - second, axis=1).max())
    return Observation(_rows(model, model.marker, times)[:, columns], opening)


def _tree(mechanism: Mechanism) -> Iterator[Setting]:
    if mechanism is not FIVE_BAR:
        return
    model = chain_tree(5)
    for tolerance in tolerances(2, 13):

        def reach(time: float, tolerance: float = tolerance) -> float:
            settings = _settings(time, 100, time)
            settings.timeIntegration.automaticStepSize = True
            settings.timeIntegration.initialStepSize = 1e-3
            settings.timeIntegration.minimumStepSize = 1e-10
            settings.timeIntegration.absoluteTolerance = settings.timeIntegration.relativeTolerance = tolerance
            return _run(model, settings, exu.DynamicSolverType.DOPRI5)

        def observe(reach: Callable[[float], float] = reach) -> Observation:
            tips = []
            for time in mechanism.times:
                reach(float(time))
                tips.append(_rows(model, model.marker, np.array([time]))[0, [0, 2]])
            return Observation(np.array(tips))

        yield Setting(tolerance_label(tolerance), partial(reach, mechanism.duration), observe)


def _bodies(mechanism: Mechanism) -> Iterator[Setting]:
    """Rotation vectors with a Lie-group update: of Exudyn's rotations the most accurate a step on these mechanisms."""
    tree = mechanism is FIVE_BAR
    rotation = exu.NodeType.RotationRotationVector
    model, columns = (chain_bodies(5, rotation), [0, 2]) if tree else (slider_crank_bodies(rotation), [0])
    for per_interval, solver in product(steps_per_interval(50, 12_800), IMPLICIT):
        steps = per_interval * len(mechanism.times)

        def settings(interval: float, steps: int = steps) -> Any:
            return _settings(mechanism.duration, steps, interval)

        def integrate(settings: Callable[[float], Any] = settings, solver: Any = solver) -> float:
            return _run(model, settings(mechanism.duration), solver)

        def observe(settings: Callable[[float], Any] = settings, solver: Any = solver) -> Observation:
            return _observe(model, settings(mechanism.interval), solver, mechanism.times, columns)

        yield Setting(f"{ode_label(mechanism.interval / per_interval)}, {solver.name}", integrate, observe)


def _tree_chain(chain: Chain) -> Setting:
    return _chain(chain, chain_tree(chain.links), exu.DynamicSolverType.RK44)


def _bodies_chain(chain: Chain) -> Setting:
    return _chain(chain, chain_bodies(chain.links, exu.NodeType.RotationRotationVector), IMPLICIT[0])


def _chain(chain: Chain, model: Model, solver: Any) -> Setting:
    duration = chain.steps * chain.step

    def settings() -> Any:
        chosen = _settings(duration, chain.steps, duration)
        if chain.links >= SPARSE_LINKS:
            chosen.linearSolverType = exu.LinearSolverType.EigenSparse
        return chosen

    return Setting(
        f"{ode_label(chain.step)}, {solver.name}",
        lambda: _run(model, settings(), solver),
        lambda: _observe(model, settings(), solver, np.array([duration]), [0, 2]),
    )


PEERS = (
    Peer("Exudyn, kinematic tree", _tree, _tree_chain),
    Peer("Exudyn, redundant bodies", _bodies, _bodies_chain),
)
