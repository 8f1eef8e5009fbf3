"""Poses and energies of the planar and the spatial four-bar in closed form, by the crank's angle."""

from __future__ import annotations

import numpy as np

from tests.mechanisms.closed_forms import Of
from tests.mechanisms.running import Run


def planar_pose(done: Run, φ: float):
    """Angles of coupler and rocker by the intersection of two circles, and their rates for φ' = 1."""
    a, b, c, d = (done.parameters[name] for name in ("crank", "coupler", "rocker", "frame"))
    diagonal = d - a * np.exp(1j * φ)
    ψ = np.angle(diagonal) + np.arccos((b * b + abs(diagonal) ** 2 - c * c) / (2 * b * abs(diagonal)))
    χ = np.angle(b * np.exp(1j * ψ) - diagonal)
    # a e^iφ + b ψ' e^iψ = c χ' e^iχ, each part without the other unknown
    return ψ, χ, a * np.sin(φ - χ) / (b * np.sin(χ - ψ)), a * np.sin(φ - ψ) / (c * np.sin(χ - ψ))


def planar_energy(done: Run) -> tuple[Of, Of]:
    """Moment of inertia on the crank, and potential energy, of the crank's angle φ."""
    a, b, c = (done.parameters[name] for name in ("crank", "coupler", "rocker"))
    crank, coupler, rocker = done.scene.bodies

    def moment(φ: float) -> float:
        ψ, _, ψ_rate, χ_rate = planar_pose(done, φ)
        velocity = a * np.exp(1j * φ) + b / 2 * ψ_rate * np.exp(1j * ψ)
        turning = crank.inertia[1][1] + coupler.inertia[1][1] * ψ_rate**2 + rocker.inertia[1][1] * χ_rate**2
        return turning + crank.mass * a**2 / 4 + coupler.mass * abs(velocity) ** 2 + rocker.mass * (c / 2 * χ_rate) ** 2

    def potential(φ: float) -> float:
        ψ, χ, _, _ = planar_pose(done, φ)
        heights = a / 2 * np.sin(φ), a * np.sin(φ) + b / 2 * np.sin(ψ), c / 2 * np.sin(χ)
        return 9.81 * sum(m * z for m, z in zip((crank.mass, coupler.mass, rocker.mass), heights, strict=True))

    return moment, potential


def spatial_pose(done: Run, φ: float):
    """Ends B, C of the rod and their velocities for φ' = 1, with 2cx sin χ - 2ac sin φ cos χ = k."""
    a, b, c, x, y = (done.parameters[name] for name in ("crank", "coupler", "rocker", "x", "y"))
    k = b * b - c * c - x * x - y * y - a * a + 2 * a * y * np.cos(φ)
    p, q = 2 * c * x, -2 * a * c * np.sin(φ)
    χ = np.arctan2(p, q) - np.arccos(k / np.hypot(p, q))
    B, C = a * np.array([0.0, np.cos(φ), np.sin(φ)]), np.array([x + c * np.sin(χ), y, c * np.cos(χ)])
    B_dot, C_χ = a * np.array([0.0, -np.sin(φ), np.cos(φ)]), c * np.array([np.cos(χ), 0.0, -np.sin(χ)])
    χ_rate = (C - B) @ B_dot / ((C - B) @ C_χ)
    return χ, B, C, B_dot, C_χ * χ_rate, χ_rate


def spatial_energy(done: Run) -> tuple[Of, Of]:
    """Moment of inertia on the crank, and potential energy, of the crank's angle φ. The idle spin does no work on the
    rest: its energy is constant, and the gyroscopic moment is normal to ω."""
    a, b, c = (done.parameters[name] for name in ("crank", "coupler", "rocker"))
    crank, rod, rocker = done.scene.bodies

    def moment(φ: float) -> float:
        *_, B_dot, C_dot, χ_rate = spatial_pose(done, φ)
        tilting = np.sum((C_dot - B_dot) ** 2) / b**2
        turning = crank.inertia[0][0] + rod.inertia[1][1] * tilting + rocker.inertia[1][1] * χ_rate**2
        moving = rod.mass * np.sum((B_dot + C_dot) ** 2) / 4 + rocker.mass * (c / 2 * χ_rate) ** 2
        return turning + crank.mass * a**2 / 4 + moving

    def potential(φ: float) -> float:
        _, B, C, *_ = spatial_pose(done, φ)
        return 9.81 / 2 * (crank.mass * B[2] + rod.mass * (B[2] + C[2]) + rocker.mass * C[2])

    return moment, potential
