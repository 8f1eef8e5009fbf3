"""Bordered matrices of large mechanisms, sparse: one factor of [A Gᵀ; G 0] by SuperLU, with independent rows of G."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dynamics.derivatives.blocks import Rows
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.rank.components import component_rows, loops_of
from mbproj.dynamics.rank.row_space import row_distances, unit_rows
from mbproj.errors import InputError, Problem
from mbproj.linear.tangent_space import tangent_lengths
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


def independent_rows(system: System, pose: Pose) -> Integers:
    """Rows of the joints and motions that do not follow from those before them, found loop by loop."""
    free = np.ones(system.constraints - system.bodies, dtype=bool)
    loops = loops_of(system)
    for loop, rows in zip(loops, component_rows(system, pose, loops), strict=True):
        free[loop.rows] = row_distances(unit_rows(rows)) > THRESHOLDS.dependent
    return np.flatnonzero(free)


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
