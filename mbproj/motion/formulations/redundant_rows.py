"""The rows that a run in the kernel holds: rows that follow from the others throughout the motion are left out.

They are found before the run, from the pose at which the scene draws the mechanism, wherever the run begins. Off the
constraints each choice of rows is another differential equation: a choice by the start, or by the poses that a run has
passed, would make its derivative depend on the past.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from mbproj.base.arrays import Array, may_overflow, numbers
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.settings import ProjectionSettings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, assemble
from mbproj.model.compile.mechanism import Guess
from mbproj.motion.formulations.compiled import Compiled

#: The number of random directions that are tried.
TRIALS = 3


def settle_rows(compiled: Compiled, state: State, projection: ProjectionSettings | None = None) -> int | None:
    """Set the rows that the kernel's model holds at most poses of a run with this projection. Return the number of
    redundant rows, or None as `count_redundant` does."""
    compiled.settled = projection or ProjectionSettings()
    y = compiled.state(state.q, state.v)
    first = _left_out(compiled, state, y)
    if first is None:
        return None
    count = compiled.model.rows.redundant
    if count:
        state, first = _as_drawn(compiled, state, count, first)
        y = compiled.state(state.q, state.v)
    usual = _usual(compiled, state, y, count, first)
    if usual is not None:
        compiled.hold(usual)
    return count


def _as_drawn(compiled: Compiled, start: State, count: int, first: list[int]) -> tuple[State, list[int]]:
    """Return the state at which the scene draws the mechanism, closed, with no speed but that of its motions, and the
    rows left out there. The `start` and its rows `first` stand where that does not close, or where not exactly `count`
    rows depend on the others there."""
    from mbproj.equations.rank.row_space import NO_CONDITIONS

    system, rows = compiled.system, compiled.model.rows
    try:
        drawn = assemble(system, Guess(system.drawn, np.zeros(7 * system.bodies), NO_CONDITIONS, NO_CONDITIONS))
    except (InputError, SimulationError):
        return start, first
    if np.array_equal(drawn.q, start.q):
        return drawn, first  # the same pose, whose rows a large mechanism need not count again
    others = _left_out(compiled, drawn, compiled.state(drawn.q, drawn.v))
    if others is not None and compiled.model.rows.redundant == count:
        return drawn, others
    compiled.hold(rows)
    return start, first


def count_redundant(compiled: Compiled, state: State) -> int | None:
    """Tell the kernel's model how many of all rows depend on the others at `state` and in motion, and return that
    number. The kernel then holds the best rows at each pose. Return None where rows depend on others at this pose only,
    which is singular."""
    y = compiled.state(state.q, state.v)
    return None if _left_out(compiled, state, y) is None else compiled.model.rows.redundant


def _left_out(compiled: Compiled, state: State, y: Array) -> list[int] | None:
    """Count the redundant rows as `count_redundant` does, and return the numbers of those left out at `state`, whose
    kernel's state is y, or None."""
    compiled.hold(compiled.core.UsualRows())
    equations, within = compiled.equations(), 0.0
    for threshold in (
        THRESHOLDS.half_digits,
        math.sqrt(THRESHOLDS.half_digits * THRESHOLDS.rounding),
        THRESHOLDS.rounding,
    ):
        count = int(equations.dependent_rows(y, state.t, threshold))
        if count == 0:
            return []
        compiled.hold(compiled.core.UsualRows(count))
        first: list[int] = compiled.equations().left_out(y, state.t)
        within = within or _floor(compiled, state)
        if _stay_closed(compiled, state, first, within):
            return first
        compiled.hold(compiled.core.UsualRows())
    return None


