"""Forces and torques on bodies: reactions of joints, and given forces and torques."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.base.arrays import Array, Numbers, cross, dot, like_of
from mbproj.equations.forces import given_components, in_global_axes
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import Pose, attached, attached_velocity, body_rates
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

    return on_bearings(system, pose, *of_joints)


def applied_seen(instant: Instant) -> Mapping[str, Numbers]:
    """Return, by dataset, the given forces in N and torques in N m, in global axes, (T, W, 3), and their power in W,
    (T, W). The power is that along the velocity of the point, or along the angular velocity of the body."""
    on_bodies, pose = instant.system.forces.on_bodies, instant.pose
    vectors = in_global_axes(instant, given_components(instant))
    velocity = attached_velocity(instant.twist, on_bodies.body, on_bodies.point, np.ones(on_bodies.size))
    rates = body_rates(pose, instant.twist)[..., on_bodies.body, :]
    omega = (pose.rotation[..., on_bodies.body, :, :] @ rates[..., None])[..., 0]
    power = dot(vectors, np.where(on_bodies.is_torque[:, None], omega, velocity))
    return {"forces/applied": vectors, "forces/applied_power": power}


# --- Forces between teeth ---------------------------------------------------------------------------------------------
# Their points of action, and their effect on the bearings of both wheels.


def on_bearings(system: System, pose: Pose, force: Numbers, torque: Numbers) -> tuple[Numbers, Numbers]:
    """Return reactions (T, nj, 3) in which gears push with their teeth, not with a pure torque on each wheel.

    At the pitch point P the second wheel takes F = τ/r e ± |τ|/r tan α n. τ is its torque, e is normal to the line of
    the centres, and n points from P to its centre. The first wheel takes -F. The bearings carry the difference between
    this force and the pure torque τ.
    """
    force, torque = force.copy(), torque.copy()
    places = attached(pose, system.reaction_body, system.reaction_local, np.ones(len(system.reaction_body)))
    x = pose.places(system.coordinates)
    for gear in system.couplings.teeth:
        centres = [places[..., joint, :] for joint in gear.joints]
        axes = [_axis(system, x, coordinate) for coordinate in gear.coordinates]
        first, second = gear.teeth
        line = _normal_part(centres[1] - centres[0], axes[0])
        pitch = centres[0] + line * (first / (first + second))
        turning = dot(torque[..., gear.joint, :], axes[1])
        out = _normal_part(pitch - centres[1], axes[1])
        radius = np.sqrt(dot(out, out))[..., None]
        along = (turning[..., None] / radius) * cross(axes[1], out / radius)
        aside = np.sign(second) * np.abs(turning)[..., None] / radius * np.tan(gear.pressure_angle) * out / radius
        push = along - aside
        both = (-push, turning * (first / second)), (push, turning)
        for joint, centre, axis, (load, about) in zip(gear.joints, centres, axes, both, strict=True):
            force[..., joint, :] -= load
            torque[..., joint, :] += about[..., None] * axis - cross(pitch - centre, load)
        force[..., gear.joint, :] = push
        torque[..., gear.joint, :] = cross(pitch - places[..., gear.joint, :], push)
    return force, torque


def _axis(system: System, x: Numbers, coordinate: int) -> Numbers:
    """Return the axis about which an angle counts, at places (T, S, 3)."""
    first, second, _ = system.coordinates.layout.members[system.coordinates.layout.member[coordinate]].slots
    return cross(x[..., first, :], x[..., second, :])


def _normal_part(vector: Numbers, axis: Numbers) -> Numbers:
    return np.asarray(vector - dot(vector, axis)[..., None] * axis)
