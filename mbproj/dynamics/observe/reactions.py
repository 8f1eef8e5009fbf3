"""Reactions: what the constraints of each joint exert on its second body."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers, Numbers, cross
from mbproj.dynamics.equations.kinematics import Pose, attached
from mbproj.model.system import System


def reactions(system: System, pose: Pose, multipliers: Array) -> tuple[Numbers, Numbers]:
    """Force in N and torque in N m, (T, nj, 3), on body 2 of each joint at its point in body 2, global axes.

    The constraints act on the bodies with -C_qᵀλ (Eq. 10): with -λg at an attachment that has the gradient g.
    """
    bound = system.joints
    x = pose.places(bound)
    arm = x - bound.is_point[:, None] * pose.position[..., bound.body, :]
    on_body_2 = (bound.side[bound.entry_slot] == 2).astype(float)
    weights = -multipliers[..., bound.entry_row] * on_body_2
    pull = weights[..., None] * pose.gradients(bound)
    owner = bound.owner[bound.entry_row]
    force = _by_joint(owner, pull * bound.is_point[bound.entry_slot, None])
    about_centre = _by_joint(owner, cross(arm[..., bound.entry_slot, :], pull))
    point = attached(pose, system.reaction_body, system.reaction_local, np.zeros(len(system.reaction_body)))
    return force, about_centre - cross(point, force)


def _by_joint(owner: Integers, parts: Numbers) -> Numbers:
    """The sum of each joint's parts, (..., e, 3) to (..., nj, 3); each joint has some."""
    order = np.argsort(owner, kind="stable")
    if not len(order):
        return parts
    first = np.flatnonzero(np.diff(owner[order], prepend=-1))
    return np.add.reduceat(parts[..., order, :], first, axis=-2)