def _usual(compiled: Compiled, state: State, y: Array, count: int, first: list[int]) -> Any:
    """Return the rows to leave out, and the usual pivots, such that the other rows are well conditioned at most poses
    of a walk. None where the model needs no change. The walk begins at `state`, which is the kernel's `y`.

    The walk of a large mechanism is short and does not show which poses are rare. Then the rows `first` are left out,
    and the least pivots over the walk are the usual ones."""
    equations = compiled.equations()
    at_start, even_there = equations.pivots(y, state.t, first)
    if count == 0 and numbers(at_start).min(initial=np.inf) >= THRESHOLDS.near_branch:
        return None
    if even_there > 0.0:  # small where lengths differ: compared with 1, rows would seem dependent at every pose
        compiled.hold(compiled.core.UsualRows(count, [], [], even_there))
        equations = compiled.equations()
    length = 1 + THRESHOLDS.walked_bodies // compiled.system.bodies
    is_short = length < THRESHOLDS.most_walked
    if is_short:
        poses, choices = list(_walk(compiled, equations, state, length, first)), [tuple(first)]
    else:
        poses = list(_walk(compiled, equations, state, THRESHOLDS.most_walked))
        choices = sorted({tuple(equations.left_out(*pose)) for pose in poses})
    of_choices = [[equations.pivots(*pose, list(rows)) for pose in poses] for rows in choices]
    even = numbers([[each[1] for each in of_rows] for of_rows in of_choices])
    worst = np.quantile(even, THRESHOLDS.seldom, axis=1)
    best = int(np.argmax(worst >= THRESHOLDS.serve_alike * worst.max()))
    # A walk may enter a branch on which every pose is singular: such poses are left out.
    regular = [each for each in of_choices[best] if each[1] > 0.0]
    pivots = numbers([each[0] for each in regular])
    if not regular or (count == 0 and np.median(pivots.min(axis=1)) >= THRESHOLDS.near_branch):
        return compiled.core.UsualRows(count)
    usual = pivots.min(axis=0) if is_short else np.median(pivots, axis=0)
    usual_even = np.median(numbers([each[1] for each in regular])).item()
    return compiled.core.UsualRows(count, list(choices[best]), usual.tolist(), usual_even)


def _walk(
    compiled: Compiled, equations: Any, state: State, length: int, left_out: list[int] | None = None
) -> Iterator[tuple[Array, float]]:
    """The poses of a walk of this length with closed joints, as states and times. It roughly keeps its direction from
    the start, and turns back where it ends. The rows `left_out` are not held. Without this argument the kernel leaves
    out the worst rows of each pose."""
    system, rng = compiled.system, np.random.default_rng(0)
    weights = np.tile(numbers([system.length] * 3 + [1.0] * 4), system.bodies)
    t, q, v, rate, seconds = state.t, state.q, state.v, 1.0, 0.0
    for _ in range(length):
        push = v + 0.5 * rate * weights * rng.normal(size=len(v))
        corrected = _corrected(compiled, equations, t + seconds, q + seconds * v, push, left_out)
        if corrected is None:
            v = -v
            continue
        t += seconds
        y, q, v = corrected
        yield y, t
        rate = np.abs(v / weights).max().item()
        if rate < THRESHOLDS.dependent:
            return  # no motion is possible
        seconds = THRESHOLDS.long_way / rate


def _corrected(
    compiled: Compiled, equations: Any, t: float, q: Array, v: Array, left_out: list[int] | None
) -> tuple[Array, Array, Array] | None:
    """Return the state y nearest to (q, v) that the held rows allow, and its coordinates; None where there is none, or
    where the squares of its numbers overflow."""
    with may_overflow():
        y = equations.corrected(compiled.state(q, v), t, left_out)
        if y is None:
            return None
        q, v = compiled.coordinates(y)
        return (y, q, v) if np.isfinite(q @ q + v @ v) else None


def _floor(compiled: Compiled, state: State) -> float:
    """Return the distance within which rows that are left out stay closed: more where `check`, too, counts rows whose
    distance from dependence is in doubt as redundant."""
    from mbproj.equations.kinematics import pose_of
    from mbproj.equations.rank.row_space import floor_at

    return floor_at(compiled.system, pose_of(state.q))


def _stay_closed(compiled: Compiled, state: State, left_out: list[int], within: float) -> bool:
    """Whether rows that are left out stay closed, within a distance, in motions along random directions while the
    others are held."""
    equations, rng = compiled.equations(), np.random.default_rng(0)
    return all(_stays_closed(compiled, equations, left_out, state, rng, within) for _ in range(TRIALS))


def _stays_closed(
    compiled: Compiled, equations: Any, left_out: list[int], state: State, rng: np.random.Generator, within: float
) -> bool:
    system = compiled.system
    weights = np.tile(numbers([system.length] * 3 + [1.0] * 4), system.bodies)
    push = state.v + weights * rng.normal(size=len(weights))
    moving = _corrected(compiled, equations, state.t, state.q, push, left_out)
    if moving is None:
        return False
    _, q, v = moving
    rate = np.abs(v / weights).max().item()
    if rate < THRESHOLDS.dependent:
        return True  # no motion is possible
    seconds = THRESHOLDS.short_way / rate
    moved = _corrected(compiled, equations, state.t + seconds, q + seconds * v, v, left_out)
    if moved is None:
        return False
    open_by = np.abs(equations.constraint(moved[0], state.t + seconds))
    if system.rolls:  # rows at velocity level have no C to open
        open_by = np.maximum(open_by, np.abs(equations.constraint_velocity(moved[0], state.t + seconds)) / rate)
    return bool(np.all(open_by <= within * compiled.row_scale))
