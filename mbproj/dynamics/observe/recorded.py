"""From samples to what a results file holds: poses, velocities, reactions, violations, energies, in field's terms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers, Numbers, may_overflow
from mbproj.dynamics.assembly.assemble import State, coordinate_values, is_angle
from mbproj.dynamics.equations.constraint_equations import (
    constraint,
    constraint_acceleration,
    constraint_velocity,
    cross,
    set_velocity,
)
from mbproj.dynamics.equations.energy import kinetic_energy, potential_energy
from mbproj.dynamics.equations.forces import LawState, law_state, potential_of_springs
from mbproj.dynamics.equations.kinematics import (
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
from mbproj.dynamics.equations.motions import Drive, drive_at
from mbproj.dynamics.equations.reflected import inertial_reaction
from mbproj.dynamics.equations.teeth import Teeth, sums_at_start
from mbproj.dynamics.observe.samples import Samples
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System

#: Values of T samples by the path of their dataset; the first axis is time.
Block = Mapping[str, npt.NDArray[Any]]


def observe(system: System, samples: Samples, start: State) -> Block:
    """Everything recorded at these samples of a run from `start`, from where the energy balance and teeth count. What
    overflows, in a run that is lost, is recorded so."""
    with may_overflow():
        return _observed(system, samples, start)


def _observed(system: System, samples: Samples, start: State) -> Block:
    pose = pose_of(samples.q)
    twist = twist_of(pose, samples.v)
    change = twist_of(pose, samples.acceleration)
    drive = drive_at(system, samples.t, _teeth(system, pose, samples, start))
    C = constraint(system, pose, drive)
    joints = _joints(system, pose, twist, samples, C[:, system.bodies :][:, : system.joints.size])
    laws = _law_state(system, pose, twist, samples.t, joints["joints/coordinate"])
    return {
        "time": samples.t,
        **_bodies(system, pose, twist, change),
        **_points("markers", pose, twist, change, system.marker_body, system.marker_local),
        **joints,
        **_laws(system, samples, laws, (pose, twist, change)),
        **_motions(system, samples, drive),
        **_energies(system, pose, twist, laws, samples.work, total_energy(system, start)),
        "diagnostics/position_violation": np.abs(C).max(axis=-1),
        "diagnostics/velocity_violation": np.abs(constraint_velocity(system, pose, twist, drive)).max(axis=-1),
        "diagnostics/acceleration_violation": np.abs(constraint_acceleration(system, pose, twist, change, drive)).max(
            axis=-1
        ),
        "diagnostics/step_size": samples.step_size,
        **{f"diagnostics/{name}": values for name, values in samples.counters.items()},
    }


def total_energy(system: System, state: State) -> float:
    """T + V in J of one state."""
    return float(total_energies(system, np.array(state.t), state.q, state.v, state.turns))


def total_energies(system: System, t: Array, q: Array, v: Array, turns: Integers) -> Numbers:
    """T + V in J, (...), of states: times (...), coordinates and velocities (..., 7n), whole turns (..., nc)."""
    pose = pose_of(q)
    twist = twist_of(pose, v)
    laws = _law_state(system, pose, twist, t, coordinate_values(system, pose) + 2.0 * np.pi * turns)
    return kinetic_energy(system, pose, twist) + _potential(system, pose, laws)


def _law_state(system: System, pose: Pose, twist: Twist, t: Numbers | float, coordinate: Numbers) -> LawState | None:
    """What the laws of forces are at; None without forces. `coordinate` are the joints', turns counted."""
    return None if system.forces is None else law_state(system.forces, pose, twist, t, coordinate)


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


def _teeth(system: System, pose: Pose, samples: Samples, start: State) -> Teeth | None:
    """Those that the samples' turns say are in mesh; None without gears and screws."""
    if not system.meshes.size:
        return None
    first = pose_of(start.q)
    counted = coordinate_values(system, first) + 2.0 * np.pi * start.turns
    return Teeth(sums_at_start(system, first, counted), _coordinates(system, pose, samples))


def _coordinates(system: System, pose: Pose, samples: Samples) -> Numbers:
    """The joints' coordinates, turns counted, (T, nc)."""
    return coordinate_values(system, pose) + 2.0 * np.pi * samples.turns * is_angle(system)


