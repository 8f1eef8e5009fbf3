"""Linear dependence of rows: which rows depend on which, and the distance of the others from dependence.

`dependences` decides for everything that asks. It does not depend on axes: a rotation of the mechanism, or of a joint's
own frame, mixes the rows of one joint in m, and those in rad, by orthogonal matrices. So these rows have one scale, the
rank is that of singular values, and rows are taken joint by joint: a joint gives the combinations of its rows that the
joints before it do not imply. A walk row by row in global axes would take the wrong row where a plane leans: one whose
distance from the rows before it is the lean.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import jacobian
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.equations.round_off import EPSILON
from mbproj.dynamics.rank.components import Component, component_rows, loops_of
from mbproj.dynamics.rank.lasting import floor_at
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Dependence:
    """The rows of a component at a pose, (k, 6b), in one scale for each joint and unit.

    `basis` are the places in the component of as many rows as the rank, and `dependent` those of the others. `held`
    (r, 6b) are independent combinations of the rows, joint by joint, and `owners` (r,) their joints and motions as
    `system.rows` counts them. `scale` (k,) are the factors that scaled the rows. `floor` is the largest distance that
    counts as dependent."""

    component: Component
    rows: Array
    scale: Array
    basis: Integers
    dependent: Integers
    held: Array
    owners: Integers
    floor: float

    @property
    def unscaled(self) -> Array:
        """The rows in units of the length or rad, as `component_rows` gives them."""
        return self.rows / np.where(self.scale > 0.0, self.scale, 1.0)[:, None]


def dependences(system: System, pose: Pose) -> list[Dependence]:
    """Return the dependence in each component of at most `large` bodies."""
    components = [component for component in loops_of(system) if len(component.bodies) <= THRESHOLDS.large]
    if not components:
        return []
    floor = floor_at(system, pose)
    return [
        _dependence(system, component, rows, floor)
        for component, rows in zip(components, component_rows(system, pose, components), strict=True)
    ]


def independent(system: System, pose: Pose) -> Flags:
    """Return which rows of C are independent of the others, (m,): norm rows, and the basis of each component of at most
    `large` bodies. Rows of larger ones count as independent."""
    free = np.ones(system.constraints, dtype=bool)
    for part in dependences(system, pose):
        free[system.bodies + part.component.rows[part.dependent]] = False
    return free


def dependence_at(system: System, known: Dependence, pose: Pose) -> Dependence:
    """Return the dependence in a component at another pose, with the rows of the `known` basis before all others."""
    (rows,) = component_rows(system, pose, [known.component])
    return _dependence(system, known.component, rows, known.floor, known.basis)


def _dependence(
    system: System, component: Component, rows: Array, floor: float, first: Integers | None = None
) -> Dependence:
    bound, of = system.rows, component.rows
    level = system.is_velocity[system.bodies :][of]
    blocks = _blocks(bound.owner[of], bound.is_length[of])
    scale = np.zeros(len(of))
    for block in blocks:
        size = float(np.linalg.norm(rows[block])) / np.sqrt(len(block))
        scale[block] = 1.0 / size if size > THRESHOLDS.dependent else 0.0
    scaled = rows * scale[:, None]
    owners = bound.owner[of]
    rank = int(np.count_nonzero(np.linalg.svd(scaled, compute_uv=False) > floor))
    every = np.arange(len(of))
    if rank == len(of):
        return Dependence(component, scaled, scale, every, every[:0], scaled, owners, floor)
    # Rows at velocity level come last: a dependent row at position level then depends on rows at position level alone,
    # so that leaving it out opens no joint.
    joints = _blocks(level, owners)
    if first is not None:
        joints = [first, *(rest for joint in joints if len(rest := np.setdiff1d(joint, first)))]
    parts = _taken(scaled, joints, rank)
    basis = np.sort(
        np.concatenate([every[:0], *(joint[chosen] for joint, (chosen, _) in zip(joints, parts, strict=True))])
    )
    held = np.concatenate([scaled[:0], *(combinations for _, combinations in parts)])
    counts = [len(chosen) for chosen, _ in parts]
    of_held = np.repeat([owners[joint[0]] for joint in joints], counts)
    return Dependence(component, scaled, scale, basis, np.setdiff1d(every, basis), held, of_held, floor)


def _blocks(*keys: Integers | Flags) -> list[Integers]:
    """Return the places of equal keys (k,), in the order of the keys; the first key counts most."""
    table = np.stack([np.asarray(key, dtype=np.intp) for key in keys], axis=1)
    _, number = np.unique(table, axis=0, return_inverse=True)
    number = number.ravel()
    return [np.flatnonzero(number == each) for each in range(int(number.max(initial=-1)) + 1)]


def _taken(rows: Array, joints: list[Integers], rank: int) -> list[tuple[Integers, Array]]:
    """Return for each joint the rows, by their places in it, and the combinations that it adds to the span of the
    joints before it; `rank` of them in all.

    What is clearly independent comes first. A mechanism near a singular pose has too few of these, and a smaller
    distance then counts."""
    least = THRESHOLDS.rounded
    while True:
        parts = _added(rows, joints, least)
        count = sum(len(chosen) for chosen, _ in parts)
        if count >= rank or least < EPSILON:
            return parts
        least *= 0.1


def _added(rows: Array, joints: list[Integers], least: float) -> list[tuple[Integers, Array]]:
    """Return what `_taken` does, with the combinations at a distance of more than `least` from the joints before."""
    span = np.zeros((min(rows.shape), rows.shape[1]))
    size, parts = 0, []
    for joint in joints:
        rest = rows[joint]
        for _ in range(2):  # two passes are enough (Kahan)
            rest = rest - (rest @ span[:size].T) @ span[:size]
        U, values, V = np.linalg.svd(rest, full_matrices=False)
        count = min(int(np.count_nonzero(values > least)), len(span) - size)
        span[size : size + count] = V[:count]
        size += count
        parts.append((_farthest(rest, count), U[:, :count].T @ rows[joint]))
    return parts


def _farthest(rest: Array, count: int) -> Integers:
    """Return the numbers of `count` rows, each the farthest from the span of those before it; of equals the first."""
    taken = np.zeros(len(rest), dtype=bool)
    for _ in range(count):
        distance = np.where(taken, -1.0, np.linalg.norm(rest, axis=1))
        row = int(np.argmax(distance >= THRESHOLDS.tied * distance.max()))
        taken[row] = True
        unit = rest[row] / distance[row]
        for _ in range(2):
            rest = rest - np.outer(rest @ unit, unit)
    return np.flatnonzero(taken)


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


def shares(rows: Array, basis: Integers, dependent: Integers) -> Array:
    """Return the coefficients (d, b) of the `dependent` rows in the independent rows `basis`; round-off is set to 0.

    A dependent row and the rows with a nonzero coefficient are a circuit: leave one out, and the others are
    independent.
    """
    if not len(dependent):
        return np.zeros((0, len(basis)))
    U, σ, V = np.linalg.svd(rows[basis].T, full_matrices=False)
    coefficients = (V.T / σ @ (U.T @ rows[dependent].T)).T
    largest = np.maximum(np.abs(coefficients).max(axis=1, initial=0.0, keepdims=True), 1.0)
    grain = THRESHOLDS.round_off_grains * EPSILON / σ.min(initial=1.0)
    return np.asarray(np.where(np.abs(coefficients) > grain * largest, coefficients, 0.0), dtype=float)


def self_stresses(system: System, pose: Pose) -> Array:
    """Return a basis of the multipliers λ (d, k) of joints and motions without a force on any body, Gᵀλ = 0. The basis
    has one vector for each redundant row, with torques of the order of 1 and forces of the order of 1 / length."""
    scale = system.row_scale[system.bodies :]
    stresses = [np.zeros((0, len(scale)))]
    for found in dependences(system, pose):
        dependent, basis = found.dependent, found.basis
        part = np.zeros((len(dependent), len(found.rows)))
        part[np.arange(len(dependent)), dependent] = 1.0
        part[:, basis] = -shares(found.rows, basis, dependent)
        stress = np.zeros((len(dependent), len(scale)))
        weight = np.where(found.scale > 0.0, found.scale, 1.0)
        stress[:, found.component.rows] = part * weight / np.abs(part).max(axis=1, initial=1.0, keepdims=True)
        stresses.append(stress / scale)
    return np.concatenate(stresses)
