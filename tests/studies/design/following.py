"""Runs with their slopes along directions that neighbours of a model give, for tests of the kernel's dual numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import State
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.kernel_run import Trace
from mbproj.motion.tangents import Directions, numbers_of, slopes_along
from mbproj.motion.time_events import Leg

#: Neighbours of a model on either side, and their weights: the central difference of fourth order.
NEIGHBOURS = ((-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0))
#: Samples and seconds that no run has.
MOST, FOREVER = 2**31, 1e9


@dataclass(frozen=True)
class Followed:
    """A run with its slopes: at the ends of its m steps and at its start, the times (m + 1,), the kernel's states
    (m + 1, S) and their slopes along each direction (m + 1, k, S)."""

    t: Array
    y: Array
    slopes: Array

    def coordinates(self, compiled: Compiled, at: int = -1) -> tuple[Array, Array]:
        """∂q and ∂q' along each direction, (k, 7n) each, at the end of a step."""
        found = [_along(compiled, self.y[at], slope) for slope in self.slopes[at]]
        q, v = (np.array([pair[i] for pair in found]) for i in (0, 1))
        return q, v


def follow(compiled: Compiled, state: State, settings: Settings, directions: Directions) -> Followed:
    """The run from `state`, and how it changes. Raises as `slopes_along` does, and where the run fails."""
    run, start = compiled.run(state, settings), compiled.beginning(state)
    run.keep_path()
    while run.outcome.status == type(run.outcome.status).running:
        run.advance(MOST, FOREVER)
    failed = compiled.failure(run, settings)
    if failed is not None:
        raise failed
    trace = Trace(compiled, settings, Leg.whole(compiled.system, settings, state.t), *run.path)
    times, states = np.append(state.t, trace.t), np.concatenate([start[None], trace.y])
    return Followed(times, states, slopes_along(trace, start, directions, times, states))


def directions_of(
    build: Callable[[Array], tuple[Compiled, State]], values: Sequence[float], widths: Sequence[float]
) -> tuple[Compiled, State, Directions]:
    """The model that is built of the parameters' values, and the direction of each: differences of models that lie some
    of its width to either side. No run is made for them, and what is linear in a parameter is exact."""
    at = np.asarray(values, dtype=float)
    compiled, state = build(at)
    numbers, starts = [], []
    for k, width in enumerate(widths):
        sides = []
        for place, weight in NEIGHBOURS:
            there = at.copy()
            there[k] += place * width
            other, begins = build(there)
            own = numbers_of(other)
            if own.shape != numbers_of(compiled).shape:
                raise InputError("a parameter changes the structure of the model: it has no slopes there")
            sides.append((weight / width, own, other.beginning(begins)))
        numbers.append(sum(weight * own for weight, own, _ in sides))
        starts.append(sum(weight * start for weight, _, start in sides))
    size = len(compiled.beginning(state))
    found = Directions(
        np.array(numbers).reshape(len(numbers), -1), np.array(starts).reshape(len(starts), size if starts else 0)
    )
    return compiled, state, found


def _along(compiled: Compiled, y: Array, slope: Array) -> tuple[Array, Array]:
    """∂q and ∂q' of the slope of the kernel's state: differences of the map between the two alone."""
    scale = 1e-3 / max(float(np.abs(slope).max(initial=0.0)), 1e-300)
    sides = [
        [weight / scale * part for part in compiled.coordinates(compiled.bodies_of(y + place * scale * slope))]
        for place, weight in NEIGHBOURS
    ]
    q, v = (sum(side[i] for side in sides) for i in (0, 1))
    return np.asarray(q), np.asarray(v)
