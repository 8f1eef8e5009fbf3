"""Which rows of large mechanisms are independent: loop by loop, those of long loops by sparse factors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.blocks import Rows
from mbproj.dynamics.derivatives.tangent_space import tangent_lengths
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.rank.components import component_rows, loops_of
from mbproj.dynamics.rank.row_space import row_distances, unit_rows
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


def independent_rows(system: System, pose: Pose, G: Rows) -> Integers:
    """Rows of the joints and motions, G (m, 6n), that do not follow from others."""
    free = np.ones(system.constraints - system.bodies, dtype=bool)
    loops = loops_of(system)
    short = [loop for loop in loops if len(loop.bodies) <= THRESHOLDS.dense_modes]
    for loop, rows in zip(short, component_rows(system, pose, short), strict=True):
        free[loop.rows] = row_distances(unit_rows(rows)) > THRESHOLDS.dependent
    for loop in loops:
        if len(loop.bodies) > THRESHOLDS.dense_modes:
            free[loop.rows] = _independent(_unit_rows(system, G)[loop.rows])
    return np.flatnonzero(free)


def _unit_rows(system: System, G: Rows) -> csr_matrix:
    from scipy.sparse import diags

    rows = (G.sparse() @ diags(tangent_lengths(system))).tocsr()
    size = np.sqrt(np.asarray(rows.multiply(rows).sum(axis=1))).ravel()
    return diags(1.0 / np.where(size > 0.0, size, 1.0)) @ rows


def _independent(rows: csr_matrix) -> Array:
    """Whether each row is far from the span of others. The pivots of their products with each other are the squares of
    their distances, with half of the digits; the few rows that these leave in doubt are seen beside the others."""
    from scipy.sparse import bmat, identity
    from scipy.sparse.linalg import splu

    count, grain = rows.shape[0], float(np.finfo(float).eps)
    products = (rows @ rows.T + grain * identity(count)).tocsc()
    factor = splu(products, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    free = np.asarray(factor.U.diagonal()[factor.perm_c] > THRESHOLDS.clear_distance**2)
    doubtful, clear = rows[np.flatnonzero(~free)].toarray(), rows[np.flatnonzero(free)]
    if len(doubtful):
        one = identity(rows.shape[1])
        beside = splu(bmat([[one, clear.T], [clear, None]], format="csc"))
        for _ in range(2):  # twice is enough (Kahan)
            right = np.concatenate([doubtful.T, np.zeros((clear.shape[0], len(doubtful)))])
            doubtful = beside.solve(right)[: rows.shape[1]].T
        free[~free] = row_distances(doubtful) > THRESHOLDS.dependent
    return free
