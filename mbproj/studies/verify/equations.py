"""The equations of a mechanism at a state (M, C_q, Q and γ) and the paper's formulas for them, with bounds on
round-off.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import lu

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.equations.assembly.assemble import State
from mbproj.equations.constraints import constraint_at, constraint_velocity_at, gamma, jacobian
from mbproj.equations.forces import applied, generalised
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.motions import drive_at
from mbproj.equations.of_motion import generalised_force, mass_matrix
from mbproj.equations.rank.row_space import independent
from mbproj.model.system import System

# --- Numbers with a bound on their round-off, carried along through a formula -----------------------------------------
# A running error analysis.
# To first order in ε, componentwise (Higham, Accuracy and Stability of Numerical Algorithms, 2002: Eq. 3.13 for
# products, Theorem 9.4 for Gaussian elimination with partial pivoting). No constant is chosen: the bounds follow from
# the computation, with its condition and scale.


EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Rounded:
    """A computed vector or matrix, and a componentwise bound on its difference from the exact result."""

    value: Array
    error: Array

    @classmethod
    def exact(cls, value: Array) -> Rounded:
        """Take numbers as exact: their error is zero."""
        return cls(value, np.zeros_like(value))

    @property
    def T(self) -> Rounded:
        """The transpose."""
        return Rounded(self.value.T, self.error.T)

    def __neg__(self) -> Rounded:
        return Rounded(-self.value, self.error)

    def __add__(self, other: Rounded) -> Rounded:
        total: Array = self.value + other.value
        return Rounded(total, self.error + other.error + EPS * np.abs(total))

    def __sub__(self, other: Rounded) -> Rounded:
        return self + (-other)

    def __matmul__(self, other: Rounded) -> Rounded:
        left, right = np.abs(self.value), np.abs(other.value)
        inherited = self.error @ right + left @ other.error
        round_off: Array = self.value.shape[-1] * EPS * (left @ right)
        return Rounded(self.value @ other.value, inherited + round_off)

    def __getitem__(self, index: Any) -> Rounded:
        return Rounded(self.value[index], self.error[index])


def product(factor: float, x: Rounded) -> Rounded:
    """The product factor · x of a number and a vector or matrix."""
    value: Array = factor * x.value
    error: Array = abs(factor) * x.error + EPS * np.abs(value)
    return Rounded(value, error)


def solve(A: Rounded, b: Rounded) -> Rounded:
    """A⁻¹ b by Gaussian elimination: |δx| <= |A⁻¹| (|δA| |x| + |δb| + n ε |L| |U| |x|). Raises LinAlgError."""
    x = np.linalg.solve(A.value, b.value)
    P, L, U = lu(A.value)
    grown = P @ (np.abs(L) @ np.abs(U))
    residual = (A.error + len(A.value) * EPS * grown) @ np.abs(x) + b.error
    return Rounded(np.asarray(x), np.asarray(np.abs(np.linalg.inv(A.value)) @ residual))


def concatenated(*parts: Rounded) -> Rounded:
    """The vectors `parts`, one after another."""
    return Rounded(np.concatenate([part.value for part in parts]), np.concatenate([part.error for part in parts]))


def bordered(A: Rounded, C: Rounded) -> Rounded:
    """The block matrix [[A, Cᵀ], [C, 0]]."""
    none = np.zeros((len(C.value), len(C.value)))
    return Rounded(np.block([[A.value, C.value.T], [C.value, none]]), np.block([[A.error, C.error.T], [C.error, none]]))


# --- The equations of a mechanism at a state --------------------------------------------------------------------------


#: M, C_q, Q and γ are computed at this many neighbouring states too. Their spread is the round-off of the state.
NEIGHBOURS = 4
#: Operations behind one entry of M, C_q, Q or γ: products of three or four factors, summed over four Euler parameters.
OPERATIONS = 8.0


@dataclass(frozen=True, eq=False)
class RoundedEquations:
    """M (7n, 7n), C_q (m, 7n), Q (7n,) and γ (m,) of the independent rows; `rows` (m,) are the numbers of these rows in
    C."""

    M: Rounded
    C_q: Rounded
    Q: Rounded
    gamma: Rounded
    rows: Integers

    def taken_exactly(self) -> RoundedEquations:
        """Return these equations as if their terms had no round-off."""
        M, C_q, Q, right = (Rounded.exact(term.value) for term in (self.M, self.C_q, self.Q, self.gamma))
        return RoundedEquations(M, C_q, Q, right, self.rows)

    def accelerations(self) -> Rounded:
        """Solve Eq. 14: q'' followed by λ, (7n + m,)."""
        return solve(bordered(self.M, self.C_q), concatenated(self.Q, self.gamma))

    def eliminated(self) -> Rounded:
        """Solve Eqs. 80-81 with A1: q'' followed by λ, (7n + m,)."""
        A1 = penalised(self.M, self.C_q, 1.0)
        X, free = solve(A1, self.C_q.T), solve(A1, self.Q)
        multipliers = solve(self.C_q @ X, self.C_q @ free - self.gamma)
        return concatenated(free - X @ multipliers, multipliers + self.gamma)


def penalised(M: Rounded, C_q: Rounded, alpha: float) -> Rounded:
    """The matrix A_α = M + α C_qᵀC_q, Eqs. 53 and 72."""
    return M + product(alpha, C_q.T @ C_q)


def correction(A: Rounded, C_q: Rounded, violation: Rounded) -> Rounded:
    """The correction -A⁻¹C_qᵀ (C_q A⁻¹ C_qᵀ)⁻¹ violation, Eq. 28."""
    X = solve(A, C_q.T)
    return -(X @ solve(C_q @ X, violation))


def independent_rows(system: System, q: Array) -> Integers:
    """The numbers of the rows of C that do not depend on the rows before them. Rows at velocity level count as last."""
    return np.flatnonzero(independent(system, pose_of(q)))


def equations_at(system: System, state: State) -> RoundedEquations:
    """The equations of motion at a state. Raises SimulationError where a function of the scene has no value."""
    rows, random = independent_rows(system, state.q), np.random.default_rng(0)
    values = _terms(system, state, state.q, state.v)
    spread = [np.zeros_like(value) for value in values]
    for _ in range(NEIGHBOURS):
        near = _terms(system, state, *_neighbour(system, state, random))
        spread = [np.maximum(old, np.abs(new - value)) for old, new, value in zip(spread, near, values, strict=True)]
    fastest = np.abs(values[-1] / system.row_scale).max(initial=0.0)
    sizes = [*map(_by_kind, values[:-1]), fastest * system.row_scale]
    M, C_q, Q, right = (
        Rounded(value, error + OPERATIONS * EPS * size)
        for value, error, size in zip(values, spread, sizes, strict=True)
    )
    return RoundedEquations(M, C_q[rows], Q, right[rows], rows)


def _terms(system: System, state: State, q: Array, v: Array) -> tuple[Array, Array, Array, Array]:
    """M, C_q, Q and γ at the coordinates q and velocities v."""
    pose = pose_of(q)
    twist, drive = twist_of(pose, v), drive_at(system, state.t)
    loads = applied(state.changed(positions=q, velocities=v).instant(system))
    force = generalised_force(system, pose, twist) + generalised(pose, loads.force, loads.torque)
    return mass_matrix(system, pose), jacobian(system, pose), force, gamma(system, pose, twist, drive)


def _neighbour(system: System, state: State, random: np.random.Generator) -> tuple[Array, Array]:
    """Return q and v with a random error in each number. It is of the size of ε times the largest coordinate or speed.
    Where the state violates the constraints by more, it is of that size: redundant rows differ by as much."""
    q, v = state.q.reshape(-1, 7), state.v.reshape(-1, 7)
    violations = constraint_at(system, state.q, state.t), constraint_velocity_at(system, state.q, state.v, state.t)
    left, apart = (float(np.abs(violation / system.row_scale).max()) for violation in violations)
    size = EPS * np.array([max(system.length, np.abs(q[:, :3]).max()), 1.0])
    speed = EPS * np.array([np.abs(v[:, :3]).max(), np.abs(v[:, 3:]).max()])
    unit = np.array([system.length, 1.0])
    near = [
        np.repeat(np.maximum(scale, open_by * unit), (3, 4)) * random.uniform(-1.0, 1.0, q.shape)
        for scale, open_by in ((size, left), (speed, apart))
    ]
    return (q + near[0]).ravel(), (v + near[1]).ravel()


def _by_kind(rows: Array) -> Array:
    """For each entry, the largest absolute value in its row among the same body's entries of its kind (positions or
    Euler parameters), (..., 7n)."""
    parts = np.abs(rows.reshape(*rows.shape[:-1], -1, 7))
    size = np.empty_like(parts)
    for columns in (slice(3), slice(3, 7)):
        size[..., columns] = parts[..., columns].max(axis=-1, keepdims=True)
    return size.reshape(rows.shape)
