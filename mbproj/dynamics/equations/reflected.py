"""The terms of reflected inertias ½ I s'² in the equations of motion. With s' = g v, Lagrange's equations of a
coordinate s give I gᵀ s'', of which s'' = g a + g' v. So I gᵀg is added to M, and I gᵀ(g' v) is subtracted from Q."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Numbers, total
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import set_bias, set_jacobian, set_velocity, tangent_jacobian
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.model.forces import ReflectedInertias


@dataclass(frozen=True, eq=False)
class Reaction:
    """Rates s' and forces -I s'' along the coordinates of reflected inertias at samples, (..., k), in N or N m."""

    rate: Numbers
    force: Numbers


def added_mass(reflected: ReflectedInertias, pose: Pose) -> Array:
    """Return Σ I gᵀg, (7n, 7n)."""
    g = set_jacobian(reflected.rows, pose)
    return np.asarray(g.T @ (reflected.inertia[:, None] * g), dtype=float)


def added_force(reflected: ReflectedInertias, pose: Pose, twist: Twist) -> Array:
    """Return -Σ I gᵀ(g' v), (7n,)."""
    return -set_jacobian(reflected.rows, pose).T @ (reflected.inertia * set_bias(reflected.rows, pose, twist))


def with_flywheels(
    reflected: ReflectedInertias, pose: Pose, twist: Twist, M: Array, C_q: Array, Q: Array, gamma: Array
) -> tuple[Array, Array, Array, Array]:
    """Return the terms of Eq. 14 with each reflected inertia as a coordinate of its own, held by a row g v - s' = 0.

    The motion is the same. But a large inertia added to M would cost much lighter bodies digits."""
    rows, count = reflected.rows, len(reflected.inertia)
    n, m = len(M), len(C_q)
    whole, held = np.zeros((n + count, n + count)), np.zeros((m + count, n + count))
    whole[:n, :n], whole[n:, n:] = M, np.diag(reflected.inertia)
    held[:m, :n], held[m:, :n], held[m:, n:] = C_q, set_jacobian(rows, pose), -np.eye(count)
    bias = -set_bias(rows, pose, twist)
    return whole, held, np.concatenate([Q, np.zeros(count)]), np.concatenate([gamma, bias])


def added_energy(reflected: ReflectedInertias, pose: Pose, twist: Twist) -> Numbers:
    """Return ½ Σ I s'² in J, shape (...)."""
    return 0.5 * total(reflected.inertia * set_velocity(reflected.rows, pose, twist) ** 2)


def inertial_reaction(reflected: ReflectedInertias, pose: Pose, twist: Twist, change: Twist) -> Reaction:
    """Return the reaction of the inertias on their coordinates; `change` is a `Twist` that holds q'' in place of q'."""
    rows = reflected.rows
    acceleration = set_velocity(rows, pose, change) + set_bias(rows, pose, twist)
    return Reaction(set_velocity(rows, pose, twist), -reflected.inertia * acceleration)


def pull_on_bodies(reflected: ReflectedInertias, pose: Pose, reaction: Reaction) -> Array:
    """Return gᵀ times the forces -I s'' of one sample on each body, (n, 6): forces, and torques in body axes."""
    return np.einsum("k,kbi->bi", reaction.force, tangent_gradients(reflected, pose)[:, :-1])


def tangent_gradients(reflected: ReflectedInertias, pose: Pose) -> Array:
    """Return g in (δr, δθ in body axes) of each body and, last, of the ground, (k, n+1, 6)."""
    return tangent_jacobian(reflected.rows, pose)[..., :6]
