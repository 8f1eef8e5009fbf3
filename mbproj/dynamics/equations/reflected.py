"""What reflected inertias ½ I s'² add to the equations of motion: with s' = g v, Lagrange's equations of a coordinate s
give I gᵀ s'', of which s'' = g a + g' v; so M gains I gᵀg and Q loses I gᵀ(g' v)."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Numbers, total
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import set_bias, set_jacobian, set_velocity, tangent_jacobian
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.model.reflected import ReflectedInertias


@dataclass(frozen=True, eq=False)
class Reaction:
    """Of samples: rates s' and the forces -I s'' along the coordinates, (..., k), in N or N m."""

    rate: Numbers
    force: Numbers


def added_mass(reflected: ReflectedInertias, pose: Pose) -> Array:
    """Σ I gᵀg, (7n, 7n)."""
    g = set_jacobian(reflected.rows, pose)
    return np.asarray(g.T @ (reflected.inertia[:, None] * g), dtype=float)


def added_force(reflected: ReflectedInertias, pose: Pose, twist: Twist) -> Array:
    """-Σ I gᵀ(g' v), (7n,)."""
    return -set_jacobian(reflected.rows, pose).T @ (reflected.inertia * set_bias(reflected.rows, pose, twist))


def with_flywheels(
    reflected: ReflectedInertias, pose: Pose, twist: Twist, M: Array, C_q: Array, Q: Array, gamma: Array
) -> tuple[Array, Array, Array, Array]:
    """The terms of Eq. 14 without reflected inertias, with each as a coordinate of its own that a row holds:
    g v - s' = 0. The same motion; but what is added to M takes the digits of bodies that are light beside it."""
    rows, count = reflected.rows, len(reflected.inertia)
    n, m = len(M), len(C_q)
    whole, held = np.zeros((n + count, n + count)), np.zeros((m + count, n + count))
    whole[:n, :n], whole[n:, n:] = M, np.diag(reflected.inertia)
    held[:m, :n], held[m:, :n], held[m:, n:] = C_q, set_jacobian(rows, pose), -np.eye(count)
    bias = -set_bias(rows, pose, twist)
    return whole, held, np.concatenate([Q, np.zeros(count)]), np.concatenate([gamma, bias])


def added_energy(reflected: ReflectedInertias, pose: Pose, twist: Twist) -> Numbers:
    """½ Σ I s'² in J, shape (...)."""
    return 0.5 * total(reflected.inertia * set_velocity(reflected.rows, pose, twist) ** 2)


def inertial_reaction(reflected: ReflectedInertias, pose: Pose, twist: Twist, change: Twist) -> Reaction:
    """What the inertias do to their coordinates; `change` holds q'' as a twist does q'."""
    rows = reflected.rows
    acceleration = set_velocity(rows, pose, change) + set_bias(rows, pose, twist)
    return Reaction(set_velocity(rows, pose, twist), -reflected.inertia * acceleration)


def pull_on_bodies(reflected: ReflectedInertias, pose: Pose, reaction: Reaction) -> Array:
    """gᵀ times the forces -I s'' of one sample on each body, (n, 6): forces, and torques in body axes."""
    return np.einsum("k,kbi->bi", reaction.force, tangent_gradients(reflected, pose)[:, :-1])


def tangent_gradients(reflected: ReflectedInertias, pose: Pose) -> Array:
    """g in (δr, δθ in body axes) of each body and, last, of the ground, (k, n+1, 6)."""
    return tangent_jacobian(reflected.rows, pose)[..., :6]
