"""Eigenvalues λ of λ² M + λ D + K on the tangent space, dense: massless motions are condensed, neutral ones split off.

Without damping and gyroscopic terms the problem is symmetric, and LAPACK's symmetric solver keeps repeated modes apart;
Rayleigh's quotients then restore the digits of the slow modes beside the fast ones. Otherwise QZ solves the pencil of
the first order (Moler and Stewart 1973). A neutral direction, K z = 0, would be a double eigenvalue 0, which round-off
splits into ±√ε. So its position is eliminated, and its velocity is the unknown.
"""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS

#: The divisor that replaces 0.
TINY = 1e-150


@dataclass(frozen=True, eq=False)
class ReducedEquations:
    """M, D and K on the tangent space, (f, f).

    `D_size`, `K_size`: the sums of the terms' absolute values, by which remainders are compared with round-off.
    `weighs` (w, f): rows that vanish on motions without mass. `chains`: whether eigenvalues 0 may form other chains
    than a position and its speed, as with rolling."""

    M: Array
    D: Array
    K: Array
    D_size: Array
    K_size: Array
    weighs: Array
    chains: bool = False


@dataclass(frozen=True, eq=False)
class Eigen:
    """Eigenvalues (k,) in 1/s, one of each conjugate pair, and their vectors (f, k) on the tangent space. Those of
    neutral directions are 0, one for each direction."""

    values: Numbers
    vectors: Numbers

    def slowest(self, count: int | None) -> Eigen:
        """Return the first `count` eigenvalues, or all."""
        return Eigen(self.values[:count], self.vectors[:, :count])

    def slowest_and_growing(self, count: int) -> Eigen:
        """Return the first `count` eigenvalues, and all after them that grow: these decide whether a motion is
        stable."""
        growing = self.values.real > THRESHOLDS.no_motion * np.abs(self.values).max(initial=0.0)
        modes = np.flatnonzero(growing | (np.arange(len(self.values)) < count))
        return Eigen(self.values[modes], self.vectors[:, modes])


def eigen(reduced: ReducedEquations) -> Eigen:
    """Return all finite eigenvalues, the slowest first. Raises InputError where no force holds a motion without mass,
    or round-off hides the mass of one."""
    reduced, back = _condensed(reduced)
    if not len(reduced.M):
        return Eigen(np.zeros(0, dtype=complex), np.zeros((len(back), 0), dtype=complex))
    pairs = _symmetric(reduced) if is_symmetric(reduced) else _by_qz(reduced)
    order = np.argsort(np.abs(pairs.values), kind="stable")
    return Eigen(pairs.values[order], back @ pairs.vectors[:, order])


def shares_of_states(reduced: ReducedEquations, pairs: Eigen, count: int) -> Array:
    """Return the participation of each of the last `count` coordinates, which are first-order states, in each mode, (k,
    count).

    It is the part in uᴴ(2 λ M + D) v, with u the left vector (Pérez-Arriaga et al. 1982). Where that vanishes, as for
    drifting motions, it is the part in |v|²."""
    parts = np.zeros((len(pairs.values), len(reduced.M)))
    for mode, (value, v) in enumerate(zip(pairs.values, pairs.vectors.T, strict=True)):
        U, σ, _ = np.linalg.svd(value * (value * reduced.M + reduced.D) + reduced.K)
        none = U[:, σ <= max(float(σ[-1]), THRESHOLDS.rounding * float(σ[0]))]
        change = (2.0 * value * reduced.M + reduced.D) @ v
        left = none @ (none.conj().T @ change)
        drifts = np.linalg.norm(left) <= THRESHOLDS.rounding * np.abs(reduced.D).max() * np.linalg.norm(v)
        parts[mode] = np.abs(v) ** 2 if drifts else np.abs(left.conj() * change)
    return np.asarray((parts / np.maximum(parts.sum(axis=1, keepdims=True), TINY))[:, parts.shape[1] - count :])


def is_symmetric(reduced: ReducedEquations) -> bool:
    """Return whether there is neither damping nor gyroscopic force, and K is symmetric, up to round-off."""
    limit = THRESHOLDS.rounding
    still = np.all(np.abs(reduced.D) <= limit * reduced.D_size)
    return bool(still and np.abs(reduced.K - reduced.K.T).max() <= limit * max(reduced.K_size.max(), TINY))


