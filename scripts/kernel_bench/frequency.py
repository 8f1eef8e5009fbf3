"""The highest frequency of small oscillations about the start, by power iteration with the kernel's accelerations."""

from __future__ import annotations

import numpy as np
from peers.problem import Array

from mbproj import State
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.formulations.reduced import InPlane

#: Largest displacement, m or rad: the terms of second order and round-off are both small against what is of first.
SMALL = 1e-5
ITERATIONS = 100


def highest_frequency(compiled: Compiled, state: State) -> float:
    """In rad/s, from below, within some per cent. The state is an equilibrium but for its velocities, with every body's
    axes along the global ones; displacements x there have accelerations -M⁻¹K x, M the masses on the closed joints."""
    equations, planar = compiled.equations(), isinstance(compiled, InPlane)
    mass = _masses(compiled)
    rest = compiled.state(state.q, np.zeros_like(state.v))
    direction = np.random.default_rng(1).normal(size=mass.shape[:2])
    found = 0.0
    for _ in range(ITERATIONS):
        placed = equations.corrected(_displaced(rest, direction * (SMALL / np.abs(direction).max()), planar))
        x, direction = _displacement(rest, placed, planar), equations.accelerations(placed)[0]
        found = float(np.sqrt(_norm(direction, mass) / _norm(x, mass)))
    return found


def _displaced(rest: Array, x: Array, planar: bool) -> Array:
    moved = rest.copy()
    if planar:
        moved[:, :3] += x
    else:
        moved[:, :3] += x[:, :3]
        moved[:, 4:7] += 0.5 * x[:, 3:]
    return moved


def _displacement(rest: Array, moved: Array, planar: bool) -> Array:
    if planar:
        return moved[:, :3] - rest[:, :3]
    return np.hstack([moved[:, :3] - rest[:, :3], 2.0 * moved[:, 4:7]])


def _masses(compiled: Compiled) -> Array:
    """The mass matrix of each body, (n, 3, 3) or (n, 6, 6)."""
    shifts = 2 if isinstance(compiled, InPlane) else 3
    inertia = compiled.plane.inertia[:, None, None] if isinstance(compiled, InPlane) else compiled.system.inertia
    mass = np.zeros((compiled.system.bodies, shifts + inertia.shape[1], shifts + inertia.shape[1]))
    mass[:, range(shifts), range(shifts)] = compiled.system.mass[:, None]
    mass[:, shifts:, shifts:] = inertia
    return mass


def _norm(x: Array, mass: Array) -> float:
    return float(np.sqrt(np.einsum("ni,nij,nj->", x, mass, x)))
