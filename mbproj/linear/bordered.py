"""Bordered matrices of large mechanisms, sparse: [A Gᵀ; G 0] by SuperLU, with independent rows of G or with all."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dynamics.blocks import Rows
from mbproj.dynamics.derivatives.tangent_space import tangent_lengths
from mbproj.errors import InputError, Problem
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


@final
class Bordered:
    """The factor of [A Gᵀ; G 0] of a sparse A (6n, 6n) and the `rows` of G that are independent."""

    def __init__(self, system: System, A: csr_matrix, G: Rows, rows: Integers) -> None:
        from scipy.sparse import bmat, diags
        from scipy.sparse.linalg import splu

        self.size, self.rows, self.constraints = A.shape[0], rows, G.count
        # Lengths in the mechanism's own, and A of the order of G, so that pivots compare.
        lengths = tangent_lengths(system)
        inner = diags(lengths) @ A @ diags(lengths)
        size = max(float(np.abs(inner.diagonal()).max(initial=0.0)), float(np.finfo(float).tiny))
        self._rows = 1.0 / system.row_scale[system.bodies :][rows]
        self._lengths, self._size = lengths, size
        scaled = diags(self._rows) @ G.sparse()[rows] @ diags(lengths)
        try:
            self._factor = splu(bmat([[inner / size, scaled.T], [scaled, None]], format="csc"))
        except RuntimeError as error:
            raise singular() from error

    def solve(self, force: Numbers, rows: Numbers | None = None) -> tuple[Numbers, Numbers]:
        """ξ (6n,) and μ (m,) of A ξ + Gᵀμ = force and Gξ = rows, 0 where none are given; μ is 0 in dependent rows."""
        right = np.zeros(self.size + len(self.rows), dtype=np.result_type(force, float))
        right[: self.size] = self._lengths * force / self._size
        if rows is not None:
            right[self.size :] = self._rows * rows[self.rows]
        if np.iscomplexobj(right):
            found = self._factor.solve(right.real.copy()) + 1j * self._factor.solve(right.imag.copy())
        else:
            found = self._factor.solve(right)
        multipliers = np.zeros(self.constraints, dtype=found.dtype)
        multipliers[self.rows] = self._size * self._rows * found[self.size :]
        return self._lengths * found[: self.size], multipliers


@final
class Proximal:
    """The factor of [A Gᵀ; G -ε] with all rows of G, dependent or not: the proximal method of multipliers takes ε out
    again, step by step (Rockafellar 1976)."""

    def __init__(self, system: System, A: csr_matrix, G: Rows) -> None:
        from scipy.sparse import bmat, identity
        from scipy.sparse.linalg import splu

        self.G = G
        self._scaled = _Scaled(system, A, G)
        inner, rows = self._scaled.A, self._scaled.G
        softness = THRESHOLDS.proximal * identity(rows.shape[0])
        try:
            self._factor = splu(bmat([[inner, rows.T], [rows, -softness]], format="csc"))
        except RuntimeError as error:
            raise singular() from error

    def solve(self, force: Array, rows: Array | None = None) -> tuple[Array, Array]:
        """ξ (6n,) and μ (m,) of A ξ + Gᵀμ = force and Gξ = rows, 0 where none are given; μ is the smallest."""
        scaled, n = self._scaled, len(force)
        x, μ = np.zeros(n), np.zeros(self.G.count)
        top = scaled.lengths * force / scaled.size
        bottom = np.zeros_like(μ) if rows is None else scaled.rows * rows
        before = np.inf
        for _ in range(THRESHOLDS.most_proximal):
            left = np.concatenate([top - scaled.A @ x - scaled.G.T @ μ, bottom - scaled.G @ x])
            change = self._factor.solve(left)
            size = float(np.abs(change).max(initial=0.0))
            if not size < 0.5 * before:
                break
            x, μ, before = x + change[:n], μ + change[n:], size
            if size <= np.finfo(float).eps * max(np.abs(x).max(initial=0.0), np.abs(μ).max(initial=0.0)):
                break
        return scaled.lengths * x, scaled.size * scaled.rows * μ


def is_definite(system: System, A: csr_matrix, G: Rows) -> bool:
    """Whether ξᵀA ξ > 0 for all ξ with G ξ = 0, of a symmetric A: whether all pivots of A + ρ GᵀG are positive, with ρ
    so large that only such ξ are left to say so (Finsler 1937)."""
    from scipy.sparse.linalg import splu

    scaled = _Scaled(system, A, G)
    stiff = (scaled.A + THRESHOLDS.penalty * scaled.G.T @ scaled.G).tocsc()
    try:
        factor = splu(stiff, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return False
    return bool(np.array_equal(factor.perm_r, factor.perm_c) and np.all(factor.U.diagonal() > 0.0))


@final
class _Scaled:
    """A and G with lengths in the mechanism's own, and A of the order of G, so that pivots compare."""

    def __init__(self, system: System, A: csr_matrix, G: Rows) -> None:
        from scipy.sparse import diags

        self.lengths = tangent_lengths(system)
        inner = diags(self.lengths) @ A @ diags(self.lengths)
        self.size = max(float(np.abs(inner.diagonal()).max(initial=0.0)), float(np.finfo(float).tiny))
        self.rows = 1.0 / system.row_scale[system.bodies :]
        self.A, self.G = (inner / self.size).tocsr(), (diags(self.rows) @ G.sparse() @ diags(self.lengths)).tocsr()


def diagonal(matrix: csr_matrix) -> Array:
    """The diagonal, as an array."""
    return np.asarray(matrix.diagonal(), dtype=float)


def singular() -> InputError:
    """What a factor of a large mechanism cannot be."""
    return InputError(
        Problem(
            "the equations of this mechanism are singular: some motion moves no mass and is held by nothing",
            hint="`mbproj check` names it",
        )
    )
