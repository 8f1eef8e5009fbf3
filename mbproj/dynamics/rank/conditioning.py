"""The distance of C_q from losing rank: condition numbers as written and scaled, and the joint that loses rows
first."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import jacobian
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.rank.components import Component, component_rows, loops_of
from mbproj.dynamics.rank.row_space import scaled_jacobian, split, unit_rows
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True)
class Conditioning:
    """Condition numbers of C_q without redundant rows: `as_written`, in SI units, and `scaled`, with lengths in units
    of the system's length and rows of unit length; None for more than `large` bodies.

    `distance`: the smallest singular value of a loop's rows in (δr / length, δθ), of unit length: the smallest change
    of the rows that makes them dependent (Eckart and Young 1936). None without a loop, as the rows of a tree are
    independent at every pose. `owner`: the owner, as "joint 'A'", of the rows that this smallest change concerns
    most."""

    as_written: float | None
    scaled: float | None
    distance: float | None
    owner: str | None

    @property
    def words(self) -> str:
        """The distance of the pose from a singular one, in words."""
        if self.distance is None:
            return "no loops, and so no singular poses"
        if self.distance < THRESHOLDS.rounded:
            return "all but singular"
        return "near a singular pose" if self.distance < THRESHOLDS.passing else "far from singular poses"


def conditioning(system: System, pose: Pose) -> Conditioning:
    """Return the conditioning at a pose. Components of more than `large` bodies do not count for the distance."""
    components = [component for component in loops_of(system) if len(component.bodies) <= THRESHOLDS.large]
    distance, owner, independent = None, None, np.ones(system.constraints, dtype=bool)
    for component, rows in zip(components, component_rows(system, pose, components), strict=True):
        unit = unit_rows(rows)
        basis, dependent = split(unit, component.by_level(system))
        independent[system.bodies + component.rows[dependent]] = False
        if not _has_joints(system, component):
            continue
        left, values, _ = np.linalg.svd(unit[basis], full_matrices=False)
        if distance is None or values[-1] < distance * (1.0 - THRESHOLDS.dependent):
            distance, owner = float(values[-1]), _largest_owner(system, component.rows[basis], left[:, -1])
    if system.bodies > THRESHOLDS.large:
        return Conditioning(None, None, distance, owner)
    return Conditioning(
        _condition(jacobian(system, pose)[independent]),
        _condition(scaled_jacobian(system, pose)[independent]),
        distance,
        owner,
    )


def _has_joints(system: System, component: Component) -> bool:
    """Whether the component has several joints; a motion counts for the joint that it drives."""
    driven = system.coordinates.owner[system.motions.joint_coordinate]
    joints = np.concatenate([system.joints.owner, driven])[component.rows]
    return bool(np.any(joints != joints[0]))


def _condition(rows: Array) -> float:
    """Return the condition number of independent rows (m, 7n). For many rows it is the root of the condition number of
    C_q C_qᵀ, whose eigenvalues come from Lanczos' method."""
    if len(rows) <= 7 * THRESHOLDS.large:
        values = np.linalg.svd(rows, compute_uv=False)
        return float(values[0] / values[-1])
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import eigsh

    sparse = csc_matrix(rows)
    products, first = (sparse @ sparse.T).tocsc(), np.ones(len(rows))
    (largest,) = eigsh(products, 1, v0=first, return_eigenvectors=False)
    (smallest,) = eigsh(products, 1, sigma=0.0, v0=first, return_eigenvectors=False)
    return float(np.sqrt(largest / abs(smallest)))


def _largest_owner(system: System, rows: Integers, share: Array) -> str:
    """Return the joint or motion with the largest part of a vector over rows."""
    owners = [system.row_owner(int(row) + system.bodies) for row in rows]
    parts = dict.fromkeys(owners, 0.0)
    for owner, part in zip(owners, share, strict=True):
        parts[owner] += float(part**2)
    largest = max(parts.values())
    return next(owner for owner, part in parts.items() if part > largest * (1.0 - THRESHOLDS.rounded))
