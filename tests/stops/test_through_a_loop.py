"""A slider-crank whose slider meets a stop: the impulse goes through the loop, as the equation of one coordinate has
it; and between impacts a method keeps its order."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.stops.runs import run

CRANK, ROD, MASS = 0.1, 0.3, 1.0
INERTIA = {"crank": 1.0e-3, "rod": 7.0e-3}
#: The stop of the slider, from where it is at the crank's angle 0; the start; the part of the speed that comes back.
BOUND, START, SPEED, BACK = -0.02, np.radians(60.0), -5.0, 0.7
TEXT = f"""
mbproj: 1
gravity: [0, 0, 0]
simulation: {{{{duration: 0.5, {{steps}}, formulation: {{formulation}}}}}}
bodies:
  crank: {{{{mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.05, 0, 0]}}}}
  rod: {{{{mass: 1, inertia: [7.0e-3, 7.0e-3, 7.0e-3], position: [0.25, 0, 0]}}}}
  slider: {{{{mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.4, 0, 0]}}}}
joints:
  A:
    type: revolute
    bodies: [ground, crank]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    angle: 60 deg
    speed: {SPEED}
  B: {{{{type: revolute, bodies: [crank, rod], location: [0.1, 0, 0], axis: [0, 0, 1]}}}}
  C: {{{{type: revolute, bodies: [rod, slider], location: [0.4, 0, 0], axis: [0, 0, 1]}}}}
  D:
    type: prismatic
    bodies: [ground, slider]
    location: [0.4, 0, 0]
    axis: [1, 0, 0]
    limits: {{{{displacement: {{{{range: [null, {BOUND}], rigid: true, restitution: {BACK}}}}}}}}}
"""


def slider(θ):
    """Where the slider is, and how far it goes with θ."""
    below = np.sqrt(ROD**2 - (CRANK * np.sin(θ)) ** 2)
    return CRANK * np.cos(θ) + below, -CRANK * np.sin(θ) * (1.0 + CRANK * np.cos(θ) / below)


def inertia(θ):
    """J(θ) of ½ J θ'²: each body by hand."""
    φ = np.arcsin(-CRANK * np.sin(θ) / ROD)
    turn = -CRANK * np.cos(θ) / (ROD * np.cos(φ))
    pin = CRANK * np.array([-np.sin(θ), np.cos(θ)])
    centre = pin + 0.5 * ROD * turn * np.array([-np.sin(φ), np.cos(φ)])
    crank = INERTIA["crank"] + MASS * (0.5 * CRANK) ** 2
    rod = INERTIA["rod"] * turn**2 + MASS * centre @ centre
    return crank + rod + MASS * slider(θ)[1] ** 2


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_the_impulse_is_that_of_one_coordinate(formulation):
    tolerance = "1.0e-11" if formulation != "full" else "1.0e-9"
    steps = f"integrator: dop853, tolerance: {tolerance}, output_step: 0.1"
    _, recorded = run(TEXT.format(steps=steps, formulation=formulation))
    struck = recorded.of("impact")[0]
    at = brentq(lambda θ: slider(θ)[0] - slider(0.0)[0] - BOUND, 0.0, START, xtol=1e-15)
    speed = SPEED * np.sqrt(inertia(START) / inertia(at))
    approach = slider(at)[1] * speed
    assert struck.impulse == pytest.approx((1.0 + BACK) * inertia(at) * speed / slider(at)[1], rel=1e-8)
    assert struck.energy == pytest.approx(0.5 * inertia(at) * speed**2 * (1.0 - BACK**2), rel=1e-8)
    assert approach > 0.0
    assert recorded["joints/violation"].max() < 2e-13


def test_between_impacts_a_method_keeps_its_order():
    """Fixed steps of RK4 through several impacts: half the step, a sixteenth of the error."""

    def end(step):
        text = TEXT.replace("duration: 0.5", "duration: 2")
        _, recorded = run(text.format(steps=f"integrator: rk4, step: {step}, output_step: 2", formulation="planar"))
        assert len(recorded.of("impact")) >= 2
        return recorded["bodies/position"][-1]

    exact = end(2.5e-4)
    coarse, fine = (np.abs(end(step) - exact).max() for step in (4e-3, 2e-3))
    assert 3.5 < np.log2(coarse / fine) < 4.8
