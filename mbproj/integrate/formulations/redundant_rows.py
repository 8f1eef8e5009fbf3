"""Rows that follow from the others wherever a mechanism goes, counted in the kernel: they can be left out."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.thresholds import THRESHOLDS

#: Directions that are tried.
TRIALS = 3


def count_redundant(compiled: Compiled, state: State) -> int | None:
    """How many of the kernel's rows depend on the others at `state` and stay so in motion; None where some do so at
    this pose only, so that it is singular."""
    compiled.model.redundant = 0
    y, equations, count = compiled.state(state.q, state.v), compiled.equations(), 0
    for threshold in (THRESHOLDS.redundant_from, THRESHOLDS.redundant_between, THRESHOLDS.redundant_to):
        count = equations.dependent_rows(y, state.t, threshold)
        if count == 0 or _stay_closed(compiled, state, count):
            return count
    return None


def _stay_closed(compiled: Compiled, state: State, count: int) -> bool:
    """Whether rows that are left out stay closed where the others are kept so, in motions along random directions."""
    compiled.model.redundant = count
    equations, rng = compiled.equations(), np.random.default_rng(0)
    rows = equations.rows(compiled.state(state.q, state.v), state.t)
    closed = all(_stays_closed(compiled, equations, rows, state, rng) for _ in range(TRIALS))
    compiled.model.redundant = 0
    return closed


def _stays_closed(
    compiled: Compiled, equations: Any, rows: dict[str, Any], state: State, rng: np.random.Generator
) -> bool:
    def corrected(t: float, q: Array, v: Array) -> tuple[Array, Array] | None:
        """The state nearest to (q, v) that the rows held allow."""
        y = equations.corrected(compiled.state(q, v), t, rows)
        return None if y is None else compiled.coordinates(y)

    system = compiled.system
    weights = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
    moving = corrected(state.t, state.q, state.v + weights * rng.normal(size=len(weights)))
    if moving is None:
        return False
    rate = float(np.abs(moving[1] / weights).max())
    if rate < THRESHOLDS.redundant_open:
        return True  # nothing can move
    seconds = THRESHOLDS.redundant_moved / rate
    moved = corrected(state.t + seconds, state.q + seconds * moving[1], moving[1])
    if moved is None:
        return False
    C = equations.constraint(compiled.state(*moved), state.t + seconds)
    return bool(np.all(np.abs(C) <= THRESHOLDS.redundant_open * compiled.row_scale))
