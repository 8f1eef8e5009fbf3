"""The slowest modes of large mechanisms, by shift-invert Arnoldi on the bordered matrices (Bai et al. 2000).

The bordered pencil has the eigenvalues of the tangent space, and infinite ones, which an inverse iteration does not
reach: (K + σD + σ²M) ξ + Gᵀμ = b, G ξ = 0 is factored once. The shift σ is real, and not 0, because neutral directions
are.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.derivatives.linear_equations import LinearEquations, linear_equations
from mbproj.linear.bordered import Bordered, diagonal
from mbproj.linear.independent_rows import independent_rows
from mbproj.linear.reduction.frames import in_axes
from mbproj.linear.reference import LinearReference
from mbproj.thresholds import THRESHOLDS

#: The seed of the start of Arnoldi's iteration.
SEED = 22


@dataclass(frozen=True, eq=False)
class SparseEigen:
    """Eigenvalues (k,) in 1/s, virtual displacements (6n, k) in global axes, and the degrees of freedom."""

    values: Numbers
    vectors: Numbers
    freedom: int


def sparse_eigen(reference: LinearReference, count: int) -> SparseEigen:
    """Return the `count` slowest modes of a mechanism at rest whose elements have no states."""
    system, motion = reference.system, reference.motion
    equations = in_axes(linear_equations(system, motion, reference.multipliers), motion, reference.turning)
    pencil = _Pencil(reference, equations, independent_rows(system, motion.pose, equations.rows.G))
    count = min(count, pencil.freedom)
    values, vectors = pencil.symmetric(count) if pencil.is_symmetric() else pencil.general(count)
    order = np.argsort(np.abs(values), kind="stable")
    return SparseEigen(values[order], vectors[:, order], pencil.freedom)


class _Pencil:
    """K, D, M and G of one mechanism, for one search of its modes."""

    def __init__(self, reference: LinearReference, equations: LinearEquations, rows: Integers) -> None:
        self.system, self.G, self.rows = reference.system, equations.rows.G, rows
        self.M, self.D, self.K = (part.sparse() for part in (equations.M, equations.D, equations.K))
        self.freedom = self.M.shape[0] - len(rows)
        self.start = np.random.default_rng(SEED).normal(size=self.M.shape[0])

    def is_symmetric(self) -> bool:
        """Return whether there is no damping, and K is symmetric on the tangent space up to round-off. In free turns of
        a body K is not symmetric, because of torques that constraints balance."""
        if self.D.nnz and np.abs(self.D.data).max() > 0.0:
            return False
        bordered = self.factor(self.shift())
        x, y = (bordered.solve(self.M @ part)[0] for part in (self.start, self.start[::-1].copy()))
        forth, back = float(x @ (self.K @ y)), float(y @ (self.K @ x))
        size = float(np.abs(x) @ (np.abs(self.K) @ np.abs(y)))
        return abs(forth - back) <= 1e3 * THRESHOLDS.rounding * size

    def factor(self, σ: float) -> Bordered:
        """Return the factor of K + σD + σ²M."""
        return Bordered(self.system, self.K + σ * self.D + σ**2 * self.M, self.G, self.rows)

    def shift(self) -> float:
        """Return a shift of about the slowest mode, by inverse iteration from a very small shift."""
        fastest = np.sqrt(np.abs(diagonal(self.K)).max(initial=0.0) / max(diagonal(self.M).max(), 1e-300))
        σ = max(THRESHOLDS.no_motion * float(fastest), THRESHOLDS.half_digits)
        bordered, x = self.factor(σ), self.start
        for _ in range(3):
            x = bordered.solve(self.M @ x)[0]
            x = x / np.linalg.norm(x)
        return max(σ, float(np.sqrt(abs(x @ (self.K @ x)) / (x @ (self.M @ x)))))

    def symmetric(self, count: int) -> tuple[Numbers, Numbers]:
        """Return λ from κ = -λ² of K ξ = κ M ξ by Lanczos, with Rayleigh's quotients of the vectors as values."""
        from scipy.sparse.linalg import LinearOperator, eigsh

        σ = self.shift()
        bordered = self.factor(σ)
        inverse = LinearOperator(self.M.shape, matvec=lambda b: bordered.solve(np.ravel(b))[0], dtype=float)
        start = bordered.solve(self.M @ self.start)[0]
        count = min(count, self.M.shape[0] - 1)
        wide = min(self.M.shape[0], max(2 * count + 10, 30))
        vectors = eigsh(self.K, count, M=self.M, sigma=-(σ**2), OPinv=inverse, v0=start, ncv=wide)[1]
        strain = np.einsum("ik,ik->k", vectors, self.K @ vectors)
        κ = strain / np.einsum("ik,ik->k", vectors, self.M @ vectors)
        size = np.einsum("ik,ik->k", np.abs(vectors), np.abs(self.K) @ np.abs(vectors))
        κ = np.where(np.abs(strain) <= THRESHOLDS.rounding * size, 0.0, κ)
        grows = κ < 0.0
        values = np.concatenate([np.where(grows, -1.0, 1j) * np.sqrt(np.abs(κ)), np.sqrt(-κ[grows])])
        return values.astype(complex), np.concatenate([vectors, vectors[:, grows]], axis=1).astype(complex)

    def general(self, count: int) -> tuple[Numbers, Numbers]:
        """Return λ by Arnoldi on (x, v) -> (x, v)' inverted at σ, without conjugates."""
        from scipy.sparse.linalg import LinearOperator, eigs

        σ, n = self.shift(), self.M.shape[0]
        bordered = self.factor(σ)

        def inverted(both: Array) -> Array:
            x, v = np.ravel(both)[:n], np.ravel(both)[n:]
            moved = bordered.solve(-(self.M @ (v + σ * x) + self.D @ x))[0]
            return np.concatenate([moved, x + σ * moved])

        operator = LinearOperator((2 * n, 2 * n), matvec=inverted, dtype=float)
        start = inverted(inverted(np.concatenate([self.start, self.start])))
        wanted = min(2 * count + 2, 2 * n - 2)
        μ, vectors = eigs(operator, wanted, v0=start, ncv=min(2 * n, max(2 * wanted + 10, 40)))
        values = σ + 1.0 / μ
        grain = np.sqrt(THRESHOLDS.rounding) * σ
        values = np.where(np.abs(values) <= grain, 0.0, values)
        kept = np.flatnonzero(values.imag >= -THRESHOLDS.rounding * np.abs(values))
        kept = kept[np.argsort(np.abs(values[kept]), kind="stable")][:count]
        return values[kept], vectors[:n, kept]
