"""Kinetic and potential energy (Eq. 16)."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Numbers
from mbproj.dynamics.equations.kinematics import Pose, Twist, body_rates
from mbproj.dynamics.equations.reflected import added_energy
from mbproj.model.system import System


def kinetic_energy(system: System, pose: Pose, twist: Twist) -> Numbers:
    """T = ½ Σ m r'² + ½ Σ ωᵀJω in J, and ½ Σ I s'² of reflected inertias, shape (...)."""
    velocity, omega = twist.velocity[..., :-1, :], body_rates(pose, twist)[..., :-1, :]
    translation = np.sum(system.mass * np.sum(velocity * velocity, axis=-1), axis=-1)
    rotation = np.sum(omega * (system.inertia @ omega[..., None])[..., 0], axis=(-1, -2))
    found = 0.5 * (translation + rotation)
    return found if system.reflected is None else found + added_energy(system.reflected, pose, twist)


def potential_energy(system: System, pose: Pose) -> Numbers:
    """V = -Σ m g·r in J, shape (...): zero with all centres of mass at the origin."""
    return -np.sum(system.mass * (pose.position[..., :-1, :] @ system.gravity), axis=-1)
