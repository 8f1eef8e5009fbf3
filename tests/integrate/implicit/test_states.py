"""Implicit steps with states of elements, which are eliminated in each stage: stiff ones at the step of the mechanism,
their orders, their errors, and who is blamed where a stage is not solved."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.errors import SimulationError
from mbproj.registry import implicit_integrators, integrators
from tests.model.element_scenes import FORMULATIONS, PENDULUM
from tests.model.element_scenes import run as run_scene

both = pytest.mark.parametrize("integrator", implicit_integrators())
each = pytest.mark.parametrize("formulation", FORMULATIONS)
#: How fast a state follows the cosine that it is led by, 1/s.
FAST = 1e6
FOLLOWS = f"-{FAST}*(x - cos(t))"
#: Van der Pol's oscillator with ε = 1e-6 from (2, -0.66), at t = 2 s (Hairer & Wanner's test set).
VAN_DER_POL = ("z", "((1 - x**2)*z - x)/1e-6")
AT_TWO = (1.706167732170483, -0.8928097010247975)


def run(options, **own):
    """(report, recorder, marks)."""
    return run_scene(options, text=PENDULUM.replace("output_step: 0.05", "output_step: 0.2"), **own)


def following(t):
    """What x' = FAST (cos t - x) settles to."""
    return (FAST / (FAST + 1j) * np.exp(1j * t)).real


def fixed(formulation, integrator, step):
    return {"formulation": formulation, "integrator": integrator, "step": repr(step)}


def by_error(formulation, integrator, tolerance):
    return {"formulation": formulation, "integrator": integrator, "tolerance": repr(tolerance)}


@both
@each
def test_a_stiff_state_is_followed_at_the_step_of_the_mechanism(formulation, integrator):
    """At hλ = 1e5 the order is that of a stage, 2 or 3, of errors that are small; Newton's method takes no more passes
    than with states that do nothing, but for coupled stages that are solved one after another."""
    errors, start = [], (following(0.0), 0.0)
    for step in (0.1, 0.05):
        report, found, _ = run(fixed(formulation, integrator, step), texts=(FOLLOWS, "0*x"), start=start)
        errors.append(np.abs(found["states/value"][:, 0] - following(found["time"])).max())
        calm, _, _ = run(fixed(formulation, integrator, step), texts=("0*x", "0*x"))
        apart = integrator == "radau5"
        assert report.counters["evaluations"] <= (2.2 if apart else 1.0) * calm.counters["evaluations"]
    assert errors[0] < 1e-9
    assert np.log2(errors[0] / errors[1]) > (2.9 if integrator == "radau5" else 1.9)


@both
@each
def test_a_transient_does_not_hold_the_steps(formulation, integrator):
    """From 0 the state jumps to what leads it within some microseconds."""
    report, found, _ = run(by_error(formulation, integrator, 1e-6), texts=(FOLLOWS, "0*x"))
    assert np.abs(found["states/value"][1:, 0] - following(found["time"][1:])).max() < 1e-5
    assert report.counters["steps"] < 120


#: In NumPy a run takes seconds: with one method.
ALL = [
    (each, method)
    for each in FORMULATIONS
    for method in implicit_integrators()
    if (each, method) != ("full", "esdirk4")
]


@pytest.mark.parametrize(("formulation", "integrator"), ALL)
def test_van_der_pol(formulation, integrator):
    options = by_error(formulation, integrator, 1e-5)
    report, found, _ = run(options, until=2.0, texts=VAN_DER_POL, start=(2.0, -0.66))
    np.testing.assert_allclose(found["states/value"][-1], AT_TWO, rtol=1e-4)
    assert report.counters["steps"] < 500


@both
@each
def test_their_orders(formulation, integrator):
    """x' = x (z - x), z' = -z²: z = 2/(1 + 2t), and x of the linear equation of 1/x."""
    steps, errors = (0.2, 0.1, 0.05), []
    for step in steps:
        _, found, _ = run(fixed(formulation, integrator, step), texts=("x*(z - x)", "-z**2"), start=(0.5, 2.0))
        t = found["time"]
        # u = 1/x: u' = 1 - z u, so u (1 + 2t) = 2 + t + t²
        exact = np.stack([(1.0 + 2.0 * t) / (2.0 + t + t**2), 2.0 / (1.0 + 2.0 * t)], axis=1)
        errors.append(np.abs(found["states/value"][-1] - exact[-1]).max())
    assert np.log2(errors[0] / errors[-1]) / 2 > integrators()[integrator].order - 0.4


@both
@each
def test_a_stage_without_a_solution_names_its_state(formulation, integrator):
    """Where the rate jumps, no x of a stage agrees with its own rate."""
    options = fixed(formulation, integrator, 0.1)
    with pytest.raises(SimulationError, match=r"state 'lag\.x'.*Newton's method"):
        run(options, texts=("-1e9*sign(x - 0.01)", "0*x"), start=(0.05, 0.0))
