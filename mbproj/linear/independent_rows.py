"""Independent rows of large mechanisms: loop by loop, with sparse factors for long loops."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.blocks import Rows
from mbproj.dynamics.derivatives.tangent_space import tangent_lengths
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.rank.components import loops_of
from mbproj.dynamics.rank.row_space import independent, row_distances
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

#: The seed of the random vectors, and their number.
SEED, PROBES = 40, 8


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

    probes = remainder(np.random.default_rng(SEED).normal(size=(width, PROBES)))
    met = np.linalg.norm(doubtful @ probes, axis=1) > THRESHOLDS.dependent
    free = np.zeros(doubtful.shape[0], dtype=bool)
    if met.any():
        free[met] = row_distances(remainder(doubtful[np.flatnonzero(met)].toarray().T).T) > THRESHOLDS.dependent
    return free
