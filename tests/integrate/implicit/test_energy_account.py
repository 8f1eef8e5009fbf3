"""A run says what dampers took of the energy, and apart from it what its method took."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, settings_to_run, simulate
from mbproj.integrate.steppers.implicit_tableau import load_implicit_tableau
from mbproj.scene import read_scene_text

OMEGA, MASS, START, STEP, STEPS = 100.0, 2.0, 0.01, 0.05, 6
STIFFNESS = MASS * OMEGA**2
ENERGY = 0.5 * STIFFNESS * START**2
OSCILLATOR = f"""
mbproj: 1
gravity: [0, 0, 0]
bodies:
  mass: {{mass: {MASS}, inertia: [0.1, 0.1, 0.1], position: [{START}, 0, 0]}}
joints:
  rail: {{type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0], displacement: {START}}}
forces:
  spring: {{type: linear_spring_damper, joint: rail, stiffness: {STIFFNESS}, damping: DAMPING}}
"""


def account(damping=0.0, **simulation):
    scene = read_scene_text(OSCILLATOR.replace("DAMPING", repr(damping)), simulation=simulation)
    system = compile_system(scene)
    return simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene)).energy


@pytest.mark.parametrize("formulation", ["full", "reduced", "planar"])
@pytest.mark.parametrize("integrator", ["esdirk4", "radau5"])
def test_an_implicit_method_damps_as_its_stability_function_says(integrator, formulation):
    """Of x'' = -ω² x a step leaves |R(iωh)|² of the energy; here ωh = 5."""
    tableau = load_implicit_tableau(integrator)
    z, stages = 1j * OMEGA * STEP, len(tableau.b)
    R = 1.0 + z * tableau.b @ np.linalg.solve(np.eye(stages) - z * tableau.a, np.ones(stages))
    assert abs(R) < 0.98
    found = account(integrator=integrator, step=STEP, duration=STEPS * STEP, formulation=formulation)
    assert found.numerical == pytest.approx(ENERGY * (abs(R) ** (2 * STEPS) - 1.0), rel=1e-9)
    assert (found.work, found.dissipation) == (0.0, 0.0)


def test_a_damper_takes_what_the_oscillator_loses():
    ζ, until = 0.1, 0.1
    found = account(2.0 * ζ * MASS * OMEGA, integrator="dop853", tolerance=1e-12, duration=until)
    ω = OMEGA * math.sqrt(1.0 - ζ**2)
    decay, tilt = math.exp(-ζ * OMEGA * until), ζ * OMEGA / ω
    x = START * decay * (math.cos(ω * until) + tilt * math.sin(ω * until))
    v = -START * decay * (OMEGA**2 / ω) * math.sin(ω * until)
    left = 0.5 * STIFFNESS * x**2 + 0.5 * MASS * v**2
    assert found.dissipation == pytest.approx(ENERGY - left, rel=1e-8)
    assert abs(found.numerical) < 1e-8 * ENERGY
