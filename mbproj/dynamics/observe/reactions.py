"""Reactions: what the constraints of each joint exert on its second body."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Numbers, cross
from mbproj.dynamics.equations.kinematics import Pose, attached
from mbproj.model.system import System


def reactions(system: System, pose: Pose, multipliers: Array) -> tuple[Numbers, Numbers]:
    """Force in N and torque in N m, (T, nj, 3), on body 2 of each joint at its point in body 2, global axes.

    The constraints act on the bodies with -C_qᵀλ (Eq. 10): with -λg at an attachment that has the gradient g.
    """
    bound = system.joints
    x, (slots, joint) = pose.places(bound), bound.layout.on_second_bodies
    if not len(slots):
        none = np.zeros((*x.shape[:-2], 0, 3))
        return none, none
    pull = -bound.forces(x, multipliers[..., : bound.size])[..., slots, :]
    is_point = bound.is_point[slots, None]
    places = attached(pose, system.reaction_body, system.reaction_local, np.ones(len(system.reaction_body)))
    arm = x[..., slots, :] - is_point * places[..., joint, :]
    first = np.flatnonzero(np.diff(joint, prepend=-1))  # each joint has some
    force: Numbers = np.add.reduceat(is_point * pull, first, axis=-2)
    torque: Numbers = np.add.reduceat(cross(arm, pull), first, axis=-2)
    return force, torque
