"""The equations of motion with Euler parameters, Eqs. 10-14, and without multipliers, Eqs. 80-81."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.dynamics.equations.reflected import added_force, added_mass, tangent_gradients
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: (M, C_q, Q, γ) -> (q'', λ)
Solver = Callable[[Array, Array, Array, Array], tuple[Array, Array]]
TINY = float(np.finfo(float).tiny)


def mass_matrix(system: System, pose: Pose) -> Array:
    """Return M of Eqs. 11-12, (7n, 7n), singular: each body's block is diag(m I, 4 LᵀJL), of rank 6. Reflected inertias
    are added; they couple bodies."""
    n = system.bodies
    M = np.zeros((n, 7, n, 7), dtype=pose.L.dtype)
    index = np.arange(n)
    M[index[:, None], np.arange(3), index[:, None], np.arange(3)] = system.mass[:, None]
    L = pose.L[:-1]
    M[index, 3:, index, 3:] = 4.0 * np.swapaxes(L, -1, -2) @ system.inertia @ L
    blocks = M.reshape(7 * n, 7 * n)
    return blocks + added_mass(system.reflected, pose) if system.reflected.size else blocks


def tangent_mass_matrix(system: System, pose: Pose) -> Array:
    """Return diag(m I, J) in (δr, δθ in body axes) of each body with reflected inertias, (6n, 6n)."""
    n = system.bodies
    M, index = np.zeros((n, 6, n, 6)), np.arange(n)
    M[index, :3, index, :3] = system.mass[:, None, None] * np.eye(3)
    M[index, 3:, index, 3:] = system.inertia
    g = tangent_gradients(system.reflected, pose)[:, :-1]
    M += np.einsum("k,kbi,kcj->bicj", system.reflected.inertia, g, g)
    return M.reshape(6 * n, 6 * n)


def generalised_force(system: System, pose: Pose, twist: Twist) -> Numbers:
    """Return Q of Eq. 10, (..., 7n), or (7n,) with reflected inertias: gravity, gyroscopic terms, and terms of the
    latter.

    The gyroscopic term -8 L'ᵀ J L Λ' follows from Lagrange's equations for T = 2 Λ'ᵀLᵀJLΛ' (Nikravesh 1988, sect.
    8.3)."""
    force = system.mass[:, None] * system.gravity
    momentum = system.inertia @ pose.L[..., :-1, :, :] @ twist.rate[..., :-1, :, None]
    gyroscopic = -8.0 * (np.swapaxes(matrix_L(twist.rate)[..., :-1, :, :], -1, -2) @ momentum)[..., 0]
    rows = np.concatenate([np.broadcast_to(force, (*gyroscopic.shape[:-1], 3)), gyroscopic], axis=-1)
    Q = rows.reshape(*rows.shape[:-2], -1)
    return Q + added_force(system.reflected, pose, twist) if system.reflected.size else Q


def solve_bordered(M: Array, C_q: Array, Q: Array, gamma: Array) -> tuple[Array, Array]:
    """Return q'' (7n,) and λ (m,) from the bordered system, Eq. 14. Raises LinAlgError where it is exactly singular."""
    return _refined(_by_bordered, M, C_q, Q, gamma)


def solve_eliminated(M: Array, C_q: Array, Q: Array, gamma: Array) -> tuple[Array, Array]:
    """Return q'' and λ through A1 = M + C_qᵀC_q (Eqs. 72, 80-81), without the bordered system."""
    return _refined(_by_elimination, M, C_q, Q, gamma)


def _by_bordered(M: Array, C_q: Array, Q: Array, gamma: Array) -> tuple[Array, Array]:
    size, rows = M.shape[0], C_q.shape[0]
    bordered = np.zeros((size + rows, size + rows))
    bordered[:size, :size] = M
    bordered[:size, size:] = C_q.T
    bordered[size:, :size] = C_q
    solution = np.linalg.solve(bordered, np.concatenate([Q, gamma]))
    return solution[:size], solution[size:]


def _by_elimination(M: Array, C_q: Array, Q: Array, gamma: Array) -> tuple[Array, Array]:
    A1 = M + C_q.T @ C_q
    columns = np.linalg.solve(A1, np.column_stack([C_q.T, Q]))
    X, free = columns[:, :-1], columns[:, -1]
    multipliers = np.linalg.solve(C_q @ X, C_q @ free - gamma)
    return free - X @ multipliers, multipliers + gamma


def _refined(solve: Solver, M: Array, C_q: Array, Q: Array, gamma: Array) -> tuple[Array, Array]:
    """Return a solution of Eq. 14 whose residual is round-off in every equation, not only in the largest.

    With masses 1e12 apart, a factorisation is accurate in the equations of the heavy bodies only: in those of the light
    ones it leaves a large residual (Skeel 1980; LAPACK's xGERFS). The best iterate is returned where refinement does
    not help."""
    acceleration, multipliers = solve(M, C_q, Q, gamma)
    left, defect = _residual(M, C_q, Q, gamma, acceleration, multipliers)
    for _ in range(THRESHOLDS.most_passes):
        if not left > THRESHOLDS.no_digits:
            break
        more = solve(M, C_q, *defect)
        better = acceleration + more[0], multipliers + more[1]
        before, (left, defect) = left, _residual(M, C_q, Q, gamma, *better)
        if not left < before:
            break
        acceleration, multipliers = better
    return acceleration, multipliers


def _residual(
    M: Array, C_q: Array, Q: Array, gamma: Array, acceleration: Array, multipliers: Array
) -> tuple[float, tuple[Array, Array]]:
    """Return the componentwise backward error of a solution of Eq. 14 (Oettli and Prager 1964), and the residuals of
    both right-hand sides."""
    defect = Q - M @ acceleration - C_q.T @ multipliers, gamma - C_q @ acceleration
    size = np.abs(acceleration), np.abs(multipliers)
    terms = np.abs(M) @ size[0] + np.abs(C_q.T) @ size[1] + np.abs(Q), np.abs(C_q) @ size[0] + np.abs(gamma)
    left = max(float((np.abs(d) / np.maximum(t, TINY)).max(initial=0.0)) for d, t in zip(defect, terms, strict=True))
    return left, defect


SOLVERS: Mapping[str, Solver] = MappingProxyType({"bordered": solve_bordered, "eliminated": solve_eliminated})
