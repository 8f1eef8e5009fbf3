"""Forward sensitivities along a run: the slopes of the motion by the numbers of a model and by its start.

A *direction* is the effect of one parameter on the model: the slopes of its numbers (masses, points, forces) and of the
state in which the run begins. It is the central difference of two models of one structure. The kernel follows each step
of a run with dual numbers and the factors of the run (`mbproj/kernel/src/solver`). The sizes of the steps are
constants.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, SimulationError
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.kernel_run import Trace
from mbproj.motion.steppers.tableau import tableau_of
from mbproj.motion.time_events import kernel_breaks, kernel_tableau


@dataclass(frozen=True)
class Directions:
    """The slopes of the model's numbers (k, N), and of the kernel's initial state (k, S), along k directions."""

    numbers: Array
    start: Array


def slopes_along(trace: Trace, start: Array, directions: Directions, at: Array, y: Array) -> Array:
    """Return the slopes of the kernel's state along each direction, (M, k, S), at ascending times `at` (M,).

    The state is y (M, S) at these times, and `start` (S,) at the start of the run. Raises InputError where slopes are
    not known: contacts, functions with branches, controllers, implicit steps. Raises SimulationError where the
    equations have no unique solution."""
    slopes = _slopes(trace, directions)
    began = trace.leg.start
    if trace.settings.kinematic is True:
        slopes_there: Array = slopes.stand(at, y)
    else:
        if not slopes.start(began, start, np.ascontiguousarray(directions.start)):
            raise SimulationError(began, "the equations have no unique solution")
        first = int(np.searchsorted(at, began, side="right"))
        beginning = np.broadcast_to(slopes.slopes, (first, *slopes.slopes.shape))
        rest = slopes.follow(np.append(began, trace.t), trace.h, trace.y, at[first:], np.ascontiguousarray(y[first:]))
        slopes_there = np.concatenate([beginning, rest])
    if len(slopes_there) < len(at):
        raise SimulationError(float(at[len(slopes_there)]), "the slopes of the motion have no unique solution")
    return slopes_there


def numbers_of(compiled: Compiled) -> Array:
    """Return the kernel's numbers of a model, (N,), in the order of directions."""
    values: Array = getattr(compiled.core, f"{compiled.dimension}Tangents").numbers(compiled.model)
    return values


def structure_of(compiled: Compiled) -> Array:
    """Return the structure that a model shares with its neighbours, as numbers: curves, knots, which numbers are
    where."""
    pattern: Array = getattr(compiled.core, f"{compiled.dimension}Tangents").structure(compiled.model)
    return pattern


def _slopes(trace: Trace, directions: Directions) -> Any:
    """Return the kernel's object that follows a run."""
    compiled, settings = trace.compiled, trace.settings
    kind = getattr(compiled.core, f"{compiled.dimension}Tangents")
    tableau = kernel_tableau(compiled.core, tableau_of(settings.integrator), kinematic=settings.kinematic is True)
    try:
        return kind(
            compiled.model,
            tableau,
            compiled.projection(settings.projection),
            kernel_breaks(trace.leg),
            np.ascontiguousarray(directions.numbers),
        )
    except ValueError as error:
        raise InputError(f"the motion's slopes are not known here: the {error}") from None
