"""Forces and torques on bodies: reactions of joints, and given forces and torques."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.arrays import Array, Numbers, cross, dot, like_of
from mbproj.dynamics.equations.forces import given_components, in_global_axes
from mbproj.dynamics.equations.instant import Instant
from mbproj.dynamics.equations.kinematics import Pose, attached, attached_velocity, body_rates
from mbproj.model.system import System


def reactions(system: System, pose: Pose, multipliers: Array) -> tuple[Numbers, Numbers]:
    """Return force in N and torque in N m, (T, nj, 3), on body 2 of each joint at its point in body 2, global axes.

    The constraints act on the bodies with -C_qᵀλ (Eq. 10): with -λg at an attachment that has the gradient g.
    """
    bound = system.joints
    x, (slots, joint) = pose.places(bound), bound.layout.on_second_bodies
    pull, is_point = -bound.forces(x, multipliers[..., : bound.size])[..., slots, :], bound.is_point[slots, None]
    places = attached(pose, system.reaction_body, system.reaction_local, np.ones(len(system.reaction_body)))
    arm = x[..., slots, :] - is_point * places[..., joint, :]
    first = np.flatnonzero(np.diff(joint, prepend=-1))
    shape = *pull.shape[:-2], len(system.reaction_body), 3
    force, torque = (np.zeros(shape, dtype=pull.dtype, like=like_of(pull, arm)) for _ in range(2))
    force[..., joint[first], :] = np.add.reduceat(is_point * pull, first, axis=-2)
    torque[..., joint[first], :] = np.add.reduceat(cross(arm, pull), first, axis=-2)
    return force, torque


def reactions_with_teeth(system: System, pose: Pose, multipliers: Numbers) -> tuple[Numbers, Numbers]:
    """Return the reactions (T, nj, 3) in which gears push with their teeth, where the system has such gears."""
    of_joints = reactions(system, pose, multipliers)
    if not system.couplings.teeth:
        return of_joints
    from mbproj.dynamics.observe.tooth_forces import on_bearings

    return on_bearings(system, pose, *of_joints)


def applied_seen(instant: Instant) -> Mapping[str, Numbers]:
    """Return, by dataset, the given forces in N and torques in N m, in global axes, (T, W, 3), and their power in W,
    (T, W). The power is that along the velocity of the point, or along the angular velocity of the body."""
    given, pose = instant.system.forces.on_bodies, instant.pose
    vectors = in_global_axes(instant, given_components(instant))
    velocity = attached_velocity(instant.twist, given.body, given.point, np.ones(given.size))
    rates = body_rates(pose, instant.twist)[..., given.body, :]
    omega = (pose.rotation[..., given.body, :, :] @ rates[..., None])[..., 0]
    power = dot(vectors, np.where(given.is_torque[:, None], omega, velocity))
    return {"forces/applied": vectors, "forces/applied_power": power}
