"""Tangent coordinates ξ = (δr global, δθ in body axes) of each body: poses moved along them, velocities u = (r', ω) and
accelerations u' in place of q' and q''."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.kinematics import Pose, body_rates, twist_of
from mbproj.model.euler_parameters import product


def moved(q: Array, ξ: Array) -> Array:
    """Return coordinates (7n,) after each body was shifted by δr and turned by the rotation vector δθ, exactly; ξ
    (6n,)."""
    rows, change = q.reshape(-1, 7), ξ.reshape(-1, 6)
    half = 0.5 * np.linalg.norm(change[:, 3:], axis=1, keepdims=True)
    turn = np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * change[:, 3:]], axis=1)
    orientation = product(rows[:, 3:], turn)
    orientation /= np.linalg.norm(orientation, axis=1, keepdims=True)
    return np.concatenate([rows[:, :3] + change[:, :3], orientation], axis=1).ravel()


def velocities(pose: Pose, u: Array) -> Array:
    """Return q' (7n,) from u (6n,): Λ' = ½ Lᵀω."""
    rows = u.reshape(-1, 6)
    rate = 0.5 * (np.swapaxes(pose.L[:-1], -1, -2) @ rows[:, 3:, None])[..., 0]
    return np.concatenate([rows[:, :3], rate], axis=1).ravel()


def accelerations(pose: Pose, u: Array, change: Array) -> Array:
    """Return q'' (7n,) from u and u' (6n,): Λ'' = ½ Lᵀω' - ¼ |ω|² Λ."""
    rows = velocities(pose, change).reshape(-1, 7)
    ω = u.reshape(-1, 6)[:, 3:]
    rows[:, 3:] -= 0.25 * np.sum(ω * ω, axis=1, keepdims=True) * pose.orientation[:-1]
    return rows.ravel()


def tangent_velocities(pose: Pose, v: Array) -> Array:
    """Return u (6n,) from q' (7n,)."""
    twist = twist_of(pose, v)
    return np.concatenate([twist.velocity, body_rates(pose, twist)], axis=1)[:-1].ravel()
