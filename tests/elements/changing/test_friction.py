"""Dry friction whose coefficients and forces name signals: sliding, sticking, and where it gives way."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crossed import crossed
from tests.elements.scenes import ran

G = 9.81
SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2 s, output_step: 0.01 s, integrator: dop853, tolerance: 1e-11}
bodies:
  cart: {mass: 2 kg, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0], velocity: [SPEED, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
signals:
  mu: MU
forces:
  brake: {type: friction, joint: rail, coulomb: {FRICTION}}
  push: {type: linear_spring_damper, joint: rail, force: PUSH}
"""


def scene(speed, mu, friction, push):
    return SCENE.replace("SPEED", speed).replace("MU", mu).replace("FRICTION", friction).replace("PUSH", push)


@pytest.mark.full_where(formulation="full")
@crossed("friction, formulation", ["coefficient: mu", "force: mu * 19.62 N"], ["auto", "full"], dear=["full"])
def test_it_slides_stops_sticks_and_breaks_away_as_the_signal_says(friction, formulation):
    """v' = -μ g with μ = 0.4 - 0.2 t from 2 m/s; it rests, and slides again when 2 μ g falls below 1 N: t = 1.7452."""
    text = scene("2", "0.4 - 0.2*t", friction, "-1 N").replace("push:", "push: ")
    _, found, report = ran(text, formulation=formulation, output_step=2 if formulation == "full" else 0.01)
    accelerates = np.poly1d([0.1 * G, -0.4 * G - 0.5, 2.0])  # v: of friction and of the push of -1 N
    rests = float(min(root.real for root in accelerates.roots))
    way = float(np.polyint(accelerates)(rests))
    slips = (0.4 - 1.0 / (2.0 * G)) / 0.2
    v = np.polyint(np.poly1d([-0.2 * G, 0.4 * G - 0.5]))  # goes backwards: friction drives forwards
    end = np.polyint(v - v(slips))
    assert found["joints/coordinate"][-1, 0] == pytest.approx(way + end(2.0) - end(slips), abs=1e-9)
    assert report.energy_drift_relative < 1e-9


def test_fixed_and_implicit_steps_find_the_same():
    text = scene("2", "0.4 - 0.2*t", "coefficient: mu", "-1 N")
    exact = ran(text)[1]["joints/coordinate"][-1, 0]
    for settings in (
        {"integrator": "rk4", "tolerance": None, "step": 0.01},
        {"integrator": "radau5", "tolerance": 1e-9},
    ):
        assert ran(text, **settings)[1]["joints/coordinate"][-1, 0] == pytest.approx(exact, abs=1e-7)


def test_what_holds_is_at_least_what_slides_and_nothing_is_below_0():
    text = scene("1", "0.1 - 0.2*t", "coefficient: mu, static: 0.5*mu", "0 N")
    _, found, _ = ran(text, duration=1)
    assert found["joints/speed"][-1, 0] == pytest.approx(1.0 - G * 0.1 * 0.5 / 2.0, abs=1e-9)


def test_regularised_friction_takes_signals_too():
    text = scene("1", "0.1 + rail.displacement", "coefficient: mu, regularised: 1e-6 m/s", "0 N")
    _, found, _ = ran(text, duration=0.2)
    s, v = found["joints/coordinate"][-1, 0], found["joints/speed"][-1, 0]
    assert 0.5 * v**2 - 0.5 == pytest.approx(-G * (0.1 * s + 0.5 * s**2), abs=1e-9)
