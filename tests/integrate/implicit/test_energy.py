"""What a run by implicit steps says of the energy that dampers took, and of vibration that the method damps."""

from __future__ import annotations

import math
from math import pi

import numpy as np
import pytest

from mbproj import Scene, settings_to_run, simulate
from mbproj.motion.steppers.runge_kutta import amplification
from mbproj.motion.steppers.tableau import load_implicit_tableau
from mbproj.scene.scene import read_scene_text
from tests.integrate.stiff_scenes import CREEP
from tests.kernel.scenes import run
from tests.support import assembled

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
    return simulate(*assembled(scene), settings_to_run(scene)).energy


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


def report_of(text, **simulation):
    scene = read_scene_text(text, simulation={"output_step": 0.05, **simulation})
    return simulate(*assembled(scene), settings_to_run(scene))


@pytest.mark.parametrize("formulation", ["full", "reduced", "planar"])
@pytest.mark.parametrize(("integrator", "part"), [("esdirk4", 5e-3), ("radau5", 1e-3)])
def test_the_work_of_a_stiff_force_is_what_the_mass_has(integrator, part, formulation):
    """1e8 N/m turn 1e-8 m by which Newton's method still changes a stage into 1 N. The mass has 0.005 J."""
    found = report_of(CREEP, integrator=integrator, tolerance=2e-5, formulation=formulation)
    assert found.energy.work == pytest.approx(0.5 * (0.1 * math.cos(0.5 - 2e-4)) ** 2, rel=part)
    assert found.energy_drift_relative < part


def test_what_a_damper_takes_is_part_of_what_the_drift_is_held_against():
    """100 J pass through a mass of 0.005 J: 2e-5 J of them are nothing, 2.6 J say that the first step was too long."""
    drag = "damping: 2e4}\n  push: {type: force, body: mass, location: [0, 0, 0], force: [2000, 0, 0]}"
    text = CREEP.replace('force: "1e7*sin(t) - 1e8*displacement - 2e4*displacement_dot"}', drag)
    found = report_of(text, integrator="esdirk4", tolerance=1e-5)
    assert found.energy.dissipation == pytest.approx(100.0, rel=1e-3)
    assert found.energy_drift_relative > 1e-3
    assert not found.drifts
    assert report_of(text.replace("tolerance: 1.0e-6, ", ""), integrator="esdirk4", step=0.05).drifts


# What a run by implicit steps says of vibration that it damps, and of energy that goes with it.

#: 1 kg on a spring of 1e6 N/m that is 1 mm too long: ω = 1000 rad/s.
SLIDER = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {slider: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.3, 0, 0]}}
joints: {guide: {type: prismatic, bodies: [ground, slider], location: [0, 0, 0], axis: [1, 0, 0]}}
forces:
  coil: {type: spring_damper, points: {ground: [0, 0, 0], slider: [0.3, 0, 0]}, stiffness: 1.0e6, free_length: 0.301,
         damping: DAMPING}
"""


def slider(damping: float) -> Scene:
    return read_scene_text(SLIDER.replace("DAMPING", str(damping)))


@pytest.mark.parametrize("integrator", ["esdirk4", "radau5"])
def test_a_vibration_that_is_damped_is_named_with_its_frequency(integrator):
    """ω h = 10 in each of five steps: |R(10 i)| of the amplitude is left after each, and its square of the energy that
    no damper has lost."""
    recorder, report = run(slider(0.0), duration=0.05, step=0.01, integrator=integrator)
    left = amplification(load_implicit_tableau(integrator), 10j)
    assert report.stiffness.startswith(
        f"force 'coil' vibrates with {1000 / (2 * pi):.3g} Hz on the masses that it moves"
    )
    assert f"{integrator} damps that by {100 * (1 - left):.2g} % in a step of 0.01 s (ω h = 10)" in report.stiffness
    assert "steps of 0.0005 s would follow it" in report.stiffness
    energy = recorder["diagnostics/kinetic_energy"] + recorder["diagnostics/potential_energy"]
    np.testing.assert_allclose(energy[1:] / energy[:-1], left**2, rtol=1e-6)
    np.testing.assert_allclose(recorder["diagnostics/energy_balance"], energy - energy[0], atol=1e-12)
    assert not recorder["diagnostics/dissipation"].any()


@pytest.mark.parametrize(("damping", "step"), [(0.0, 0.0005), (1000.0, 0.01)])
def test_what_is_resolved_or_dies_away_by_itself_is_not_named(damping, step):
    _, report = run(slider(damping), duration=5 * step, step=step, integrator="radau5")
    assert report.stiffness == ""
