"""A pendulum with friction in its pivot: amplitudes by energy, states by SciPy, and the orders of methods from turn to
turn."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crossed import crossed
from tests.friction import mechanisms
from tests.friction.mechanisms import STEPS
from tests.stops.runs import run

START, TORQUE, ARM = 1.2, 0.8, 0.08


def ends(recorded):
    return np.array([recorded["joints/coordinate"][-1, 0], recorded["joints/speed"][-1, 0]])


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_it_swings_lower_each_time_and_stays_where_it_is_held(formulation):
    """Each swing loses torque × way; it rests where m g l sin θ is below the torque."""
    amplitudes = [START]
    held = np.arcsin(TORQUE / (mechanisms.MASS * mechanisms.G * mechanisms.LENGTH))
    while amplitudes[-1] > held:
        amplitudes.append(mechanisms.next_amplitude(amplitudes[-1], TORQUE))
    text = mechanisms.pendulum(f"{{torque: {TORQUE}}}", duration=8.0, formulation=formulation)
    _, recorded = run(text)
    side = (-1) ** (len(amplitudes) - 1)
    assert len(amplitudes) > 4
    assert ends(recorded) == pytest.approx([side * amplitudes[-1], 0.0], abs=1e-9)
    hanging = mechanisms.MASS * mechanisms.G * mechanisms.LENGTH * np.sin(side * amplitudes[-1])
    assert recorded["friction/force"][-1, 0] == pytest.approx(hanging, rel=1e-8)
    way = amplitudes[0] + 2.0 * sum(amplitudes[1:-1]) + amplitudes[-1]
    assert recorded["friction/dissipation"][-1, 0] == pytest.approx(TORQUE * way, rel=1e-8)
    assert np.diff(recorded["diagnostics/total_energy"]).max() < 1e-9
    assert recorded.unbalanced < 1e-7


@crossed("formulation, steps", ["planar", "reduced"], STEPS, together=1)
def test_the_force_in_the_pivot_makes_the_friction(formulation, steps):
    """Friction arm |F|, where F has the acceleration in it that friction changes: through two turns."""
    state, turns = mechanisms.swing(mechanisms.by_the_force(ARM), START, 0.0, 2.2)
    assert len(turns) == 2
    text = mechanisms.pendulum(
        f"{{coefficient: {ARM / 0.2}, radius: 0.2}}", duration=2.2, steps=steps, formulation=formulation
    )
    _, recorded = run(text)
    assert ends(recorded) == pytest.approx(state, abs=1e-8 if steps != "rk4" else 1e-7)


@crossed(
    "integrator, order, step, law",
    [pytest.param("rk4", 4, 0.04), pytest.param("dopri5", 5, 0.055), pytest.param("dop853", 8, 0.11)],
    ["constant", "by the force"],
    together=1,
)
def test_methods_keep_their_order_from_turn_to_turn(integrator, order, step, law):
    """Fixed steps that end at the turns: half the step, 2^-order of the error."""
    coulomb = f"{{torque: {TORQUE}}}" if law == "constant" else f"{{coefficient: {ARM / 0.2}, radius: 0.2}}"
    acceleration = mechanisms.constant(TORQUE) if law == "constant" else mechanisms.by_the_force(ARM)
    state, turns = mechanisms.swing(acceleration, START, 0.0, 2.2)
    assert len(turns) == 2
    errors = []
    for size in (step, 0.5 * step, 0.25 * step):
        steps = f"integrator: {integrator}, step: {size}, output_step: 2.2"
        _, recorded = run(mechanisms.pendulum(coulomb, duration=2.2, steps=steps))
        errors.append(np.abs(ends(recorded) - state).max())
    orders = -np.diff(np.log2(errors))
    assert orders.max() < order + 1.5
    assert orders.mean() > order - 0.5
