"""Poses that the joints can reach from one pose: a property that holds at all of them is taken to hold along the
motion.

Here are also the directions in which a mechanism can leave a pose, to second order. Where rows depend on each other,
not each velocity v with C_q v = 0 belongs to a motion: accelerations exist only where the right-hand sides agree,
λᵀγ(v) = 0 for each self-stress λ. These are quadratic forms on null(C_q). At a branch point their common roots are the
tangents of the branches; along a linkage that is always redundant the forms vanish."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import scaled_rows
from mbproj.equations.assembly.gauss_newton import moved, shortest
from mbproj.equations.blocks import Rows
from mbproj.equations.kinematics import Pose, pose_of, twist_of
from mbproj.equations.motions import NO_DRIVE
from mbproj.equations.rank.components import Component, component_rows
from mbproj.equations.rank.row_space import NO_CONDITIONS, closed, floor_at, self_stresses, tangent_gamma, unit_rows
from mbproj.model.channels import NO_MOTIONS
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.system import System

#: The number of directions that are followed, the number of random trials for them, and their seed.
DIRECTIONS, TRIALS, SEED = 3, 12, 6


@dataclass(frozen=True, eq=False)
class Nearby:
    """Closed poses within some tenths of the start. `freedom`: the number of directions that the joints leave there to
    first order, without motions. Where there are such directions and no poses, the directions lead nowhere."""

    poses: tuple[Pose, ...]
    freedom: int


def nearby(system: System, q: Array) -> Nearby:
    """Return poses that the joints reach from q (7n,); motions are ignored, because they change with time."""
    free = replace(system, motions=NO_MOTIONS)
    pose = pose_of(q)
    motions = _motions(free, pose)
    # Trials are drawn in all coordinates, because the basis of the allowed motions depends on round-off.
    trials = np.random.default_rng(SEED).normal(size=(TRIALS, 6 * system.bodies)) @ motions.T
    directions = branch_directions(free, pose, motions, trials)[:DIRECTIONS]
    return Nearby(
        tuple(pose_nearby for direction in directions for pose_nearby in _walk(free, q, direction)), len(motions)
    )


def _motions(system: System, pose: Pose) -> Array:
    """Return an orthonormal basis (f, 6n) of the motions of (δr / length, δθ) that the joints allow. For many bodies it
    is a basis of the allowed parts of random motions, more of them than there are degrees of freedom."""
    if system.bodies <= THRESHOLDS.large:
        _, values, vectors = np.linalg.svd(_joint_rows(system, pose), full_matrices=True)
        return np.asarray(vectors[np.count_nonzero(values > floor_at(system, pose)) :], dtype=float)
    rows, count = scaled_rows(system, pose, NO_CONDITIONS), THRESHOLDS.many_directions
    while True:
        count = min(2 * count, 6 * system.bodies)
        drawn = np.random.default_rng(SEED).normal(size=(6 * system.bodies, count))
        _, values, vectors = np.linalg.svd(_allowed(rows, drawn).T, full_matrices=False)
        rank = int(np.count_nonzero(values > THRESHOLDS.no_motion))
        if rank < count or count == 6 * system.bodies:
            return np.asarray(vectors[:rank], dtype=float)


def _walk(system: System, q: Array, direction: Array) -> Iterator[Pose]:
    """Yield poses along a direction (6n,), each some steps further, until one does not close."""
    reached = q
    for step in (THRESHOLDS.short_way, 5.0 * THRESHOLDS.short_way):
        motion = _allowed(scaled_rows(system, pose_of(reached), NO_CONDITIONS), direction)
        size = float(np.abs(motion).max())
        if size < THRESHOLDS.no_motion:
            return
        aim = moved(system, reached, motion * (step / size))
        there, residual = closed(system.at_positions, aim)
        if np.abs(residual).max(initial=0.0) > THRESHOLDS.dependent or _far(system, there, reached) < 0.1 * step:
            return
        yield pose_of(there)
        reached = there


def _allowed(rows: Rows, direction: Array) -> Array:
    """Return the part of a direction (6n,), or of several (6n, k), that the rows do not resist; the directions are
    first scaled to unit length."""
    direction = direction / np.linalg.norm(direction, axis=0)
    for _ in range(2):
        direction = direction - shortest(rows, rows.times(direction), least=THRESHOLDS.in_doubt)
    return direction


def _joint_rows(system: System, pose: Pose) -> Array:
    """Return all rows with unit length, (k, 6n), as those of one component of all bodies."""
    everything = Component(np.arange(system.constraints - system.bodies), np.arange(system.bodies))
    return unit_rows(component_rows(system, pose, [everything])[0])


def _far(system: System, q: Array, start: Array) -> float:
    """Return the largest displacement of a body between two poses, in rad or parts of the length."""
    now, then = q.reshape(-1, 7), start.reshape(-1, 7)
    shift = np.abs(now[:, :3] - then[:, :3]).max() / system.length
    turn = 2.0 * np.abs(matrix_L(then[:, 3:]) @ now[:, 3:, None]).max()
    return float(max(shift, turn))


def branch_directions(system: System, pose: Pose, motions: Array, trials: Array) -> Array:
    """Return directions (t, 6n) of (δr / length, δθ) along which accelerations exist; t < T where some trials find
    none.

    They are near `trials` (T, f), combinations of the `motions` (f, 6n) that C_q allows. `system` has no
    driving motions."""
    if not len(motions):
        return motions
    if len(motions) > THRESHOLDS.many_directions:
        return trials @ motions
    forms, none = _forms(system, pose, motions), floor_at(system, pose)
    roots = [root for trial in trials if (root := _root(forms, trial, none)) is not None]
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


def _root(forms: Array, trial: Array, none: float) -> Array | None:
    """Return a unit vector near `trial` at which all forms vanish, to `none`, by Gauss-Newton; None where it finds
    none."""
    z = trial / np.linalg.norm(trial)
    for _ in range(THRESHOLDS.most_passes):
        slope = forms @ z
        values = slope @ z
        if np.abs(values).max(initial=0.0) < THRESHOLDS.rounding * none / THRESHOLDS.dependent:
            break
        # only changes across z count: the forms are homogeneous, and a shorter z is no root
        across = slope - np.outer(values, z)
        z = z - np.linalg.lstsq(2.0 * across, values, rcond=none)[0]
        z = z / np.linalg.norm(z)
    return z if np.abs(forms @ z @ z).max(initial=0.0) < none else None
