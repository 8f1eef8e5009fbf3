"""C, C', C_q and γ of Eqs. 2-9: a norm row for each body's Euler parameters, then the joints' rows.

The Jacobian is taken in (δr, δθ, ε) of each body first, with δθ the small rotation in body axes and ε the relative
change of |Λ|, and then in coordinates: with δθ = 2 L δΛ / |Λ|² and ε = ΛᵀδΛ / |Λ|²,

    C_Λ = (2 G_θ L + G_ε Λᵀ) / |Λ|²,     G_θ = s × Aᵀg,   G_ε = 2 g·A s    for a gradient g on a point or vector A s.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers, contiguous, cross, like_of
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.kinematics import Pose, Twist, attached_bias, pose_of, twist_of
from mbproj.equations.motions import NO_DRIVE, Drive, drive_at
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System


def constraint(system: System, pose: Pose, drive: Drive = NO_DRIVE) -> Numbers:
    """Return C of Eqs. 2-4, (..., m): norm rows ΛᵀΛ - 1, then the joints' rows and the motions', in m or rad.

    A system with motions needs `drive`, the values that these prescribe: `drive_at(system, t)`. The drive may contain
    the teeth in mesh; else gears and screws close to the nearest teeth.
    """
    orientation = pose.orientation[..., :-1, :]
    norms = np.sum(orientation * orientation, axis=-1) - 1.0
    rows = system.rows.value(pose.places(system.rows))
    if drive.teeth is not None:
        from mbproj.equations.turning import to_the_tooth

        rows = to_the_tooth(system, pose, drive.teeth, rows)
    rows[..., system.joints.size :] = _excess(system, rows[..., system.joints.size :], drive)
    return np.concatenate([norms, rows], axis=-1)


def constraint_velocity(system: System, pose: Pose, twist: Twist, drive: Drive = NO_DRIVE) -> Numbers:
    """Return C' = C_q q' + C_t of Eq. 5, (..., m)."""
    norms = 2.0 * np.sum(pose.orientation[..., :-1, :] * twist.rate[..., :-1, :], axis=-1)
    rates = np.concatenate([norms, set_velocity(system.rows, pose, twist)], axis=-1)
    rates[..., system.bodies + system.joints.size :] -= drive.rate
    return rates


def time_derivative(system: System, drive: Drive) -> Array:
    """Return C_t, (m,): zero but in the rows of motions."""
    C_t = np.zeros(system.constraints, like=like_of(drive.rate))
    C_t[system.bodies + system.joints.size :] = -drive.rate
    return C_t


def _excess(system: System, value: Numbers, drive: Drive) -> Numbers:
    """Return coordinates (..., k) less their prescribed values; angles without whole turns, within [-π, π]."""
    is_length = system.rows.is_length[system.joints.size :]
    excess = value - np.where(is_length, drive.value, np.remainder(drive.value, 2.0 * np.pi))
    return excess - np.where(is_length, 0.0, 2.0 * np.pi * np.round(excess.real / (2.0 * np.pi)))


def set_velocity(bound: PrimitiveSet, pose: Pose, twist: Twist) -> Numbers:
    """Return the time derivative of a set's values, (..., m)."""
    return bound.rate(pose.places(bound), twist.rates(bound))


def gamma(system: System, pose: Pose, twist: Twist, drive: Drive = NO_DRIVE) -> Numbers:
    """Return γ of Eqs. 7-9, (..., m): C'' = C_q q'' - γ, with -C_tt in the rows of motions."""
    rate = twist.rate[..., :-1, :]
    right_hand_side = np.concatenate(
        [-2.0 * np.sum(rate * rate, axis=-1), -set_bias(system.rows, pose, twist)], axis=-1
    )
    right_hand_side[..., system.bodies + system.joints.size :] += drive.acceleration
    return right_hand_side


def constraint_acceleration(
    system: System, pose: Pose, twist: Twist, change: Twist, drive: Drive = NO_DRIVE
) -> Numbers:
    """Return C'' = C_q q'' - γ, (..., m); `change` is a `Twist` that holds q'' in place of q'."""
    norms = 2.0 * np.sum(pose.orientation[..., :-1, :] * change.rate[..., :-1, :], axis=-1)
    return np.concatenate([norms, set_velocity(system.rows, pose, change)], axis=-1) - gamma(system, pose, twist, drive)


def set_bias(bound: PrimitiveSet, pose: Pose, twist: Twist) -> Numbers:
    """Return the part of d²/dt² of a set's values without q'', (..., m)."""
    bias = bound.rate(pose.places(bound), attached_bias(twist, bound.body, bound.local))
    return bias + bound.curvature(pose.places(bound), twist.rates(bound))


def jacobian(system: System, pose: Pose) -> Array:
    """Return C_q of Eqs. 5-6, (m, 7n), at one pose."""
    n = system.bodies
    norms = np.zeros((n, n, 7), like=pose.orientation)
    norms[np.arange(n), np.arange(n), 3:] = 2.0 * pose.orientation[:-1]
    return np.concatenate([norms.reshape(n, 7 * n), set_jacobian(system.rows, pose)])


