"""Springs whose numbers name signals: their motion, their energy, their rest and their linear model."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbproj import equilibrium, export_model, modes, read_scene_text
from tests.crossed import full
from tests.elements.scenes import ran

ON_RAIL = "type: linear_spring_damper, joint: rail"
BETWEEN = "type: spring_damper, points: {ground: [-1, 0, 0], cart: [0, 0, 0]}"
SCENE = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, output_step: 0.1 s, integrator: dop853, tolerance: 1e-12}
bodies:
  cart: {mass: 2 kg, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0], velocity: [1, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
signals:
  k: 50*(1 + 0.5*sin(3*t))
  c: 2 + rail.displacement**2
  push: spring.force
forces:
  spring: {WHERE, stiffness: k, damping: c, FREE}
"""


def force(t, s, v):
    return -50.0 * (1.0 + 0.5 * np.sin(3.0 * t)) * (s - 0.1 * np.sin(t)) - (2.0 + s * s) * v


@pytest.mark.parametrize(
    ("where", "free", "formulation"),
    [
        full(ON_RAIL, "free_displacement: 0.1*sin(t)", "full"),
        (ON_RAIL, "free_displacement: 0.1*sin(t)", "auto"),
        (BETWEEN, "free_length: 1 m + 0.1*sin(t)", "auto"),
    ],
)
def test_it_pulls_as_its_numbers_are_then(where, free, formulation):
    """Against an integration of the two unknowns; the energy is that of what is put in and lost."""
    system, found, report = ran(SCENE.replace("WHERE", where).replace("FREE", free), formulation=formulation)
    to = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    exact = solve_ivp(lambda t, y: [y[1], force(t, *y) / 2.0], (0.0, 1.0), [0.0, 1.0], t_eval=found["time"], **to).y
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], exact[0], atol=1e-12)
    assert np.allclose(found["signals/value"][:, 2], force(found["time"], *exact), atol=1e-10)
    assert np.allclose(found["forces/force"][:, 0], found["signals/value"][:, 2], atol=1e-13)
    assert report.energy_drift_relative < 1e-10
    assert found["states/value"][-1, system.names.states.index("spring.heat")] > 0.2


def test_what_a_stiffness_that_grows_puts_in_is_the_energy_that_the_spring_gains():
    """A weightless load's spring is stretched and stands: k s²/2 grows by the work done."""
    text = SCENE.replace("WHERE", ON_RAIL).replace(", damping: c, FREE", ", free_displacement: 0.2")
    text = text.replace(", velocity: [1, 0, 0]", "").replace("mass: 2 kg", "mass: 1e9 kg")
    _, found, report = ran(text.replace("k: 50*(1 + 0.5*sin(3*t))", "k: 50*(1 + t)"), duration=1)
    work = found["diagnostics/work"][-1]
    assert work == pytest.approx(0.5 * 50.0 * 0.2**2, rel=1e-6)
    assert report.energy_drift_relative < 1e-9


def test_a_free_length_that_is_not_given_is_that_of_the_pose():
    text = SCENE.replace("WHERE", BETWEEN).replace(", FREE", "").replace(", velocity: [1, 0, 0]", "")
    _, found, _ = ran(text, duration=0.1)
    assert np.abs(found["joints/coordinate"][:, 0]).max() < 1e-14


@pytest.mark.parametrize("integrator", ["radau5", "esdirk4", "auto"])
def test_implicit_steps_know_its_slope(integrator):
    text = SCENE.replace("WHERE", ON_RAIL).replace("FREE", "free_displacement: 0")
    stiff = text.replace("k: 50*", "k: 5e6*").replace("c: 2 ", "c: 5e4 ")
    _, found, report = ran(stiff, integrator=integrator, tolerance=1e-7)
    exact = ran(stiff, integrator="dop853", tolerance=1e-10)[1]
    assert np.abs(found["joints/coordinate"] - exact["joints/coordinate"]).max() < 1e-6
    assert report.counters["evaluations"] < 5000


def test_rest_and_modes_go_by_what_the_signal_is_there():
    """k = 40 + 100 s and a push of 10 N: 100 s² + 40 s = 10, and dF/ds = -(40 + 200 s)."""
    text = SCENE.replace("WHERE", ON_RAIL).replace("damping: c, FREE", "free_displacement: 0")
    text = text.replace("50*(1 + 0.5*sin(3*t))", "40 + 100*rail.displacement").replace(", velocity: [1, 0, 0]", "")
    text += "  load: {type: force, body: cart, force: [10 N, 0, 0]}\n"
    scene = read_scene_text(text)
    s = (-40.0 + np.sqrt(40.0**2 + 4000.0)) / 200.0
    rest = equilibrium(scene)
    assert rest.coordinates["rail.displacement"] == pytest.approx(s, abs=1e-12)
    found = modes(scene, at="equilibrium")
    assert max(abs(found.eigenvalues)) == pytest.approx(np.sqrt((40.0 + 200.0 * s) / 2.0), rel=1e-9)


def test_an_export_says_that_its_numbers_change():
    text = SCENE.replace("WHERE", ON_RAIL).replace("damping: c, FREE", "free_displacement: 0")
    table = export_model(read_scene_text(text), "mjcf").table
    said = dict(zip(table["element"], table["what"], strict=True))
    assert said["force 'spring'"] == "left out: numbers of it change in a run"
