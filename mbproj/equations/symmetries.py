"""Conserved momenta of a mechanism: those of rigid motions of all bodies that no joint, motion or force resists.

Let u be the velocities of a rigid motion. By Noether's theorem uᵀM q' is constant where u changes no constraint, no
potential and no coordinate of a force. Conditions that depend on the pose are tested at some poses that the mechanism
can take.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.base.arrays import Array, cross
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.constraints import jacobian, set_velocity
from mbproj.equations.forces import deflection, rates
from mbproj.equations.kinematics import Pose, body_rates, pose_of, twist_of
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.system import System

#: The number of poses that are tested beside the start.
POSES = 3

#: Velocities q' (k, 7n) at q of the k rigid motions that are tested.
Fields = Callable[[Array], Array]


def rigid_fields(q: Array) -> Array:
    """Return the six rigid motions at q (7n,): along and about the global axes through the origin, (6, 7n)."""
    rows, to_body = q.reshape(-1, 7), pose_of(q).rotation[:-1].swapaxes(-1, -2)
    fields = np.zeros((6, len(rows), 7))
    for axis, e in enumerate(np.eye(3)):
        fields[axis, :, :3] = e
        fields[3 + axis, :, :3] = np.cross(e, rows[:, :3])
        omega = to_body @ e
        fields[3 + axis, :, 3:] = 0.5 * (np.swapaxes(matrix_L(rows[:, 3:]), -1, -2) @ omega[..., None])[..., 0]
    return fields.reshape(6, -1)


def kept_fields(
    system: System, state: State, close: Callable[[Array], Array | None], fields: Fields = rigid_fields
) -> Array:
    """Return the combinations (j, k) of the k fields whose momenta the mechanism conserves. `close` returns q moved to
    the constraints, or None where that fails."""
    poses, generator = [state.q], np.random.default_rng(7)
    for _ in range(POSES):
        q = close(state.q + THRESHOLDS.long_way * _tangent(system, state.q, generator))
        poses += [] if q is None else [q]
    scale = np.linalg.norm(fields(state.q) / _lengths(system), axis=-1)
    resisted = np.concatenate([_resistance(system, state, q, fields(q)) / scale for q in poses])
    _, sizes, basis = np.linalg.svd(resisted)
    conserved = basis[np.count_nonzero(sizes > THRESHOLDS.dependent) :]
    return np.ascontiguousarray(conserved / scale)


def _lengths(system: System) -> Array:
    return np.tile([system.length] * 3 + [1.0] * 4, system.bodies)


def _tangent(system: System, q: Array, generator: np.random.Generator) -> Array:
    """Return a change of q that the joints allow to first order, of size 1 in the mechanism's lengths."""
    lengths = _lengths(system)
    _, sizes, basis = np.linalg.svd(jacobian(system, pose_of(q)) * lengths)
    free = basis[np.count_nonzero(sizes > THRESHOLDS.dependent * sizes[0]) :]
    along = generator.standard_normal(len(free)) @ free
    return np.asarray(lengths * along / max(np.linalg.norm(along), np.finfo(float).tiny))


def _resistance(system: System, state: State, q: Array, fields: Array) -> Array:
    """Return the rates, (r, k), by each field (k, 7n) at q of the quantities that a symmetry must not change: rows,
    coordinates of forces and contacts, the potential of gravity, and bodies with given forces."""
    pose, columns = pose_of(q), []
    C_q = jacobian(system, pose) / system.row_scale[:, None]
    for u in fields:
        twist = twist_of(pose, u)
        sets = [system.forces.laws.coordinates]
        sets += [part.coordinates for part in (system.stops, system.frictions) if part is not None]
        sets += [system.reflected.rows] if system.reflected.size else []
        changes = [C_q @ u, *(set_velocity(each, pose, twist) / _row_lengths(system, each) for each in sets)]
        if system.forces.bushings.size:
            bushings = system.forces.bushings
            changes.append(rates(bushings, deflection(bushings, pose), pose, twist).ravel() / system.length)
        changes.append(_by_gravity(system, u))
        changes.append(_of_pushed(system, pose, u))
        columns.append(np.concatenate([np.atleast_1d(part) for part in changes]))
    return np.array(columns).T


def _row_lengths(system: System, bound: object) -> Array:
    return np.where(bound.is_length, system.length, 1.0)  # type: ignore[attr-defined]


def _by_gravity(system: System, u: Array) -> Array:
    """Return the power of gravity, over the weight times the mechanism's length."""
    weight = float(np.sum(system.mass) * np.linalg.norm(system.gravity))
    power = np.sum(system.mass * (u.reshape(-1, 7)[:, :3] @ system.gravity))
    return np.array([power / (weight * system.length) if weight else 0.0])


def _of_pushed(system: System, pose: Pose, u: Array) -> Array:
    """Return the velocities of bodies with given forces and torques, which may do work on any motion."""
    on_bodies, twist = system.forces.on_bodies, twist_of(pose, u)
    if not on_bodies.size:
        return np.zeros(0)
    omega, turn = body_rates(pose, twist)[on_bodies.body], pose.rotation[on_bodies.body]
    moved = twist.velocity[on_bodies.body] + (turn @ cross(omega, on_bodies.point)[..., None])[..., 0]
    return np.concatenate([np.where(on_bodies.is_torque[:, None], omega, moved / system.length).ravel()])