def set_jacobian(bound: PrimitiveSet, pose: Pose) -> Array:
    """Return ∂/∂q of a set's values, (m, 7n), at one pose."""
    tangent = tangent_jacobian(bound, pose)
    norm2 = np.sum(pose.orientation * pose.orientation, axis=-1)[:, None]
    rows = np.empty_like(tangent)
    rows[..., :3] = tangent[..., :3]
    turn = 2.0 * (tangent[..., None, 3:6] @ pose.L)[..., 0, :]
    rows[..., 3:] = (turn + tangent[..., 6:] * pose.orientation) / norm2
    return contiguous(rows[:, :-1]).reshape(bound.size, 7 * (len(pose.position) - 1))


def tangent_jacobian(bound: PrimitiveSet, pose: Pose) -> Array:
    """Return ∂/∂(δr, δθ, ε) of a set's values, (m, n+1, 7), the ground last."""
    bodies = len(pose.position)
    body, entries = tangent_entries(bound, pose)
    places = ((bound.entry_row * bodies + body) * 7)[:, None] + np.arange(7)
    total: Array = np.bincount(places.ravel(), entries.ravel(), minlength=bound.size * bodies * 7).astype(float)
    return total.reshape(bound.size, bodies, 7)


def tangent_entries(bound: PrimitiveSet, pose: Pose) -> tuple[Integers, Array]:
    """Return the terms that `tangent_jacobian` sums: the body (e,) and ∂/∂(δr, δθ, ε) (e, 7) of each entry of the row
    `entry_row`."""
    body = bound.layout.entry_body
    gradient = bound.gradient_entries(pose.places(bound))
    local = bound.local[bound.entry_slot]
    in_body = (gradient[:, None, :] @ pose.rotation[body])[:, 0, :]
    entries = np.empty((len(body), 7), like=like_of(gradient, local))
    entries[:, :3] = bound.layout.entry_is_point * gradient
    entries[:, 3:6] = cross(local, in_body)
    entries[:, 6] = 2.0 * np.sum(local * in_body, axis=-1)
    return body, entries


def constraint_at(system: System, q: Numbers, t: Numbers | float = 0.0) -> Numbers:
    """Return C at coordinates q (..., 7n) and times t (...)."""
    return constraint(system, pose_of(q), drive_at(system, t))


def constraint_velocity_at(system: System, q: Numbers, v: Numbers, t: Numbers | float = 0.0) -> Numbers:
    """Return C' at coordinates q and velocities v (..., 7n) and times t (...)."""
    pose = pose_of(q)
    return constraint_velocity(system, pose, twist_of(pose, v), drive_at(system, t))


# --- The residuals of C = 0 and C' = 0 that round-off alone leaves, row by row ----------------------------------------
# No projection can close joints further.
# A row is computed from coordinates that are stored to ε of their size, so it is known to ε times the largest
# coordinate in it. The solution of the projection's equations adds ε times their condition number times the violation
# before the last pass. This second part is smaller: for positions the violation is itself near round-off, and where
# pivots are small the solution is refined.


EPSILON = float(np.finfo(float).eps)
#: Motions whose inertia is below this part of the largest are reported: round-off of forces on other bodies changes
#: them by `no_motion`, relatively.
HARDLY_ANY = EPSILON / THRESHOLDS.no_motion


def has_light_bodies(system: System) -> bool:
    """Return whether a body has hardly any mass, or moment of inertia, beside the others."""
    moments = np.linalg.eigvalsh(system.inertia)
    light = system.mass.min() <= HARDLY_ANY * system.mass.max() or moments.min() <= HARDLY_ANY * moments.max()
    return bool(light)


def position_grain(system: System, pose: Pose) -> Array:
    """Return ε times the largest coordinate in each row of C, (m,): 1 for vectors, and for points their local
    coordinates plus the positions of their bodies."""
    reach = np.abs(pose.position).max(axis=-1)
    largest = _largest(system, lambda body, size, is_point: (reach[body] + size) * is_point)
    return EPSILON * np.maximum(largest, np.minimum(1.0, system.row_scale))


def velocity_grain(system: System, pose: Pose, twist: Twist) -> Array:
    """Return ε times the largest velocity in each row of C', (m,), per s: of points, of vectors (their length is 1),
    and of the coordinates from which velocities of points are computed."""
    speed = np.abs(twist.velocity).max(axis=-1)
    turning = 2.0 * np.linalg.norm(twist.rate, axis=-1)
    reach = np.abs(pose.position).max(axis=-1)
    largest = _largest(
        system,
        lambda body, size, is_point: np.where(
            is_point, speed[body] + turning[body] * np.maximum(size, reach[body]), turning[body]
        ),
    )
    largest[: system.bodies] = turning[: system.bodies]
    return EPSILON * largest


def _largest(system: System, of_slot: Callable[[Integers, Array, Array], Array]) -> Array:
    """Return the largest value in each row, (m,), from `of_slot(body, largest local coordinate, is_point)`, (S,)."""
    largest, bound = np.zeros(system.constraints), system.rows
    values = of_slot(bound.body, np.abs(bound.local).max(axis=-1), bound.is_point)
    np.maximum.at(largest, system.bodies + bound.entry_row, values[bound.entry_slot])
    return largest
