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
    translation = np.einsum("n,...ni,...ni->...", system.mass, velocity, velocity)
    rotation = np.einsum("...ni,nij,...nj->...", omega, system.inertia, omega)
    found: Numbers = 0.5 * (translation + rotation)
    return found if system.reflected is None else found + added_energy(system.reflected, pose, twist)


def potential_energy(system: System, pose: Pose) -> Numbers:
    """V = -Σ m g·r in J, shape (...): zero with all centres of mass at the origin."""
    heights: Numbers = -(pose.position[..., :-1, :] @ system.gravity)
    return heights @ system.mass
