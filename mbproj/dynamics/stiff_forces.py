"""The terms of stiff forces in the matrix of an implicit step: JᵀkJ and JᵀcJ, with J the gradients of the coordinates,
(7n,). Only forces that are stiff for the step size enter. Springs that push apart and dampers that drive are left out,
so that the matrix stays positive: the residual contains them exactly."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.instant import Instant
from mbproj.dynamics.fast_modes import slopes_at, speeds_of_free_bodies, unit_pulls
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class StiffForces:
    """The coordinates of stiff forces, `chosen` (e,), their gradients J (e, 7n), and k and c (e, e), symmetric and
    without negative eigenvalues."""

    chosen: Integers
    J: Array
    k: Array
    c: Array

    @cached_property
    def elastic(self) -> Array:
        """JᵀkJ, (7n, 7n)."""
        return np.asarray(self.J.T @ self.k @ self.J)

    @cached_property
    def viscous(self) -> Array:
        """JᵀcJ, (7n, 7n)."""
        return np.asarray(self.J.T @ self.c @ self.J)

    def leader(self, dq: Array, dv: Array) -> int:
        """Return the coordinate whose force a change of q and v (7n,) changes most."""
        force = np.abs(self.k @ (self.J @ dq)) + np.abs(self.c @ (self.J @ dv))
        return int(self.chosen[int(np.argmax(force))])


def stiff_forces(instant: Instant, h: float) -> StiffForces | None:
    """Return the forces that a step of size h at a state cannot treat explicitly; None without any."""
    system = instant.system
    if not system.forces.size:
        return None
    slope, pose = slopes_at(instant), instant.pose
    chosen = np.flatnonzero(h * speeds_of_free_bodies(system, pose, slope) > THRESHOLDS.stiff_for_step)
    if not len(chosen):
        return None
    k, c = (_positive(matrix) for matrix in slope.matrices(chosen))
    return StiffForces(chosen, unit_pulls(system, pose, chosen), k, c)


def _positive(matrix: Array) -> Array:
    """Return the nearest symmetric matrix without negative eigenvalues."""
    symmetric = 0.5 * (matrix + matrix.T)
    if not np.any(symmetric - np.diag(np.diagonal(symmetric))):
        return np.diag(np.maximum(np.diagonal(symmetric), 0.0))
    values, vectors = np.linalg.eigh(symmetric)
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)
