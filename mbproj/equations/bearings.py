"""The loads of the bearings of joints, from the multipliers of the joints' rows."""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array, Numbers, cross
from mbproj.base.dataclass import dataclass
from mbproj.equations.kinematics import Pose
from mbproj.equations.reactions import reactions
from mbproj.model.contacts import Bearings
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class Supports:
    """The forces on both supports of each bearing, (..., B, 3), and the force along its axis, or the push of a stop,
    (..., B), in N. All are linear in the multipliers."""

    first: Numbers
    second: Numbers
    along: Numbers

    def plus(self, others: Supports, parts: Numbers) -> Supports:
        """Return these supports plus the `parts` (R,) of others, (R, ..., B, 3)."""
        return Supports(
            self.first + np.tensordot(parts, others.first, 1),
            self.second + np.tensordot(parts, others.second, 1),
            self.along + np.tensordot(parts, others.along, 1),
        )


def supports(system: System, bearings: Bearings, pose: Pose, multipliers: Numbers) -> Supports:
    """Return the supports' forces at poses (...) for multipliers λ (..., m) of the joints' rows; further ones may
    follow."""
    force, torque = reactions(system, pose, multipliers)
    F, T = force[..., bearings.joint, :], torque[..., bearings.joint, :]
    body = system.reaction_body[bearings.joint]
    z = (pose.rotation[..., body, :, :] @ bearings.axis[..., None])[..., 0]
    along = np.sum(F * z, axis=-1)
    radial = 0.5 * (F - along[..., None] * z)
    couple = cross(T, np.broadcast_to(z, T.shape)) / bearings.length[:, None]
    return Supports(
        radial + couple, radial - couple, along + multipliers[..., : system.joints.size] @ _pushes(system, bearings)
    )


def load(bearings: Bearings, at: Supports) -> Numbers:
    """Return the load of each bearing, (..., B): see `Bearings`."""
    radial = np.linalg.norm(at.first, axis=-1) + np.linalg.norm(at.second, axis=-1)
    carried = bearings.preload + bearings.radial * radial + bearings.axial * np.abs(at.along)
    return np.asarray(np.where(bearings.is_push, at.along, carried))


def slopes(bearings: Bearings, at: Supports, change: Supports) -> Numbers:
    """Return the derivatives (B, R) of the loads at a state, (B,), along changes (R, B, 3)."""
    radial = _norm_derivative(at.first, change.first) + _norm_derivative(at.second, change.second)
    axial = np.where(at.along < 0.0, -change.along, change.along)
    return np.asarray(np.where(bearings.is_push, change.along, bearings.radial * radial + bearings.axial * axial).T)


def _pushes(system: System, bearings: Bearings) -> Array:
    """Return the parts (m, B) with which the joints' rows make pushes of stops, or pulls of ropes."""
    weights = np.zeros((system.joints.size, bearings.size))
    for b, each in enumerate(bearings.parts):
        for joint, row, part in each:
            weights[np.flatnonzero(system.joints.owner == joint)[row], b] = part
    return weights


def _norm_derivative(force: Numbers, change: Numbers) -> Numbers:
    """Return the derivative of |f| along changes, (R, B)."""
    size = np.linalg.norm(force, axis=-1)
    along = np.sum(force * change, axis=-1) / np.where(size > 0.0, size, 1.0)
    return np.where(size > 0.0, along, np.linalg.norm(change, axis=-1))
