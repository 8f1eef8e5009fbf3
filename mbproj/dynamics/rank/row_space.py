"""Linear dependence of rows: which rows depend on which, and the distance of the others from dependence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.equations.constraint_equations import jacobian
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.equations.round_off import EPSILON
from mbproj.dynamics.rank.components import component_rows, loops_of
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def scaled_jacobian(system: System, pose: Pose) -> Array:
    """Return C_q with lengths in units of the system's length and each row of unit length, (m, 7n)."""
    C_q = jacobian(system, pose).reshape(system.constraints, -1, 7)
    C_q[..., :3] *= system.length
    return unit_rows(C_q.reshape(system.constraints, -1) / system.row_scale[:, None])


def unit_rows(rows: Array) -> Array:
    """Return the rows, which are of the order of 1, scaled to unit length; rows of zero length become 0."""
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.asarray(
        np.where(length > THRESHOLDS.dependent, rows / np.maximum(length, THRESHOLDS.dependent), 0.0), dtype=float
    )


def row_distances(rows: Array) -> Array:
    """Return the distance of each row from the span of the rows before it, (m,): the diagonal of R in QR of the
    transpose.

    A row beyond the number of columns has the distance 0.
    """
    count, columns = rows.shape
    distances = np.zeros(count)
    R = np.linalg.qr(rows.T, mode="r")
    distances[: min(count, columns)] = np.abs(np.diag(R))
    if np.all(distances[: min(count, columns)] > THRESHOLDS.dependent):
        return distances
    return _distances_by_elimination(rows)


def _distances_by_elimination(rows: Array) -> Array:
    """Return the distances where rows are dependent. The diagonal of R would spread the defect over independent rows,
    too."""
    basis, size = np.zeros((min(rows.shape), rows.shape[1])), 0
    distances = np.zeros(len(rows))
    for index, row in enumerate(rows):
        rest = row
        for _ in range(2):  # two passes are enough (Kahan)
            rest = rest - (basis[:size] @ rest) @ basis[:size]
        distances[index] = np.linalg.norm(rest)
        if distances[index] > THRESHOLDS.dependent:
            basis[size] = rest / distances[index]
            size += 1
    return distances


def split(rows: Array, order: Sequence[int] | Integers) -> tuple[Integers, Integers]:
    """Return the rows, in this `order`, that are independent of those before them, and the others."""
    order = np.asarray(order, dtype=np.intp)
    free = row_distances(rows[order]) > THRESHOLDS.dependent
    return order[free], order[~free]


def shares(rows: Array, basis: Integers, dependent: Integers) -> Array:
    """Return the coefficients (d, b) of the `dependent` rows in the independent rows `basis`; round-off is set to 0.

    A dependent row and the rows with a nonzero coefficient are a circuit: leave one out, and the others are
    independent.
    """
    coefficients = np.linalg.lstsq(rows[basis].T, rows[dependent].T, rcond=None)[0].T
    largest = np.maximum(np.abs(coefficients).max(axis=1, initial=0.0, keepdims=True), 1.0)
    return np.asarray(
        np.where(np.abs(coefficients) > EPSILON / THRESHOLDS.dependent * largest, coefficients, 0.0), dtype=float
    )


def self_stresses(system: System, pose: Pose) -> Array:
    """Return a basis of the multipliers λ (d, k) of joints and motions without a force on any body, Gᵀλ = 0. The basis
    has one vector for each redundant row, with torques of the order of 1 and forces of the order of 1 / length."""
    components = [component for component in loops_of(system) if len(component.bodies) <= THRESHOLDS.large]
    scale = system.row_scale[system.bodies :]
    stresses = [np.zeros((0, len(scale)))]
    for component, rows in zip(components, component_rows(system, pose, components), strict=True):
        unit = unit_rows(rows)
        basis, dependent = split(unit, component.by_level(system))
        length = np.where(unit.any(axis=1), np.linalg.norm(rows, axis=1), 1.0)
        part = np.zeros((len(dependent), len(rows)))
        part[np.arange(len(dependent)), dependent] = 1.0
        part[:, basis] = -shares(unit, basis, dependent)
        stress = np.zeros((len(dependent), len(scale)))
        stress[:, component.rows] = part / length / np.abs(part).max(axis=1, initial=1.0, keepdims=True)
        stresses.append(stress / scale)
    return np.concatenate(stresses)
