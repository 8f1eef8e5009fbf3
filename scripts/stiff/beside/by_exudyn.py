"""Exudyn, on the models of `exudyn_models`.

As its documentation advises (https://exudyn.readthedocs.io): the generalised-alpha solver (spectral radius 0.9 by
default) or the trapezoidal rule with constraints of index 2, both implicit and of second order with fixed steps, and
modified Newton; DOPRI5 with automatic steps for systems without constraints, the trees.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from time import process_time
from typing import Any

import exudyn as exu
import numpy as np

from stiff.beside.exudyn_models import Model, bodies, governor, trees
from stiff.beside.four_bar import FourBar
from stiff.beside.governor import Governor
from stiff.beside.program import END, SAMPLES, TIMES, Array, NotDone, Problem, Program, Setting, steps, tolerances

IMPLICIT = (exu.DynamicSolverType.GeneralizedAlpha, exu.DynamicSolverType.TrapezoidalIndex2)


def _chosen(end: float, count: int, solver: Any) -> tuple[Any, Any]:
    """The settings and the solver."""
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = end
    settings.timeIntegration.numberOfSteps = count
    settings.timeIntegration.adaptiveStep = False  # where Newton fails the setting has failed
    settings.timeIntegration.solverType = solver
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = END / SAMPLES
    settings.parallel.numberOfThreads = 1
    if solver == exu.DynamicSolverType.TrapezoidalIndex2:
        settings.timeIntegration.generalizedAlpha.useIndex2Constraints = True
        settings.timeIntegration.generalizedAlpha.useNewmark = True
    return settings, exu.MainSolverImplicitSecondOrder() if solver in IMPLICIT else exu.MainSolverExplicit()


def _solve(model: Model, settings: Any, solver: Any) -> float:
    try:
        if not solver.InitializeSolver(model.system, settings):
            raise NotDone("it does not start")
        begun = process_time()
        solver.SolveSteps(model.system, settings)
        seconds = process_time() - begun
        solver.FinalizeSolver(model.system, settings)
    except (RuntimeError, ValueError) as error:
        raise NotDone(str(error)) from error
    return seconds


def _points(model: Model, times: Array) -> Array:
    columns = []
    for sensor, which in zip(model.sensors, model.columns, strict=True):
        rows = np.atleast_2d(model.system.GetSensorStoredData(sensor))
        where = np.minimum(np.searchsorted(rows[:, 0], times - 1e-9), len(rows) - 1)
        if np.abs(rows[where, 0] - times).max() > 1e-9:
            raise NotDone("it does not reach the end")
        columns.append(rows[where][:, 1:][:, which])
    return np.hstack(columns)


def _fixed(model: Model, count: int, solver: Any) -> tuple[float, Array]:
    seconds = _solve(model, *_chosen(END, count * SAMPLES, solver))
    return seconds, _points(model, TIMES)


def _implicit(model: Model) -> Iterator[Setting]:
    for count, solver in product(steps(), IMPLICIT):
        yield Setting(f"{1e6 * END / SAMPLES / count:.3g} us, {solver.name}", partial(_fixed, model, count, solver))


def _adaptive(model: Model, tolerance: float) -> tuple[float, Array]:
    points, seconds = [], 0.0
    for time in TIMES:  # only the last one counts
        settings, solver = _chosen(float(time), 100, exu.DynamicSolverType.DOPRI5)
        settings.timeIntegration.automaticStepSize = True
        settings.timeIntegration.initialStepSize = 1e-6
        settings.timeIntegration.minimumStepSize = 1e-12
        settings.timeIntegration.absoluteTolerance = settings.timeIntegration.relativeTolerance = tolerance
        seconds = _solve(model, settings, solver)
        points.append(_points(model, np.array([time]))[0])
    return seconds, np.array(points)


def _explicit(model: Model) -> Iterator[Setting]:
    for tolerance in tolerances(10):
        yield Setting(f"DOPRI5, tolerance {tolerance:.0e}", partial(_adaptive, model, tolerance))


def _accelerations(model: Model) -> Array:
    settings, solver = _chosen(1e-9, 1, IMPLICIT[0])
    if not solver.InitializeSolver(model.system, settings):
        raise NotDone("it does not start")
    found = np.array(model.system.systemData.GetODE2Coordinates_tt())
    solver.FinalizeSolver(model.system, settings)
    return model.coordinates(found)


def programs(problem: Problem) -> list[Program]:
    """Implicit on bodies; of the four-bar on trees as well, and explicit there."""
    if isinstance(problem, Governor):
        own = governor(problem)
        return [Program("Exudyn, bodies, implicit", partial(_implicit, own), partial(_accelerations, own))]
    assert isinstance(problem, FourBar)
    joined, free = bodies(problem), trees(problem)
    return [
        Program("Exudyn, bodies, implicit", partial(_implicit, joined), partial(_accelerations, joined)),
        Program("Exudyn, trees, implicit", partial(_implicit, free), partial(_accelerations, free)),
        Program("Exudyn, trees, DOPRI5", partial(_explicit, free), partial(_accelerations, free)),
    ]