def _condensed(reduced: ReducedEquations) -> tuple[ReducedEquations, Array]:
    """Return the equations without motions that have no mass and lose no energy, which follow the others by K. Return
    also the matrix by which all coordinates follow from the remaining ones."""
    U, light = heavy_and_light(reduced)
    rank = U.shape[1]
    if not light.size or is_damped(reduced, light):
        return reduced, np.eye(len(reduced.M))
    held = held_by(reduced, light)
    back = U - light @ np.linalg.solve(held, light.T @ reduced.K @ U)
    left = U.T - (U.T @ reduced.K @ light) @ np.linalg.solve(held, light.T)
    size = np.abs(left), np.abs(back)
    return (
        ReducedEquations(
            left @ reduced.M @ back,
            left @ reduced.D @ back,
            left @ reduced.K @ back,
            size[0] @ reduced.D_size @ size[1],
            size[0] @ reduced.K_size @ size[1],
            np.eye(rank),
            reduced.chains,
        ),
        back,
    )


def heavy_and_light(reduced: ReducedEquations) -> tuple[Array, Array]:
    """Return orthonormal coordinates of the motions that move mass, (f, h), and of those that move none, (f, l)."""
    _, σ, V = np.linalg.svd(np.linalg.qr(reduced.weighs, mode="r"), full_matrices=True)
    rank = int(np.count_nonzero(σ > THRESHOLDS.dependent))
    return V[:rank].T, V[rank:].T


def is_damped(reduced: ReducedEquations, light: Array) -> bool:
    """Return whether motions without mass lose energy, or exert forces in proportion to their rates."""
    limit = THRESHOLDS.rounding * max(float(reduced.D_size.max(initial=0.0)), TINY)
    sizes = (np.abs(part).max(initial=0.0) for part in (reduced.D @ light, light.T @ reduced.D))
    return bool(max(sizes) > limit)


def held_by(reduced: ReducedEquations, light: Array) -> Array:
    """Return the stiffness of motions without mass, (l, l). Raises InputError where it does not hold one of them."""
    held: Array = light.T @ reduced.K @ light
    sizes = np.abs(light).T @ reduced.K_size @ np.abs(light)
    if np.linalg.svd(held, compute_uv=False).min(initial=np.inf) <= THRESHOLDS.rounding * max(
        sizes.max(initial=0.0), TINY
    ):
        raise massless_and_free()
    return held


def massless_and_free() -> InputError:
    """Return the error of a motion without mass that no force holds: it has no frequency, and no equation of motion."""
    return InputError(
        Problem(
            "a motion moves no mass, and no force holds it: it has no frequency",
            hint="`mbproj check` names it; give it mass, a spring, or joints that hold it",
        )
    )


def _symmetric(reduced: ReducedEquations) -> Eigen:
    """Return λ with λ² = -κ of K x = κ M x: one of a pair of imaginary eigenvalues, or two real ones. Raises InputError
    where M is not definite in double precision."""
    from scipy.linalg import eigh

    M, K = 0.5 * (reduced.M + reduced.M.T), 0.5 * (reduced.K + reduced.K.T)
    try:
        _, vectors = eigh(K, M)
    except np.linalg.LinAlgError as error:
        said = "round-off of other bodies' inertia hides that of a motion, so that frequencies have no values"
        hint = "look for a location or a body that is very far from the others, or inertias that are far apart"
        raise InputError(Problem(said, hint=hint)) from error
    strain = np.einsum("ik,ij,jk->k", vectors, K, vectors, optimize=True)
    κ = strain / np.einsum("ik,ij,jk->k", vectors, M, vectors, optimize=True)
    size = np.einsum("ik,ij,jk->k", np.abs(vectors), reduced.K_size, np.abs(vectors), optimize=True)
    none = np.abs(strain) <= THRESHOLDS.rounding * size
    κ = np.where(none | (np.abs(κ) <= THRESHOLDS.no_digits * np.abs(κ).max()), 0.0, κ)
    grows = κ < 0.0
    values = np.concatenate([np.where(grows, -1.0, 1j) * np.sqrt(np.abs(κ)), np.sqrt(-κ[grows])])
    return Eigen(values.astype(complex), np.concatenate([vectors, vectors[:, grows]], axis=1).astype(complex))


