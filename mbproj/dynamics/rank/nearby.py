"""Poses that the joints can reach from one pose: a property that holds at these too holds along the motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import nearest, scaled_rows
from mbproj.dynamics.assembly.gauss_newton import moved, shortest
from mbproj.dynamics.blocks import Rows
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.equations.motions import NO_DRIVE
from mbproj.dynamics.rank.branches import branch_directions
from mbproj.dynamics.rank.components import Component, component_rows
from mbproj.dynamics.rank.row_space import unit_rows
from mbproj.model.channels import NO_MOTIONS
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.system import Conditions, System
from mbproj.thresholds import THRESHOLDS

#: The number of directions that are followed, the number of random trials for them, and their seed.
DIRECTIONS, TRIALS, SEED = 3, 12, 6
NO_CONDITIONS = Conditions(np.zeros(0, dtype=np.intp), np.zeros(0))


@dataclass(frozen=True, eq=False)
class Nearby:
    """Closed poses within some tenths of the start. `freedom`: the number of directions that the joints leave there to
    first order, without motions. Where there are such directions and no poses, the directions lead nowhere."""

    poses: tuple[Pose, ...]
    freedom: int


def nearby(system: System, q: Array) -> Nearby:
    """Return poses that the joints reach from q (7n,); motions do not hold them, as these go on in time."""
    free = replace(system, motions=NO_MOTIONS)
    pose = pose_of(q)
    motions = _motions(free, pose)
    # Drawn among all motions, because the basis of the allowed ones that the decomposition gives depends on round-off.
    trials = np.random.default_rng(SEED).normal(size=(TRIALS, 6 * system.bodies)) @ motions.T
    directions = branch_directions(free, pose, motions, trials)[:DIRECTIONS]
    return Nearby(tuple(found for direction in directions for found in _walk(free, q, direction)), len(motions))


def _motions(system: System, pose: Pose) -> Array:
    """Return an orthonormal basis (f, 6n) of the motions of (δr / length, δθ) that the joints allow. For many bodies it
    spans random motions without the part that rows resist. Their number is large enough that some are dependent."""
    if system.bodies <= THRESHOLDS.large:
        _, values, vectors = np.linalg.svd(_joint_rows(system, pose), full_matrices=True)
        return np.asarray(vectors[np.count_nonzero(values > THRESHOLDS.dependent) :], dtype=float)
    rows, count = scaled_rows(system, pose, NO_CONDITIONS), THRESHOLDS.many_directions
    while True:
        count = min(2 * count, 6 * system.bodies)
        drawn = np.random.default_rng(SEED).normal(size=(6 * system.bodies, count))
        _, values, vectors = np.linalg.svd(_allowed(rows, drawn).T, full_matrices=False)
        rank = int(np.count_nonzero(values > THRESHOLDS.no_motion))
        if rank < count or count == 6 * system.bodies:
            return np.asarray(vectors[:rank], dtype=float)


def _walk(system: System, q: Array, direction: Array) -> Iterator[Pose]:
    """The poses along a direction (6n,), each some steps further, until one does not close."""
    reached = q
    for step in (THRESHOLDS.short_way, 5.0 * THRESHOLDS.short_way):
        motion = _allowed(scaled_rows(system, pose_of(reached), NO_CONDITIONS), direction)
        size = float(np.abs(motion).max())
        if size < THRESHOLDS.no_motion:
            return
        aim = moved(system, reached, motion * (step / size))
        closed, residual = nearest(system.at_positions, aim, NO_CONDITIONS, NO_DRIVE, THRESHOLDS.closed_to)
        if np.abs(residual).max(initial=0.0) > THRESHOLDS.assembled or _far(system, closed, reached) < 0.1 * step:
            return
        yield pose_of(closed)
        reached = closed


def _allowed(rows: Rows, direction: Array) -> Array:
    """Return the part of a direction (6n,), or of several (6n, k), that the rows do not resist; the directions are
    first scaled to unit length."""
    direction = direction / np.linalg.norm(direction, axis=0)
    for _ in range(2):
        direction = direction - shortest(rows, rows.times(direction))
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
