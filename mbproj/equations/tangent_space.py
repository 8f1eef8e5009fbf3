"""The tangent space of the constraints at a pose: a null space matrix N of G, and its derivatives along a motion.

Lengths are in units of the mechanism's length. Rows may depend on each other: N spans the motions that all of them
allow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.kinematics import Pose, body_rates, twist_of
from mbproj.model.euler_parameters import product
from mbproj.model.system import System

if TYPE_CHECKING:
    from scipy.sparse.linalg import LinearOperator


@dataclass(frozen=True, eq=False)
class TangentSpace:
    """N (6n, f), G N = 0, orthonormal where lengths are in units of the mechanism's length; and G⁺ (6n, m).

    G⁺ gives the smallest ξ with Gξ = c, so that λ = (G⁺)ᵀ f is the smallest with Gᵀλ = f; for large mechanisms it is an
    operator. `lengths` (6n,) are the units."""

    N: Array
    pseudoinverse: Array | LinearOperator
    lengths: Array

    @property
    def freedom(self) -> int:
        """f, the degrees of freedom at this pose."""
        return int(self.N.shape[1])

    def rates(self, G_dot: Array, G_ddot: Array) -> tuple[Array, Array]:
        """Return N' and N'' where N changes as little as possible: G N' = -G' N and G N'' = -G'' N - 2 G' N'.

        N' is normal to N at all times, so that NᵀN'' = -N'ᵀN'; lengths are in units of the mechanism's length."""
        N_dot = -self.pseudoinverse @ (G_dot @ self.N)
        scaled = N_dot / self.lengths[:, None]
        normal = -self.pseudoinverse @ (G_ddot @ self.N + 2.0 * G_dot @ N_dot)
        return N_dot, normal - self.N @ (scaled.T @ scaled)


def tangent_space(system: System, G: Array, scale: Array | None = None, lengths: Array | None = None) -> TangentSpace:
    """Return the tangent space by dense matrices, of the rows G (m, 6n) of the joints and then the motions.

    `scale` (m,) replaces the scales of the system's rows, for other rows. `lengths` (6n,) replace the system's units of
    tangent coordinates."""
    lengths = tangent_lengths(system) if lengths is None else lengths
    scale = system.row_scale[system.bodies :] if scale is None else scale
    rows = G * lengths / scale[:, None]
    size = np.linalg.norm(rows, axis=1)
    factor = np.where(size > THRESHOLDS.dependent, 1.0 / np.maximum(size, THRESHOLDS.dependent), 0.0)
    U, σ, V = np.linalg.svd(rows * factor[:, None], full_matrices=True)
    rank = int(np.count_nonzero(σ > THRESHOLDS.dependent))
    N = lengths[:, None] * V[rank:].T
    pseudoinverse = lengths[:, None] * (V[:rank].T / σ[:rank]) @ (U[:, :rank].T * (factor / scale))
    return TangentSpace(N, np.asarray(pseudoinverse, dtype=float), lengths)


def tangent_lengths(system: System) -> Array:
    """Return the units of tangent coordinates, (6n,): the mechanism's length for shifts, 1 for turns."""
    return np.tile([system.length] * 3 + [1.0] * 3, system.bodies)


# --- Tangent coordinates ξ = (δr global, δθ in body axes) of each body ------------------------------------------------
# Poses moved along them, velocities u = (r', ω) and accelerations u' in place of q' and q''.


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