def _joints(system: System, pose: Pose, twist: Twist, samples: Samples, rows: Numbers) -> Block:
    """`rows` (T, m): those of C that are the joints'."""
    bound, open_by = system.joints, np.abs(rows)
    length = _largest_by_joint(system, np.where(bound.is_length, open_by, 0.0))
    angle = _largest_by_joint(system, np.where(bound.is_length, 0.0, open_by))
    force, torque = reactions(system, pose, samples.multipliers)
    return {
        "joints/violation": np.maximum(length, angle),
        "joints/violation_length": length,
        "joints/violation_angle": angle,
        "joints/reaction_force": force,
        "joints/reaction_torque": torque,
        "joints/coordinate": _coordinates(system, pose, samples),
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
    force = _by_joint(owner, pull * bound.is_point[bound.entry_slot, None])
    about_centre = _by_joint(owner, cross(arm[..., bound.entry_slot, :], pull))
    point = (pose.rotation[..., system.reaction_body, :, :] @ system.reaction_local[..., None])[..., 0]
    return force, about_centre - cross(point, force)


def _by_joint(owner: Integers, parts: Numbers) -> Numbers:
    """The sum of each joint's parts, (..., e, 3) to (..., nj, 3); each joint has some."""
    order = np.argsort(owner, kind="stable")
    if not len(order):
        return parts
    first = np.flatnonzero(np.diff(owner[order], prepend=-1))
    return np.add.reduceat(parts[..., order, :], first, axis=-2)


def _largest_by_joint(system: System, rows: Numbers) -> Numbers:
    """The largest of each joint's rows, (..., m) to (..., nj); a joint's rows are consecutive."""
    joints = len(system.names.joints)
    if not joints:
        return np.zeros((*rows.shape[:-1], 0))
    return np.maximum.reduceat(rows, np.searchsorted(system.joints.owner, np.arange(joints)), axis=-1)


def _laws(system: System, samples: Samples, laws: LawState | None, moving: tuple[Pose, Twist, Twist]) -> Block:
    """What acts along lengths and joint coordinates: the laws, then the reflected inertias."""
    none = np.zeros((len(samples.t), 0))
    found = [none] * 3 if laws is None else [laws.value, laws.rate, laws.force]
    if system.reflected is not None:
        reaction = inertial_reaction(system.reflected, *moving)
        own = _coordinates(system, moving[0], samples)[:, system.reflected.joint_coordinate]
        added = (own, reaction.rate, reaction.force)
        found = [np.concatenate(pair, axis=-1) for pair in zip(found, added, strict=True)]
    return dict(zip(("forces/coordinate", "forces/rate", "forces/force"), found, strict=True))


def _motions(system: System, samples: Samples, drive: Drive | None) -> Block:
    """The constraints act along a coordinate with -λ (Eq. 10); the motions' rows are the last."""
    none, undriven = np.zeros((len(samples.t), 0)), samples.multipliers.shape[1] - system.driven
    return {
        "motions/value": none if drive is None else drive.value,
        "motions/rate": none if drive is None else drive.rate,
        "motions/force": -samples.multipliers[:, undriven:],
    }


def _potential(system: System, pose: Pose, laws: LawState | None) -> Numbers:
    """V in J of gravity and of springs."""
    potential = potential_energy(system, pose)
    if system.forces is None or laws is None:
        return potential
    return potential + potential_of_springs(system.forces, laws)


def _energies(
    system: System, pose: Pose, twist: Twist, laws: LawState | None, work: Array, initial_energy: float
) -> Block:
    """Energies, and their balance with the work (T, 2) done and dissipated."""
    kinetic, potential = kinetic_energy(system, pose, twist), _potential(system, pose, laws)
    return {
        "diagnostics/kinetic_energy": kinetic,
        "diagnostics/potential_energy": potential,
        "diagnostics/total_energy": kinetic + potential,
        "diagnostics/work": work[:, 0],
        "diagnostics/dissipation": work[:, 1],
        "diagnostics/energy_balance": kinetic + potential - initial_energy - work[:, 0] + work[:, 1],
    }
