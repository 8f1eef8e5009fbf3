"""Gauss-Newton on poses: geometrically shortest steps, damped where they do not reduce the residual."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array, Numbers, numbers
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.constraints import tangent_entries
from mbproj.equations.kinematics import Pose, pose_of
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System

if TYPE_CHECKING:
    from mbproj.equations.blocks import Rows


def gauss_newton(
    system: System, q: Array, residual: Callable[[Pose], Array], rows: Callable[[Pose], Rows], close_enough: float
) -> tuple[Array, Array]:
    """Return the coordinates reached from q, and the `residual` that is left there.

    `rows` are the derivatives of the residual by (δr / length, δθ). The iteration ends at `close_enough`, or at
    round-off. Where the shortest step does not reduce the residual, Levenberg's damping shortens it. It also ends at a
    pose at which a row has no derivative, as where a part of a rope vanishes."""
    with np.errstate(all="ignore"):
        return _gauss_newton(system, q, residual, rows, close_enough)


def _gauss_newton(
    system: System, q: Array, residual: Callable[[Pose], Array], rows: Callable[[Pose], Rows], close_enough: float
) -> tuple[Array, Array]:
    pose = pose_of(q)
    left, damping = residual(pose), 0.0
    for _ in range(THRESHOLDS.most_passes):
        open_by = np.abs(left).max(initial=0.0)
        if not close_enough < open_by < np.inf or damping > 1e6:  # where no pose closes, the residual may be NaN
            break
        derivatives = rows(pose)
        if not np.isfinite(derivatives.value).all():
            break
        trial = moved(system, q, shortest(derivatives, -left, damping))
        trial_pose = pose_of(trial)
        trial_left = residual(trial_pose)
        if np.linalg.norm(trial_left) < np.linalg.norm(left):
            q, pose, left, damping = trial, trial_pose, trial_left, damping / 10.0 if damping > 1e-9 else 0.0
        elif open_by <= THRESHOLDS.closed_to:
            break
        else:
            damping = max(10.0 * damping, 1e-6)
    return q, left


def set_rows(system: System, bound: PrimitiveSet, pose: Pose) -> Rows:
    """Return the derivatives (m, 6n) of a set's values by (δr / length, δθ in body axes) of each body."""
    body, entries = tangent_entries(bound, pose)
    values = entries[:, :6] * numbers([system.length] * 3 + [1.0] * 3)
    from mbproj.equations.blocks import Rows

    return Rows.of(bound.size, system.bodies, bound.entry_row, body, values)


def moved(system: System, q: Array, motion: Array) -> Array:
    """Return q (7n,) after a motion (6n,) of (δr / length, δθ in body axes), to first order."""
    bodies = (q + in_coordinates(system, q, motion)).reshape(-1, 7)
    bodies[:, 3:] /= np.linalg.norm(bodies[:, 3:], axis=1, keepdims=True)
    return bodies.ravel()


def in_coordinates(system: System, q: Array, motion: Array) -> Array:
    """Return the change of q (7n,), to first order, by a motion (6n,) of (δr / length, δθ in body axes)."""
    δ = motion.reshape(-1, 6)
    turn = 0.5 * (np.swapaxes(matrix_L(q.reshape(-1, 7)[:, 3:]), -1, -2) @ δ[:, 3:, None])[..., 0]
    return np.concatenate([system.length * δ[:, :3], turn], axis=1).ravel()


def shortest(rows: Rows, wanted: Array, damping: float = 0.0, least: float = THRESHOLDS.rounding) -> Array:
    """Return the x (6n,) that minimises |rows x - wanted|² + damping |x|²; without damping, the shortest such x. For
    `wanted` (m, k) the result is (6n, k). For few bodies a singular value below the part `least` of the largest counts
    as 0."""
    if rows.bodies <= THRESHOLDS.large:
        R = rows.dense()
        if damping == 0.0:
            correction: Numbers = np.linalg.lstsq(R, wanted, rcond=least)[0]
            return correction
        return R.T @ np.linalg.solve(R @ R.T + damping * np.eye(len(R)), wanted)
    return _shortest_by_sparse_factor(rows, wanted, damping)


def shortest_of(rows: Rows) -> Callable[[Array], Array]:
    """Return `shortest` without damping as a function of `wanted` (m,): the rows are decomposed once."""
    if rows.bodies > THRESHOLDS.large:
        return lambda wanted: shortest(rows, wanted)
    inverse = np.linalg.pinv(rows.dense(), rcond=1e-12)
    return lambda wanted: inverse @ wanted


def _shortest_by_sparse_factor(rows: Rows, wanted: Array, damping: float) -> Array:
    """Return the result of `shortest` by a factor of RᵀR. Where that is singular it is shifted, and iterative
    refinement removes the effect of the shift."""
    from scipy.sparse import identity
    from scipy.sparse.linalg import splu

    R = rows.sparse()
    square = R.T @ R
    shift = damping or THRESHOLDS.proximal * (float(square.diagonal().max()) or 1.0)
    shifted = (square + shift * identity(R.shape[1])).tocsc()
    factor = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    x = np.asarray(factor.solve(R.T @ wanted), dtype=float)
    before = np.inf
    for _ in range(THRESHOLDS.most_passes if damping == 0.0 else 0):
        change = factor.solve(R.T @ (wanted - R @ x))
        size = float(np.abs(change).max(initial=0.0))
        if not size < 0.5 * before or size <= THRESHOLDS.no_digits * np.abs(x).max(initial=0.0):
            break
        x, before = x + change, size
    return x
