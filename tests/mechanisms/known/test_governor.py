"""The flyball governor against Lagrange's equation of its arms' angle: where it rests, turns, rings, and its run."""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mbproj.linear import assembled_start, steady_turn
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.modes import modes
from mbproj.model import compile_system
from tests.mechanisms.closed_forms import expected, scene
from tests.mechanisms.running import assert_close

P = scene("governor").parameters
g = 9.81
m, M, J = P["ball"], P["collar"], P["ball"] * 2 / 5 * P["radius"] ** 2
l, a, e, k = P["arm"], P["link"], P["pin"], P["stiffness"]
s = 2 * a * cos(P["start"])
SPINDLE, COLLAR = 0.01, 2.0e-3


def spin_inertia(θ):
    return SPINDLE + COLLAR + 2 * (J + m * (e + l * sin(θ)) ** 2)


def energy(θ):
    """Potential energy of balls, collar and spring."""
    return -2 * (m * l + M * a) * g * cos(θ) + 0.5 * k * (2 * a * cos(θ) - s) ** 2


def closed_form(θ):
    """The speed at which the arms stand at θ."""
    lifted = m * g * l + M * g * a + k * a * (s - 2 * a * cos(θ))
    return sqrt(sin(θ) * lifted / (m * l * (e + l * sin(θ)) * cos(θ)))


def swing_inertia(θ):
    return 2 * (m * l**2 + J) + M * (2 * a * sin(θ)) ** 2


def lagrange(_, state):
    """θ'' where the angular momentum stays, and the power that the damper loses."""
    θ, rate = state[:2]
    Ω = spin_inertia(P["start"]) * P["speed"] / spin_inertia(θ)
    torque = 2 * m * (e + l * sin(θ)) * l * cos(θ) * Ω**2 - 2 * (m * l + M * a) * g * sin(θ)
    torque += k * (2 * a * cos(θ) - s) * 2 * a * sin(θ) - 4 * M * a**2 * sin(θ) * cos(θ) * rate**2
    drag = P["damping"] * (2 * a * sin(θ)) ** 2
    return [rate, (torque - drag * rate) / swing_inertia(θ), drag * rate**2]


def turning(speed):
    read = scene("governor")
    system = compile_system(read)
    start = assembled_start(read, system)
    turn, held = steady_turn(system, start, "spin.angle", speed)
    return equilibrium(system, start, 0.0, turn, held)


@pytest.mark.parametrize("degrees", [17.0, 30.0, 50.0, 75.0])
def test_the_arms_stand_where_the_formula_says(degrees):
    θ = np.radians(degrees)
    found = turning(closed_form(θ))
    coordinates = dict(
        zip(found.reference.system.names.coordinates, found.reference.motion.expected - P["start"], strict=True)
    )
    assert_close([coordinates["right.angle"], coordinates["left.angle"]], θ - 2 * P["start"], 1e-10)
    assert_close(found.drive, 0.0, 1e-10)
    assert found.stable


def test_at_speed_it_swings_against_its_spin():
    """A λ² + C λ + V'' - I'' Ω²/2 + (I' Ω)² / I = 0 where the angular momentum stays (Routh)."""
    θ = np.radians(50.0)
    Ω, I = closed_form(θ), spin_inertia(θ)
    I_1 = 4 * m * (e + l * sin(θ)) * l * cos(θ)
    I_2 = 4 * m * l * (l * cos(θ) ** 2 - (e + l * sin(θ)) * sin(θ))
    V_2 = 2 * (m * l + M * a) * g * cos(θ) + k * ((2 * a * sin(θ)) ** 2 - (2 * a * cos(θ) - s) * 2 * a * cos(θ))
    drag = P["damping"] * (2 * a * sin(θ)) ** 2
    λ = np.roots([swing_inertia(θ), drag, V_2 - 0.5 * I_2 * Ω**2 + (I_1 * Ω) ** 2 / I])
    np.testing.assert_allclose(modes(turning(Ω).reference).eigenvalues, [0.0, λ[λ.imag > 0][0]], rtol=1e-9)


def test_what_its_run_expects():
    L = spin_inertia(P["start"]) * P["speed"]
    θ = brentq(lambda θ: spin_inertia(θ) * closed_form(θ) - L, 0.3, 1.5, xtol=1e-15)
    before, after = (energy(x) + 0.5 * L**2 / spin_inertia(x) for x in (P["start"], θ))
    assert_close(expected("governor", "opens"), θ - P["start"], 1e-10)
    assert_close(expected("governor", "together"), θ - P["start"], 1e-10)
    assert_close(expected("governor", "slows"), closed_form(θ), 1e-9)
    assert_close(expected("governor", "lost"), before - after, 1e-9)
    times = np.arange(601) * 0.01
    done = solve_ivp(lagrange, (0, 6), [P["start"], 0, 0], method="DOP853", rtol=1e-10, atol=1e-12, t_eval=times)
    assert_close(done.y[0, -1], θ, 1e-6)
    assert_close(done.y[2, -1], before - after, 1e-8)
    assert_close(expected("governor", "swings"), done.y[0].max() - P["start"], 1e-9)
