"""The equations of motion with Euler parameters, Eqs. 10-14, and without multipliers, Eqs. 80-81."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dynamics.kinematics import Pose, Twist
from mbproj.model.system import System

#: (M, C_q, Q, γ) -> (q'', λ)
Solver = Callable[[Array, Array, Array, Array], tuple[Array, Array]]


def mass_matrix(system: System, pose: Pose) -> Array:
    """M of Eqs. 11-12, (7n, 7n), singular: each body's block is diag(m I, 4 LᵀJL), of rank 6."""
    n = system.bodies
    M = np.zeros((n, 7, n, 7), dtype=pose.L.dtype)
    index = np.arange(n)
    M[index[:, None], np.arange(3), index[:, None], np.arange(3)] = system.mass[:, None]
    L = pose.L[:-1]
    M[index, 3:, index, 3:] = 4.0 * np.swapaxes(L, -1, -2) @ system.inertia @ L
    return M.reshape(7 * n, 7 * n)


def generalised_force(system: System, pose: Pose, twist: Twist) -> Numbers:
    """Q of Eq. 10, (..., 7n): gravity, and the gyroscopic term -8 L'ᵀ J L Λ' that Lagrange's equations give for
    T = 2 Λ'ᵀLᵀJLΛ' (Nikravesh 1988, sect. 8.3)."""
    force = system.mass[:, None] * system.gravity
    momentum = system.inertia @ pose.L[..., :-1, :, :] @ twist.rate[..., :-1, :, None]
    gyroscopic = -8.0 * (np.swapaxes(twist.L_dot[..., :-1, :, :], -1, -2) @ momentum)[..., 0]
    rows = np.concatenate([np.broadcast_to(force, (*gyroscopic.shape[:-1], 3)), gyroscopic], axis=-1)
    return rows.reshape(*rows.shape[:-2], -1)


def solve_bordered(M: Array, C_q: Array, Q: Array, gamma: Array) -> tuple[Array, Array]:
    """Eq. 14: q'' (7n,) and λ (m,) from the bordered system. Raises LinAlgError where it is exactly singular."""
    size, rows = M.shape[0], C_q.shape[0]
    bordered = np.zeros((size + rows, size + rows))
    bordered[:size, :size] = M
    bordered[:size, size:] = C_q.T
    bordered[size:, :size] = C_q
    solution = np.linalg.solve(bordered, np.concatenate([Q, gamma]))
    return solution[:size], solution[size:]


def solve_eliminated(M: Array, C_q: Array, Q: Array, gamma: Array) -> tuple[Array, Array]:
    """Eqs. 80-81: q'' and λ through A1 = M + C_qᵀC_q (Eq. 72), without the bordered system."""
    A1 = M + C_q.T @ C_q
    columns = np.linalg.solve(A1, np.column_stack([C_q.T, Q]))
    X, free = columns[:, :-1], columns[:, -1]
    multipliers = np.linalg.solve(C_q @ X, C_q @ free - gamma)
    return free - X @ multipliers, multipliers + gamma


SOLVERS: Mapping[str, Solver] = MappingProxyType({"bordered": solve_bordered, "eliminated": solve_eliminated})
