"""Tells a redundancy that a mechanism has along its motion from a pose that is nearly singular.

Rows that depend on each other along the whole motion do so exactly only where the mechanism's numbers are exact. With
numbers of ten digits their distance from dependence is some 1e-10, with an axis that is tilted by 1e-8 rad some 1e-8. A
pose near a singular one has such distances too. The motion tells them apart: leave the combinations in doubt out, and
move. Those of a redundancy stay closed, and near to dependence. Those of a nearly singular pose leave it.

Runs in the kernel ask the same where there are rows in doubt (`mbproj.integrate.formulations.redundant_rows`).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import scaled_residual, scaled_rows
from mbproj.dynamics.assembly.gauss_newton import moved
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.equations.motions import NO_DRIVE
from mbproj.dynamics.rank.components import component_rows, loops_of
from mbproj.model.channels import NO_MOTIONS
from mbproj.model.system import Conditions, System
from mbproj.thresholds import THRESHOLDS

#: The number of random directions that are tried, and their seed.
TRIALS, SEED = 3, 0
NO_CONDITIONS = Conditions(np.zeros(0, dtype=np.intp), np.zeros(0))


def floor_at(system: System, pose: Pose) -> float:
    """Return the largest distance from dependence at which rows count as dependent at a closed pose: `dependent`, or
    `in_doubt` where rows beyond round-off, up to it, depend on the others along the motion."""
    loops = loops_of(system)
    if not loops or system.bodies > THRESHOLDS.large:
        return THRESHOLDS.dependent
    return _floor(system, np.concatenate([pose.position, pose.orientation], axis=-1)[:-1].tobytes())


@lru_cache(maxsize=16)
def _floor(system: System, coordinates: bytes) -> float:
    """Return the result of `floor_at` at a pose q; one pose is asked for by many."""
    free, q, rng = replace(system, motions=NO_MOTIONS), np.frombuffer(coordinates), np.random.default_rng(SEED)
    small = _small_distances(free, q)
    if not len(small):
        return THRESHOLDS.dependent
    is_in_doubt = bool(small.max() > THRESHOLDS.rounding)
    for _ in range(TRIALS):
        there, left = _moved_on(free, q, rng)
        then = _small_distances(free, there)
        is_in_doubt = is_in_doubt or bool(then.max(initial=0.0) > THRESHOLDS.rounding)
        lasts = len(then) >= len(small) and np.abs(left).max(initial=0.0) <= THRESHOLDS.dependent
        if not (lasts and is_in_doubt):
            return THRESHOLDS.dependent
    return THRESHOLDS.in_doubt


def _small_distances(system: System, q: Array) -> Array:
    """Return the singular values of the joints' rows that may be those of dependent ones."""
    rows = component_rows(system, pose_of(q), loops_of(system))
    values = [np.linalg.svd(each, compute_uv=False) for each in rows if len(each)]
    return np.concatenate([each[each <= THRESHOLDS.in_doubt] for each in values] or [np.zeros(0)])


def _moved_on(system: System, q: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return the pose some way along a random direction, and what is open there, while rows in doubt are not held."""
    _, values, V = np.linalg.svd(scaled_rows(system, pose_of(q), NO_CONDITIONS).dense())
    free = V[int(np.count_nonzero(values > THRESHOLDS.in_doubt)) :]
    way: Array = np.asarray((free @ rng.normal(size=V.shape[1])) @ free, dtype=float)
    size = float(np.abs(way).max(initial=0.0))
    if size < THRESHOLDS.no_motion:
        return q, np.zeros(0)  # no motion is possible
    return closed(system.at_positions, moved(system, q, way * (THRESHOLDS.long_way / size)))


def closed(system: System, q: Array) -> tuple[Array, Array]:
    """Return the closed pose next to q (7n,), and the violation left there, in rad and parts of the length. The system
    has rows at position level alone, and no motions.

    Combinations of rows in doubt do not count for the steps: divided by their distance, the last digits of a violation
    would move the mechanism."""
    left = scaled_residual(system, pose_of(q), NO_CONDITIONS, NO_DRIVE)
    for _ in range(THRESHOLDS.most_passes):
        if not np.abs(left).max(initial=0.0) > THRESHOLDS.no_digits:
            break
        R = scaled_rows(system, pose_of(q), NO_CONDITIONS).dense()
        step = np.asarray(np.linalg.lstsq(R, -left, rcond=THRESHOLDS.in_doubt)[0], dtype=float)
        trial = moved(system, q, step)
        trial_left = scaled_residual(system, pose_of(trial), NO_CONDITIONS, NO_DRIVE)
        if not np.linalg.norm(trial_left) < np.linalg.norm(left):
            break
        q, left = trial, trial_left
    return q, left
