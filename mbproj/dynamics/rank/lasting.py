"""Tells a redundancy that a mechanism has along its motion from a pose that is nearly singular.

Rows that depend on each other along the whole motion do so exactly only where the mechanism's numbers are exact. With
numbers of ten digits their distance from dependence is some 1e-10, with an axis that is tilted by 1e-8 rad some 1e-8. A
pose near a singular one has such distances too. The motion tells them apart: leave the combinations in doubt out, and
move. Those of a redundancy stay closed. Those of a nearly singular pose open, by the square of the way.

Runs in the kernel ask the same where there are rows in doubt (`mbproj.integrate.formulations.redundant_rows`).
"""

from __future__ import annotations

from dataclasses import replace

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
    `in_doubt` where the rows between the two stay closed in motions that do not hold them."""
    free = replace(system, motions=NO_MOTIONS)
    if system.bodies > THRESHOLDS.large or not _is_in_doubt(free, pose):
        return THRESHOLDS.dependent
    q, rng = np.concatenate([pose.position, pose.orientation], axis=-1)[:-1].ravel(), np.random.default_rng(SEED)
    stays = all(_stays_closed(free, q, rng) for _ in range(TRIALS))
    return THRESHOLDS.in_doubt if stays else THRESHOLDS.dependent


def _is_in_doubt(system: System, pose: Pose) -> bool:
    """Whether a combination of the joints' rows is at a distance from dependence that may be either."""
    loops = loops_of(system)
    return any(
        np.any((values > THRESHOLDS.dependent) & (values <= THRESHOLDS.in_doubt))
        for values in (np.linalg.svd(rows, compute_uv=False) for rows in component_rows(system, pose, loops))
    )


def _stays_closed(system: System, q: Array, rng: np.random.Generator) -> bool:
    """Whether all rows stay closed on a way along a random direction, while those in doubt are not held."""
    _, values, V = np.linalg.svd(scaled_rows(system, pose_of(q), NO_CONDITIONS).dense())
    free = V[int(np.count_nonzero(values > THRESHOLDS.in_doubt)) :]
    way = (free @ rng.normal(size=V.shape[1])) @ free
    size = float(np.abs(way).max(initial=0.0))
    if size < THRESHOLDS.no_motion:
        return True  # no motion is possible
    _, left = closed(system.at_positions, moved(system, q, THRESHOLDS.long_way * way / size))
    return bool(np.abs(left).max(initial=0.0) <= THRESHOLDS.dependent)


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
        trial = moved(system, q, np.linalg.lstsq(R, -left, rcond=THRESHOLDS.in_doubt)[0])
        trial_left = scaled_residual(system, pose_of(trial), NO_CONDITIONS, NO_DRIVE)
        if not np.linalg.norm(trial_left) < np.linalg.norm(left):
            break
        q, left = trial, trial_left
    return q, left
