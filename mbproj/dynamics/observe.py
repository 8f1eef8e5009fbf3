"""From samples to what a results file holds: poses, velocities, reactions, violations, energies, in field's terms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dynamics.assembly import coordinate_values, is_angle
from mbproj.dynamics.constraint_equations import constraint, constraint_velocity, cross, set_velocity
from mbproj.dynamics.energy import kinetic_energy, potential_energy
from mbproj.dynamics.kinematics import (
    Pose,
    Twist,
    attached,
    attached_bias,
    attached_velocity,
    body_rates,
    pose_of,
    slots_of,
    twist_of,
)
from mbproj.dynamics.samples import Samples
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System

#: Values of T samples by the path of their dataset; the first axis is time.
Block = Mapping[str, npt.NDArray[Any]]


def observe(system: System, samples: Samples, initial_energy: float) -> Block:
    """Everything recorded at these samples; `initial_energy` in J is what the energy balance starts from."""
    pose = pose_of(samples.q)
    twist = twist_of(pose, samples.v)
    change = twist_of(pose, samples.acceleration)
    return {
        "time": samples.t,
        **_bodies(system, pose, twist, change),
        **_points("markers", pose, twist, change, system.marker_body, system.marker_local),
        **_joints(system, pose, twist, samples),
        **_energies(system, pose, twist, initial_energy),
        "diagnostics/position_violation": np.abs(constraint(system, pose)).max(axis=-1),
        "diagnostics/velocity_violation": np.abs(constraint_velocity(system, pose, twist)).max(axis=-1),
        "diagnostics/step_size": samples.step_size,
        **{f"diagnostics/{name}": values for name, values in samples.counters.items()},
    }


def total_energy(system: System, q: Array, v: Array) -> float:
    """T + V in J of one state."""
    pose = pose_of(q)
    return float(kinetic_energy(system, pose, twist_of(pose, v)) + potential_energy(system, pose))


def _bodies(system: System, pose: Pose, twist: Twist, change: Twist) -> Block:
    """`change` holds the accelerations as a twist does the velocities; ω' = 2 L Λ'' because L' Λ' = 0."""
    carrier, to_body = system.body_carrier, np.swapaxes(rotation_matrix(system.body_turn), -1, -2)
    return {
        **_points("bodies", pose, twist, change, carrier, system.body_offset),
        "bodies/orientation": product(pose.orientation[:, carrier], system.body_turn),
        "bodies/angular_velocity": (to_body @ body_rates(pose, twist)[:, carrier, :, None])[..., 0],
        "bodies/angular_acceleration": (to_body @ body_rates(pose, change)[:, carrier, :, None])[..., 0],
    }


def _points(kind: str, pose: Pose, twist: Twist, change: Twist, body: Integers, local: Array) -> Block:
    """Position, velocity and acceleration of points of carriers."""
    is_point = np.ones(len(body))
    return {
        f"{kind}/position": attached(pose, body, local, is_point),
        f"{kind}/velocity": attached_velocity(twist, body, local, is_point),
        f"{kind}/acceleration": attached_velocity(change, body, local, is_point) + attached_bias(twist, body, local),
    }


def _joints(system: System, pose: Pose, twist: Twist, samples: Samples) -> Block:
    bound = system.joints
    open_by = np.abs(bound.value(attached(pose, *slots_of(bound))))
    length = _largest_by_joint(system, np.where(bound.is_length, open_by, 0.0))
    angle = _largest_by_joint(system, np.where(bound.is_length, 0.0, open_by))
    force, torque = reactions(system, pose, samples.multipliers)
    return {
        "joints/violation": np.maximum(length, angle),
        "joints/violation_length": length,
        "joints/violation_angle": angle,
        "joints/reaction_force": force,
        "joints/reaction_torque": torque,
        "joints/coordinate": coordinate_values(system, pose) + 2.0 * np.pi * samples.turns * is_angle(system),
        "joints/speed": set_velocity(system.coordinates, pose, twist),
    }


def reactions(system: System, pose: Pose, multipliers: Array) -> tuple[Numbers, Numbers]:
    """Force in N and torque in N m, (T, nj, 3), on body 2 of each joint at its point in body 2, global axes.

    The constraints act on the bodies with -C_qᵀλ (Eq. 10): with -λg at an attachment that has the gradient g.
    """
    bound = system.joints
    x = attached(pose, *slots_of(bound))
    arm = x - bound.is_point[:, None] * pose.position[..., bound.body, :]
    on_body_2 = (bound.side[bound.entry_slot] == 2).astype(float)
    weights = -multipliers[..., bound.entry_row] * on_body_2
    pull = weights[..., None] * bound.gradient_entries(x)
    owner = bound.owner[bound.entry_row]
    by_joint = (owner == np.arange(len(system.names.joints))[:, None]).astype(float)
    force = by_joint @ (pull * bound.is_point[bound.entry_slot, None])
    about_centre = by_joint @ cross(arm[..., bound.entry_slot, :], pull)
    point = (pose.rotation[..., system.reaction_body, :, :] @ system.reaction_local[..., None])[..., 0]
    return force, about_centre - cross(point, force)


def _largest_by_joint(system: System, rows: Numbers) -> Numbers:
    """The largest of each joint's rows, (..., m) to (..., nj); a joint's rows are consecutive."""
    joints = len(system.names.joints)
    if not joints:
        return np.zeros((*rows.shape[:-1], 0))
    return np.maximum.reduceat(rows, np.searchsorted(system.joints.owner, np.arange(joints)), axis=-1)


def _energies(system: System, pose: Pose, twist: Twist, initial_energy: float) -> Block:
    kinetic, potential = kinetic_energy(system, pose, twist), potential_energy(system, pose)
    return {
        "diagnostics/kinetic_energy": kinetic,
        "diagnostics/potential_energy": potential,
        "diagnostics/total_energy": kinetic + potential,
        "diagnostics/energy_balance": kinetic + potential - initial_energy,
    }
