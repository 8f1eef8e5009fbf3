"""The distance of C_q from losing rank: condition numbers as written and scaled, and the joint that loses rows
first."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import jacobian
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.rank.components import Component
from mbproj.dynamics.rank.row_space import Dependence, dependences, independent, scaled_jacobian
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True)
class Conditioning:
    """Condition numbers of C_q without redundant rows: `as_written`, in SI units, and `scaled`, with lengths in units
    of the system's length and rows of unit length; None for more than `large` bodies.

    `distance`: the smallest singular value of a loop's rows in (δr / length, δθ), those of a joint in one scale and
    without what follows from the joints before: the smallest change of the rows that makes them dependent (Eckart and
    Young 1936). It does not depend on axes. None without a loop, as the rows of a tree are independent at every pose.
    `owner`: the owner, as "joint 'A'", of the rows that this smallest change concerns most."""

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
    distance, owner = None, None
    for part in dependences(system, pose):
        if not _has_joints(system, part.component):
            continue
        left, values, _ = np.linalg.svd(part.held, full_matrices=False)
        if distance is None or values[-1] < distance * (1.0 - THRESHOLDS.dependent):
            distance, owner = float(values[-1]), _largest_owner(system, part, left[:, -1])
    if system.bodies > THRESHOLDS.large:
        return Conditioning(None, None, distance, owner)
    rows = independent(system, pose)
    return Conditioning(
        _condition(jacobian(system, pose)[rows]),
        _condition(scaled_jacobian(system, pose)[rows]),
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


def _largest_owner(system: System, part: Dependence, share: Array) -> str:
    """Return the joint or motion with the largest part of a vector over the combinations held."""
    sizes = np.bincount(part.owners, share**2)
    owner = int(np.argmax(sizes > sizes.max() * (1.0 - THRESHOLDS.rounded)))
    row = part.component.rows[np.argmax(system.rows.owner[part.component.rows] == owner)]
    return system.row_owner(int(row) + system.bodies)