def _by_qz(reduced: ReducedEquations) -> Eigen:
    """Return the eigenvalues by QZ. With x = Z a + Y y, Z the neutral directions, the unknowns are y, y' and a'.
    Conjugates are left out."""
    from scipy.linalg import eig

    M, D, K = reduced.M, reduced.D, reduced.K
    f = len(M)
    Z, Y, conserved = _neutral(reduced)
    z, y = Z.shape[1], Y.shape[1]
    mass = max(float(np.abs(M).max()), TINY)
    speed = max(float(np.sqrt(np.abs(K).max() / mass)), float(np.abs(D).max()) / mass, TINY)
    E, A = np.zeros((2 * f - z, 2 * f - z)), np.zeros((2 * f - z, 2 * f - z))
    E[:y, :y] = A[:y, y : 2 * y] = np.eye(y)
    E[y:, y:] = speed * np.concatenate([M @ Y, M @ Z], axis=1)
    A[y:, :y] = -K @ Y / speed
    A[y:, y:] = -np.concatenate([D @ Y, D @ Z], axis=1)
    (α, β), vectors = eig(A, E, homogeneous_eigvals=True)
    finite = np.abs(β) > THRESHOLDS.rounding * np.abs(α)
    values = speed * α[finite] / β[finite]
    vectors = vectors[:, finite]
    by_size = np.argsort(np.abs(values), kind="stable")
    if reduced.chains:
        values[by_size[: _chained(A, E)]] = 0.0
    modes = by_size[conserved:]
    modes = modes[values[modes].imag >= -THRESHOLDS.rounding * np.abs(values[modes])]
    values, vectors = values[modes], vectors[:, modes]
    grain = THRESHOLDS.rounding * np.abs(values) + THRESHOLDS.no_digits * np.abs(values).max(initial=0.0)
    values = np.where(np.abs(values.imag) <= grain, 0.0, 1j * values.imag) + np.where(
        np.abs(values.real) <= grain, 0.0, values.real
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        drift = np.where(values == 0.0, 0.0, speed * vectors[2 * y :] / values)
    moved = Y @ vectors[:y] + Z @ drift
    zeros = np.zeros(z, dtype=complex)
    return Eigen(np.concatenate([zeros, values]), np.concatenate([Z.astype(complex), moved], axis=1))


def _chained(A: Array, E: Array) -> int:
    """Return the multiplicity of the eigenvalue 0 of A x = λ E x, with chains A x₁ = 0, A x₂ = E x₁. Round-off splits
    chains into values of the order of its square root, by which they are recognised."""
    size = float(np.abs(A).max(initial=0.0))
    σ = np.linalg.svd(np.block([[A, np.zeros_like(A)], [-size * E, A]]), compute_uv=False)
    return len(σ) - int(np.count_nonzero(σ > len(σ) * np.finfo(float).eps * σ.max(initial=0.0)))


def _neutral(reduced: ReducedEquations) -> tuple[Array, Array, int]:
    """Return the directions Z with K Z = 0, those normal to them, and the number of conserved momenta along uᵀK = 0. No
    motion along Z changes these momenta: each has a second eigenvalue 0, a drift at constant speed."""
    U, σ, V = np.linalg.svd(reduced.K)
    sizes = np.einsum("ik,ij,kj->k", np.abs(U), reduced.K_size, np.abs(V), optimize=True)
    none = σ <= np.maximum(THRESHOLDS.rounding * sizes, THRESHOLDS.no_digits * σ[0])
    left, Z = U[:, none], V[none].T
    momenta = left.T @ reduced.D @ Z
    size = np.abs(left).T @ reduced.D_size @ np.abs(Z)
    σ = np.linalg.svd(momenta, compute_uv=False)
    limit = THRESHOLDS.rounding * max(float(size.max(initial=0.0)), TINY)
    conserved = left.shape[1] - int(np.count_nonzero(σ > limit))
    return Z, V[~none].T, conserved
