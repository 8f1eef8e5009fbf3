"""Kinetic and potential energy (Eq. 16)."""

from __future__ import annotations

from mbproj.arrays import Numbers, dot, total
from mbproj.dynamics.equations.kinematics import Pose, Twist, body_rates
from mbproj.model.system import System


def kinetic_energy(system: System, pose: Pose, twist: Twist) -> Numbers:
    """Return T = ½ Σ m r'² + ½ Σ ωᵀJω in J, and ½ Σ I s'² of reflected inertias, shape (...)."""
    velocity, omega = twist.velocity[..., :-1, :], body_rates(pose, twist)[..., :-1, :]
    turned = [dot(system.inertia[:, axis], omega) for axis in range(3)]
    rotation = sum(omega[..., axis] * turned[axis] for axis in range(3))
    energy: Numbers = 0.5 * total(system.mass * dot(velocity, velocity) + rotation)
    if not system.reflected.size:
        return energy
    from mbproj.dynamics.equations.reflected import added_energy

    return energy + added_energy(system.reflected, pose, twist)


def potential_energy(system: System, pose: Pose) -> Numbers:
    """Return V = -Σ m g·r in J, shape (...): zero with all centres of mass at the origin."""
    energy: Numbers = -total(system.mass * dot(system.gravity, pose.position[..., :-1, :]))
    return energy
