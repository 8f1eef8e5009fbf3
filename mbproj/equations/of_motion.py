"""The equations of motion with Euler parameters, Eqs. 10-14, and without multipliers, Eqs. 80-81."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from mbproj.base.arrays import Array, Numbers, total
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.constraints import set_bias, set_jacobian, set_velocity, tangent_jacobian
from mbproj.equations.kinematics import Pose, Twist
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.forces import ReflectedInertias
from mbproj.model.system import System

# --- The terms of reflected inertias ½ I s'² in the equations of motion -----------------------------------------------
# With s' = g v, Lagrange's equations of a coordinate s give I gᵀ s'', of which s'' = g a + g' v. So I gᵀg is added to
# M, and I gᵀ(g' v) is subtracted from Q.


@dataclass(frozen=True, eq=False)
class Reaction:
    """Rates s' and forces -I s'' along the coordinates of reflected inertias at samples, (..., k), in N or N m."""

    rate: Numbers
    force: Numbers


def added_mass(reflected: ReflectedInertias, pose: Pose) -> Array:
    """Return Σ I gᵀg, (7n, 7n)."""
    g = set_jacobian(reflected.rows, pose)
    return np.asarray(g.T @ (reflected.inertia[:, None] * g), dtype=float)


def added_force(reflected: ReflectedInertias, pose: Pose, twist: Twist) -> Array:
    """Return -Σ I gᵀ(g' v), (7n,)."""
    return -set_jacobian(reflected.rows, pose).T @ (reflected.inertia * set_bias(reflected.rows, pose, twist))


def with_flywheels(
    reflected: ReflectedInertias, pose: Pose, twist: Twist, M: Array, C_q: Array, Q: Array, gamma: Array
) -> tuple[Array, Array, Array, Array]:
    """Return the terms of Eq. 14 with each reflected inertia as a coordinate of its own, held by a row g v - s' = 0.

    The motion is the same. But a large inertia added to M would cost much lighter bodies digits."""
    rows, count = reflected.rows, len(reflected.inertia)
    n, m = len(M), len(C_q)
    whole, held = np.zeros((n + count, n + count)), np.zeros((m + count, n + count))
    whole[:n, :n], whole[n:, n:] = M, np.diag(reflected.inertia)
    held[:m, :n], held[m:, :n], held[m:, n:] = C_q, set_jacobian(rows, pose), -np.eye(count)
    bias = -set_bias(rows, pose, twist)
    return whole, held, np.concatenate([Q, np.zeros(count)]), np.concatenate([gamma, bias])


def added_energy(reflected: ReflectedInertias, pose: Pose, twist: Twist) -> Numbers:
    """Return ½ Σ I s'² in J, shape (...)."""
    return 0.5 * total(reflected.inertia * set_velocity(reflected.rows, pose, twist) ** 2)


def inertial_reaction(reflected: ReflectedInertias, pose: Pose, twist: Twist, change: Twist) -> Reaction:
    """Return the reaction of the inertias on their coordinates; `change` is a `Twist` that holds q'' in place of q'."""
    rows = reflected.rows
    acceleration = set_velocity(rows, pose, change) + set_bias(rows, pose, twist)
    return Reaction(set_velocity(rows, pose, twist), -reflected.inertia * acceleration)


def pull_on_bodies(reflected: ReflectedInertias, pose: Pose, reaction: Reaction) -> Array:
    """Return gᵀ times the forces -I s'' of one sample on each body, (n, 6): forces, and torques in body axes."""
    return np.einsum("k,kbi->bi", reaction.force, tangent_gradients(reflected, pose)[:, :-1])


def tangent_gradients(reflected: ReflectedInertias, pose: Pose) -> Array:
    """Return g in (δr, δθ in body axes) of each body and, last, of the ground, (k, n+1, 6)."""
    return tangent_jacobian(reflected.rows, pose)[..., :6]


# --- With Euler parameters, Eqs. 10-14, and without multipliers, Eqs. 80-81 -------------------------------------------


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


# --- Independent combinations of rows ---------------------------------------------------------------------------------
# Independent combinations of the rows of C_q, in which the equations of motion and of every projection are solved.


@dataclass(frozen=True, eq=False)
class HeldRows:
    """Independent rows `C_q` (r, 7n): combinations of all rows by `weights` (m, r), or all rows themselves for None.

    Near a singular pose some combinations are not held. `left_out` (m, k) are the weights of these combinations and
    `weak` (k, 7n) their rows of C_q. `unseen` (m, k): for each of them a violation that the held rows cannot detect.
    `nearness`: the distance from dependence divided by the largest one in the run; 1 where it was not measured.
    `shares` (m, r): the part of the multiplier of a held row that each row bears, where that differs from `weights`."""

    C_q: Array
    weights: Array | None = None
    left_out: Array | None = None
    unseen: Array | None = None
    weak: Array | None = None
    nearness: float = 1.0
    shares: Array | None = None

    def combined(self, rows: Array) -> Array:
        """Return γ, C or C' of the held rows, (r,), from those of all rows (m,)."""
        return rows if self.weights is None else self.weights.T @ rows

    def multipliers(self, held: Array) -> Array:
        """Return λ (m,) of all rows from the multipliers of the held rows, (r,): the smallest λ where rows are
        redundant."""
        shares = self.weights if self.shares is None else self.shares
        return held if shares is None else shares @ held

    def lasting(self, multipliers: Array) -> tuple[Array, Array]:
        """Return the part of the multipliers λ (m,) that belongs to combinations left out, and its force -C_qᵀλ,
        (7n,)."""
        if self.left_out is None or self.unseen is None or self.weak is None:
            return np.zeros_like(multipliers), np.zeros(self.C_q.shape[1])
        share = self.unseen.T @ multipliers
        return self.left_out @ share, -(self.weak.T @ share)

    def closes(self, rows: Array) -> Array:
        """Return the part of a violation (m,) that the held rows can close."""
        if self.left_out is None or self.unseen is None:
            return rows
        return rows - self.unseen @ (self.left_out.T @ rows)

    def open(self, rows: Array) -> float:
        """Return the largest violation of the combinations left out, in units of the mechanism's length."""
        return 0.0 if self.left_out is None else float(np.abs(self.left_out.T @ rows).max(initial=0.0))
