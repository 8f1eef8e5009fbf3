"""Gauss-Newton on poses: the steps that are geometrically shortest, damped where they lead nowhere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def gauss_newton(
    system: System, q: Array, residual: Callable[[Array], Array], rows: Callable[[Array], Array], close_enough: float
) -> tuple[Array, Array]:
    """The pose reached from q, and the `residual` that is left there; `rows` are its derivatives by q, and it ends at
    `close_enough`. Where the shortest weighted step does not reduce the residual, Levenberg's damping."""
    weights = inverse_weights(system)
    left, damping = residual(q), 0.0
    for _ in range(THRESHOLDS.most_assembling):
        if np.abs(left).max(initial=0.0) <= close_enough or damping > 1e6:
            break
        trial = _normalised(q + weights * _damped_solution(rows(q) * weights, -left, damping))
        trial_left = residual(trial)
        if np.linalg.norm(trial_left) < np.linalg.norm(left):
            q, left, damping = trial, trial_left, damping / 10.0 if damping > 1e-9 else 0.0
        else:
            damping = max(10.0 * damping, 1e-6)
    return q, left


def inverse_weights(system: System) -> Array:
    """Lengths in units of the system's length, and |Δθ| = 2 |ΔΛ|, (7n,)."""
    return np.tile([system.length] * 3 + [0.5] * 4, system.bodies)


def keeping_norms(rows: Array, pose: Pose) -> Array:
    """Derivatives by q (m, 7n), made in place those of turns that keep |Λ|: Λ is normalised after each step."""
    Λ = pose.orientation[:-1]
    of_bodies = rows.reshape(len(rows), len(Λ), 7)
    of_bodies[..., 3:] -= np.sum(of_bodies[..., 3:] * Λ, axis=-1, keepdims=True) * Λ
    return rows


def _damped_solution(rows: Array, wanted: Array, damping: float) -> Array:
    """x that minimises |rows x - wanted|² + damping |x|²; the shortest one without damping."""
    if damping == 0.0:
        return np.asarray(np.linalg.lstsq(rows, wanted, rcond=1e-12)[0], dtype=float)
    return rows.T @ np.linalg.solve(rows @ rows.T + damping * np.eye(len(rows)), wanted)


def _normalised(q: Array) -> Array:
    rows = q.reshape(-1, 7).copy()
    rows[:, 3:] /= np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    return rows.ravel()
