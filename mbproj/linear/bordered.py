"""Sparse bordered matrices [A Gᵀ; G 0] of large mechanisms, by SuperLU, with independent rows of G or with all. The
tangent spaces of large mechanisms follow from them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.blocks import Rows
from mbproj.equations.kinematics import Pose
from mbproj.equations.rank.components import loops_of
from mbproj.equations.rank.row_space import independent, row_distances
from mbproj.equations.tangent_space import TangentSpace, tangent_lengths, tangent_space
from mbproj.model.system import System

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix
    from scipy.sparse.linalg import LinearOperator


# --- Independent rows of large mechanisms -----------------------------------------------------------------------------
# Loop by loop, with sparse factors for long loops.


#: The seed of the random vectors, and their number.
PROBE_SEED, PROBES = 40, 8


def independent_rows(system: System, pose: Pose, G: Rows) -> Integers:
    """Return the numbers of rows of the joints and motions, G (m, 6n), that do not follow from others."""
    free = independent(system, pose)[system.bodies :]
    for loop in loops_of(system):
        if len(loop.bodies) > THRESHOLDS.large:
            free[loop.rows] = _independent(_unit_rows(system, G)[loop.rows])
    return np.flatnonzero(free)


def _unit_rows(system: System, G: Rows) -> csr_matrix:
    from scipy.sparse import diags

    rows = (G.sparse() @ diags(tangent_lengths(system))).tocsr()
    size = np.sqrt(np.asarray(rows.multiply(rows).sum(axis=1))).ravel()
    return diags(1.0 / np.where(size > 0.0, size, 1.0)) @ rows


def _independent(rows: csr_matrix) -> Array:
    """Return whether each row is far from the span of others.

    The pivots of the rows' products with each other are the squares of their distances, with half of the digits. The
    few rows that these leave in doubt are compared with the others."""
    from scipy.sparse import identity
    from scipy.sparse.linalg import splu

    count, grain = rows.shape[0], float(np.finfo(float).eps)
    products = (rows @ rows.T + grain * identity(count)).tocsc()
    factor = splu(products, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    free = np.asarray(factor.U.diagonal()[factor.perm_c] > THRESHOLDS.rounded**2)
    if not free.all():
        free[~free] = _are_independent(rows[np.flatnonzero(free)], rows[np.flatnonzero(~free)])
    return free


def _are_independent(clear: csr_matrix, doubtful: csr_matrix) -> Array:
    """Return whether each doubtful row is far from the span of the clear rows and of those before it.

    Random vectors, less their parts along the clear rows, have products with every row that has a part beyond these.
    Only such rows are examined."""
    from scipy.sparse import bmat, identity
    from scipy.sparse.linalg import splu

    width = clear.shape[1]
    factor = splu(bmat([[identity(width), clear.T], [clear, None]], format="csc"))

    def remainder(columns: Array) -> Array:
        for _ in range(2):  # twice is enough (Kahan)
            right = np.concatenate([columns, np.zeros((clear.shape[0], columns.shape[1]))])
            columns = factor.solve(right)[:width]
        return columns

    probes = remainder(np.random.default_rng(PROBE_SEED).normal(size=(width, PROBES)))
    met = np.linalg.norm(doubtful @ probes, axis=1) > THRESHOLDS.dependent
    free = np.zeros(doubtful.shape[0], dtype=bool)
    if met.any():
        free[met] = row_distances(remainder(doubtful[np.flatnonzero(met)].toarray().T).T) > THRESHOLDS.dependent
    return free


# --- Sparse bordered matrices [A Gᵀ -----------------------------------------------------------------------------------


#: The seed of the random vectors that span a tangent space.
SEED = 41


@final
class Bordered:
    """The factor of [A Gᵀ; G 0] of a sparse A (6n, 6n) and the `rows` of G that are independent."""

    def __init__(self, system: System, A: csr_matrix, G: Rows, rows: Integers) -> None:
        from scipy.sparse import bmat, diags
        from scipy.sparse.linalg import splu

        self.size, self.rows, self.constraints = A.shape[0], rows, G.count
        # Lengths are in units of the mechanism's length, and A is scaled to the order of G, so that pivots are
        # comparable.
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
        """Return ξ (6n,) and μ (m,) of A ξ + Gᵀμ = force and Gξ = rows, 0 for None; μ is 0 in dependent rows. With
        several columns they are (6n, k) and (m, k)."""
        right = np.zeros((self.size + len(self.rows), *force.shape[1:]), dtype=np.result_type(force, float))
        right[: self.size] = (self._lengths * force.T).T / self._size
        if rows is not None:
            right[self.size :] = (self._rows * rows[self.rows].T).T
        if np.iscomplexobj(right):
            solution = self._factor.solve(right.real.copy()) + 1j * self._factor.solve(right.imag.copy())
        else:
            solution = self._factor.solve(right)
        multipliers = np.zeros((self.constraints, *force.shape[1:]), dtype=solution.dtype)
        multipliers[self.rows] = self._size * (self._rows * solution[self.size :].T).T
        return (self._lengths * solution[: self.size].T).T, multipliers


@final
class Proximal:
    """The factor of [A Gᵀ; G -ε] with all rows of G, dependent or not. The proximal method of multipliers removes ε
    step by step (Rockafellar 1976). Rows are in units of the mechanism, or of `sizes` (m,)."""

    def __init__(self, system: System, A: csr_matrix, G: Rows, sizes: Array | None = None) -> None:
        from scipy.sparse import bmat, identity
        from scipy.sparse.linalg import splu

        self.G, self.constraints = G, G.count
        self._scaled = _Scaled(system, A, G, sizes)
        inner, rows = self._scaled.A, self._scaled.G
        softness = THRESHOLDS.proximal * identity(rows.shape[0])
        try:
            self._factor = splu(bmat([[inner, rows.T], [rows, -softness]], format="csc"))
        except RuntimeError as error:
            raise singular() from error

    def solve(self, force: Array, rows: Array | None = None) -> tuple[Array, Array]:
        """Return ξ (6n,) and the smallest μ (m,) of A ξ + Gᵀμ = force and Gξ = rows, 0 for None. With several columns
        they are (6n, k) and (m, k)."""
        scaled, n = self._scaled, len(force)
        x, μ = np.zeros(force.shape), np.zeros((self.G.count, *force.shape[1:]))
        top = (scaled.lengths * force.T).T / scaled.size
        bottom = np.zeros_like(μ) if rows is None else (scaled.rows * rows.T).T
        before = np.full(force.shape[1:], np.inf)
        for _ in range(THRESHOLDS.most_passes):
            left = np.concatenate([top - scaled.A @ x - scaled.G.T @ μ, bottom - scaled.G @ x])
            change = self._factor.solve(left)
            size = np.abs(change).max(axis=0, initial=0.0)
            better = size < 0.5 * before
            change, before = np.where(better, change, 0.0), np.where(better, size, 0.0)
            x, μ = x + change[:n], μ + change[n:]
            largest = np.maximum(np.abs(x).max(axis=0, initial=0.0), np.abs(μ).max(axis=0, initial=0.0))
            if np.all(before <= np.finfo(float).eps * largest):
                break
        return (scaled.lengths * x.T).T, (scaled.size * scaled.rows * μ.T).T


def tangent_space_of(
    system: System, pose: Pose, G: Rows, scale: Array | None = None, lengths: Array | None = None
) -> TangentSpace:
    """Return the tangent space at a pose, of rows G of the joints and motions, and of further rows after them. Units
    are as in `tangent_space`. Raises InputError where a large mechanism has too many degrees of freedom."""
    if system.bodies <= THRESHOLDS.large:
        return tangent_space(system, G.dense(), scale, lengths)
    from scipy.sparse import diags

    constraints = np.arange(system.constraints - system.bodies)
    rows = independent_rows(system, pose, G.chosen(constraints))
    freedom = 6 * system.bodies - len(rows)
    if freedom > THRESHOLDS.most_dense:
        raise _too_free(freedom)
    lengths = tangent_lengths(system) if lengths is None else lengths
    scale = system.row_scale[system.bodies :] if scale is None else scale
    exact = Bordered(system, diags(lengths**-2.0, format="csr"), G, rows)
    x = np.random.default_rng(SEED).normal(size=(6 * system.bodies, freedom))
    for _ in range(2):  # a single pass leaves the round-off of nearly parallel random vectors
        x = np.linalg.qr((exact.solve((x.T / lengths).T)[0].T / lengths).T)[0]
    N = (lengths * x.T).T
    others = G.chosen(np.arange(len(constraints), G.count))
    if others.count:
        _, σ, V = np.linalg.svd((others.times(N).T / scale[len(constraints) :]).T)
        N = N @ V[np.count_nonzero(σ > THRESHOLDS.dependent) :].T
    if len(rows) == G.count:
        return TangentSpace(N, _pseudoinverse(exact, N, lengths), lengths)
    return TangentSpace(N, _pseudoinverse(unit_metric(system, G, scale, lengths), N, lengths), lengths)


def along_tangent_space(system: System, G: Rows, rows: Array) -> Array:
    """Return the parts of rows (k, 6n) along the tangent space of rows G of the joints and motions. Their coordinates
    are arbitrary: only the inner products of the parts have a meaning."""
    if system.bodies <= THRESHOLDS.large:
        return np.asarray(rows @ tangent_space(system, G.dense()).N, dtype=float)
    lengths = tangent_lengths(system)
    metric = unit_metric(system, G, system.row_scale[system.bodies :], lengths)
    return np.asarray(metric.solve(rows.T)[0].T / lengths, dtype=float)


def unit_metric(system: System, G: Rows, scale: Array, lengths: Array) -> Proximal:
    """Return the factor that splits displacements into those along rows and those along their tangent space.

    Rows are scaled to length 1 where lengths are in the units `lengths` (6n,); rows that are 0 beside `scale` (m,) are
    ignored."""
    from scipy.sparse import diags

    rows = G.sparse() @ diags(lengths)
    size = np.sqrt(np.asarray(rows.multiply(rows).sum(axis=1))).ravel()
    size = np.where(size > THRESHOLDS.dependent * scale, size, np.inf)
    return Proximal(system, diags(lengths**-2.0, format="csr"), G, size)


def _pseudoinverse(metric: Bordered | Proximal, N: Array, lengths: Array) -> LinearOperator:
    """Return G⁺ as an operator. The part of forces along the tangent space N is subtracted first: its round-off would
    be divided by the compliance of the proximal rows."""
    from scipy.sparse.linalg import LinearOperator

    def smallest(rows: Array) -> Array:
        return metric.solve(np.zeros((len(N), *rows.shape[1:])), rows)[0]

    def multipliers(force: Array) -> Array:
        return metric.solve(force - ((N @ (N.T @ force)).T / lengths**2).T)[1]

    both = {"matvec": smallest, "matmat": smallest, "rmatvec": multipliers, "rmatmat": multipliers}
    return LinearOperator((len(N), metric.constraints), dtype=float, **both)


def _too_free(freedom: int) -> InputError:
    said = f"this is done by dense matrices, for up to {THRESHOLDS.most_dense} degrees of freedom"
    hint = "`mbproj modes` and `mbproj equilibrium` know more at rest, `mbproj run` moving; or take fewer bodies"
    return InputError(Problem(f"{said}, and this mechanism has {freedom}", key=("bodies",), hint=hint))


def is_definite(system: System, A: csr_matrix, G: Rows) -> bool:
    """Return whether ξᵀA ξ > 0 for all ξ with G ξ = 0, of a symmetric A. That is so where all pivots of A + ρ GᵀG are
    positive, for a large ρ (Finsler 1937)."""
    from scipy.sparse.linalg import splu

    scaled = _Scaled(system, A, G)
    stiff = (scaled.A + 1.0 / THRESHOLDS.half_digits * scaled.G.T @ scaled.G).tocsc()
    try:
        factor = splu(stiff, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return False
    return bool(np.array_equal(factor.perm_r, factor.perm_c) and np.all(factor.U.diagonal() > 0.0))


@final
class _Scaled:
    """A and G with lengths in units of the mechanism's length, and A scaled to the order of G, so that pivots are
    comparable."""

    def __init__(self, system: System, A: csr_matrix, G: Rows, sizes: Array | None = None) -> None:
        from scipy.sparse import diags

        self.lengths = tangent_lengths(system)
        inner = diags(self.lengths) @ A @ diags(self.lengths)
        self.size = max(float(np.abs(inner.diagonal()).max(initial=0.0)), float(np.finfo(float).tiny))
        self.rows = 1.0 / (system.row_scale[system.bodies :] if sizes is None else sizes)
        self.A, self.G = (inner / self.size).tocsr(), (diags(self.rows) @ G.sparse() @ diags(self.lengths)).tocsr()


def diagonal(matrix: csr_matrix) -> Array:
    """Return the diagonal as an array."""
    return np.asarray(matrix.diagonal(), dtype=float)


def singular() -> InputError:
    """Return the error of a large mechanism whose matrix is singular."""
    return InputError(
        Problem(
            "the equations of this mechanism are singular: some motion moves no mass and is held by nothing",
            hint="`mbproj check` names it",
        )
    )
