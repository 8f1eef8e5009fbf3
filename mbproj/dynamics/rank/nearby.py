"""Poses that the joints can reach from one pose: what holds at them too holds along the motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import nearest
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.rank.branches import branch_directions
from mbproj.dynamics.rank.components import Component, component_rows
from mbproj.dynamics.rank.row_space import unit_rows
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.system import Conditions, System
from mbproj.thresholds import THRESHOLDS

#: Directions that are followed, of how many random ones, and their seed.
DIRECTIONS, TRIALS, SEED = 3, 12, 6
NO_CONDITIONS = Conditions(np.zeros(0, dtype=np.intp), np.zeros(0))


@dataclass(frozen=True, eq=False)
class Nearby:
    """Closed poses within some tenths of the start; `freedom` is the number of directions that the joints leave there
    to first order, without motions. Where there are such directions and no poses, they lead nowhere."""

    poses: tuple[Pose, ...]
    freedom: int


def nearby(system: System, q: Array) -> Nearby:
    """Poses that the joints reach from q (7n,); motions do not hold them, as they go on in time."""
    free = replace(system, motions=None)
    pose = pose_of(q)
    rows = _joint_rows(free, pose)
    _, values, vectors = np.linalg.svd(rows, full_matrices=True)
    motions = vectors[np.count_nonzero(values > THRESHOLDS.dependent) :]
    # Drawn among all motions: round-off decides which basis of those allowed the decomposition gives.
    trials = np.random.default_rng(SEED).normal(size=(TRIALS, rows.shape[1])) @ motions.T
    directions = branch_directions(free, pose, motions, trials)[:DIRECTIONS]
    return Nearby(tuple(found for direction in directions for found in _walk(free, q, direction)), len(motions))


def _walk(system: System, q: Array, direction: Array) -> Iterator[Pose]:
    """Poses along a direction (6n,), each some steps further, until one does not close."""
    reached = q
    for step in (THRESHOLDS.nearby_first, THRESHOLDS.nearby_second):
        motion = _allowed(_joint_rows(system, pose_of(reached)), direction)
        size = float(np.abs(motion).max())
        if size < THRESHOLDS.no_motion:
            return
        aim = moved(system, reached, motion * (step / size))
        closed, residual = nearest(system, aim, NO_CONDITIONS, None, THRESHOLDS.nearby_closed)
        if np.abs(residual).max(initial=0.0) > THRESHOLDS.assembled or _far(system, closed, reached) < 0.1 * step:
            return
        yield pose_of(closed)
        reached = closed


def moved(system: System, q: Array, motion: Array) -> Array:
    """q (7n,) after a motion (6n,) of (δr / length, δθ in body axes)."""
    bodies, δ = q.reshape(-1, 7).copy(), motion.reshape(-1, 6)
    turn = 0.5 * (np.swapaxes(matrix_L(bodies[:, 3:]), -1, -2) @ δ[:, 3:, None])[..., 0]
    bodies[:, :3] += system.length * δ[:, :3]
    bodies[:, 3:] += turn
    bodies[:, 3:] /= np.linalg.norm(bodies[:, 3:], axis=1, keepdims=True)
    return bodies.ravel()


def _allowed(rows: Array, direction: Array) -> Array:
    """The part of a direction that the rows do not resist, of unit length before."""
    direction = direction / np.linalg.norm(direction)
    for _ in range(2):
        direction = (
            direction - np.linalg.lstsq(rows, rows @ direction, rcond=THRESHOLDS.dependent)[0]
            if rows.size
            else direction
        )
    return direction


def _joint_rows(system: System, pose: Pose) -> Array:
    """All rows as one component of all bodies, of unit length, (k, 6n)."""
    everything = Component(np.arange(system.constraints - system.bodies), np.arange(system.bodies))
    return unit_rows(component_rows(system, pose, [everything])[0])


def _far(system: System, q: Array, start: Array) -> float:
    """How far the body that moved most did, in rad or parts of the length."""
    now, then = q.reshape(-1, 7), start.reshape(-1, 7)
    shift = np.abs(now[:, :3] - then[:, :3]).max() / system.length
    turn = 2.0 * np.abs(matrix_L(then[:, 3:]) @ now[:, 3:, None]).max()
    return float(max(shift, turn))
