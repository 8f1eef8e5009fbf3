"""Damped Gauss-Newton steps (Levenberg) of many poses at once, for the search for all assemblies of a mechanism."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags, cross, may_overflow
from mbproj.dynamics.assembly.assemble import scaled_residual
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.equations.motions import Drive
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Conditions, System
from mbproj.thresholds import THRESHOLDS


def close_all(system: System, q: Array, held: Conditions, drive: Drive) -> tuple[Array, Flags]:
    """Return the poses (B, 7n) reached from poses q (B, 7n), and whether each meets joints, motions and `held`
    coordinates."""
    q = q.copy()
    damping, going = np.full(len(q), THRESHOLDS.half_digits), np.ones(len(q), dtype=bool)
    left = scaled_residual(system, pose_of(q), held, drive)
    for _ in range(THRESHOLDS.most_passes):
        open_by = np.abs(left).max(axis=1, initial=0.0)
        going &= (open_by > THRESHOLDS.closed_to) & (damping < 1.0 / THRESHOLDS.half_digits)
        at = np.flatnonzero(going)
        if not len(at):
            break
        rows = scaled_rows_of(system, pose_of(q[at]), held)
        with may_overflow():
            trial = _moved(system, q[at], _steps(rows, left[at], damping[at]))
            trial_left = scaled_residual(system, pose_of(trial), held, drive)
        better = np.linalg.norm(trial_left, axis=1) < np.linalg.norm(left[at], axis=1)
        q[at[better]], left[at[better]] = trial[better], trial_left[better]
        damping[at] = np.where(better, np.maximum(0.2 * damping[at], THRESHOLDS.rounding), 4.0 * damping[at])
    closed: Flags = np.abs(left).max(axis=1, initial=0.0) <= THRESHOLDS.assembled
    return q, closed


def scaled_rows_of(system: System, pose: Pose, held: Conditions) -> Array:
    """Return the derivatives (B, m + c, 6n) of `scaled_residual` by (δr / length, δθ in body axes) of each body."""
    own = _tangent(system, system.rows, pose) / system.row_scale[system.bodies :, None]
    if not len(held.index):
        return own
    wanted = _tangent(system, system.coordinates, pose)[:, held.index]
    lengths = system.coordinates.is_length[held.index]
    return np.concatenate([own, wanted / np.where(lengths, system.length, 1.0)[:, None]], axis=1)


def _tangent(system: System, bound: PrimitiveSet, pose: Pose) -> Array:
    """Return the derivatives (B, m, 6n) of a set's values, lengths in m, by (δr / length, δθ in body axes) of each
    body."""
    body, local = bound.body[bound.entry_slot], bound.local[bound.entry_slot]
    gradient = bound.gradient_entries(pose.places(bound))
    in_body = (gradient[..., None, :] @ pose.rotation[..., body, :, :])[..., 0, :]
    entries = np.empty((*gradient.shape[:-1], 6))
    entries[..., :3] = system.length * bound.is_point[bound.entry_slot, None] * gradient
    entries[..., 3:] = cross(np.broadcast_to(local, in_body.shape), in_body)
    rows = np.zeros((len(gradient), bound.size, system.bodies + 1, 6))
    for entry, (row, own) in enumerate(zip(bound.entry_row.tolist(), body.tolist(), strict=True)):
        rows[:, row, own] += entries[:, entry]
    return rows[:, :, :-1].reshape(len(gradient), bound.size, 6 * system.bodies)


def _steps(rows: Array, left: Array, damping: Array) -> Array:
    """Return the damped steps (B, 6n), none longer than the mechanism's length, or a radian."""
    transposed = np.swapaxes(rows, -1, -2)
    square = transposed @ rows
    diagonal = np.einsum("bii->bi", square)
    diagonal += (damping * (1e-3 + (left * left).sum(axis=1)))[:, None]
    steps = -np.linalg.solve(square, transposed @ left[..., None])[..., 0]
    return np.asarray(steps / np.maximum(np.abs(steps).max(axis=1, keepdims=True), 1.0))


def _moved(system: System, q: Array, motion: Array) -> Array:
    """Return q (B, 7n) after motions (B, 6n) of (δr / length, δθ in body axes)."""
    bodies, δ = q.reshape(len(q), -1, 7), motion.reshape(len(q), -1, 6)
    turn = 0.5 * (np.swapaxes(matrix_L(bodies[..., 3:]), -1, -2) @ δ[..., 3:, None])[..., 0]
    moved = np.concatenate([bodies[..., :3] + system.length * δ[..., :3], bodies[..., 3:] + turn], axis=-1)
    moved[..., 3:] /= np.linalg.norm(moved[..., 3:], axis=-1, keepdims=True)
    return moved.reshape(len(q), -1)
