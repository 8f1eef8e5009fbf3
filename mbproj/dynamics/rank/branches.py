"""Directions in which a mechanism can leave a pose, to second order.

Where rows depend on each other, not each velocity v with C_q v = 0 belongs to a motion: accelerations exist only where
the right-hand sides agree, λᵀγ(v) = 0 for each self-stress λ. These are quadratic forms on null(C_q). At a branch point
their common roots are the tangents of the branches; along a linkage that is always redundant the forms vanish.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.kinematics import Pose, twist_of
from mbproj.dynamics.equations.motions import NO_DRIVE
from mbproj.dynamics.rank.right_hand_sides import tangent_gamma
from mbproj.dynamics.rank.row_space import self_stresses
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def branch_directions(system: System, pose: Pose, motions: Array, trials: Array) -> Array:
    """Return directions (t, 6n) of (δr / length, δθ) along which accelerations exist; t < T where trials lead to none.

    They are near `trials` (T, f), combinations of the `motions` (f, 6n) that C_q allows. `system` has no
    driving motions."""
    if not len(motions):
        return motions
    if len(motions) > THRESHOLDS.many_directions:
        return trials @ motions
    forms = _forms(system, pose, motions)
    roots = [root for trial in trials if (root := _root(forms, trial)) is not None]
    return np.array(roots).reshape(-1, len(motions)) @ motions


def _forms(system: System, pose: Pose, motions: Array) -> Array:
    """Return λᵀγ as symmetric matrices (d, f, f), one for each self-stress, by γ(u + v) - γ(u) - γ(v)."""
    stresses = self_stresses(system, pose)
    count = len(motions)
    alone = [_bent(system, pose, stresses, motion) for motion in motions]
    forms = np.zeros((len(stresses), count, count))
    for i in range(count):
        forms[:, i, i] = alone[i]
        for j in range(i):
            both = _bent(system, pose, stresses, motions[i] + motions[j])
            forms[:, i, j] = forms[:, j, i] = 0.5 * (both - alone[i] - alone[j])
    return forms


def _bent(system: System, pose: Pose, stresses: Array, motion: Array) -> Array:
    """Return λᵀγ (d,) at a velocity (6n,) of (r' / length, ω)."""
    δ = motion.reshape(-1, 6)
    v = np.zeros((len(δ), 7))
    v[:, :3] = system.length * δ[:, :3]
    v[:, 3:] = 0.5 * (np.swapaxes(pose.L[:-1], -1, -2) @ δ[:, 3:, None])[..., 0]
    return np.asarray(stresses @ tangent_gamma(system, pose, twist_of(pose, v.ravel()), NO_DRIVE), dtype=float)


def _root(forms: Array, trial: Array) -> Array | None:
    """Return a unit vector near `trial` at which all forms vanish, by Gauss-Newton; None where it leads to none."""
    z = trial / np.linalg.norm(trial)
    for _ in range(THRESHOLDS.most_passes):
        slope = forms @ z
        values = slope @ z
        if np.abs(values).max(initial=0.0) < THRESHOLDS.rounding:
            break
        across = slope - np.outer(values, z)  # the forms are homogeneous: a shorter z is no better
        z = z - np.linalg.lstsq(2.0 * across, values, rcond=THRESHOLDS.dependent)[0]
        z = z / np.linalg.norm(z)
    return z if np.abs(forms @ z @ z).max(initial=0.0) < THRESHOLDS.dependent else None
