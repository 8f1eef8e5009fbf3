"""Dry friction beside motions, which pay for it, and beside stops, which strike what it brakes."""

from __future__ import annotations

import numpy as np
import pytest

from tests.friction import closed_forms as exact
from tests.friction.mechanisms import incline, rotor
from tests.stops.runs import run

J = 0.5
DRIVEN = """
motions:
  drive: {{joint: hinge, angle: {angle}}}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_motion_pays_for_the_friction_of_its_own_joint(formulation):
    """Driven to and fro: its torque is J θ'' and the brake's 4 N m against the rate, its work 4 N m times the way."""
    text = rotor("{torque: 4}", speed=1.0, duration=3.0, formulation=formulation) + DRIVEN.format(angle="sin(t)")
    _, recorded = run(text)
    t = recorded["time"]
    turns = np.abs(t - 0.5 * np.pi) > 1e-9
    assert recorded["friction/force"][turns, 0] == pytest.approx(-4.0 * np.sign(np.cos(t[turns])), abs=1e-9)
    way = np.where(t < 0.5 * np.pi, np.sin(t), 2.0 - np.sin(t))
    assert recorded["friction/dissipation"][:, 0] == pytest.approx(4.0 * way, abs=1e-8)
    kinetic = 0.5 * J * (np.cos(t) ** 2 - 1.0)
    assert recorded["diagnostics/work"] == pytest.approx(4.0 * way + kinetic, abs=1e-8)
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_motion_that_rests_holds_with_its_brake(formulation):
    """From 1 s on the motion stands still: nothing moves, and what brake and motion bear together is the load."""
    text = rotor("{torque: 4}", speed=0.0, load="3", duration=2.0, formulation=formulation)
    _, recorded = run(text + DRIVEN.format(angle="{smooth_step: {to: 1, duration: 1}}"))
    resting = recorded["time"] > 1.0
    assert recorded["joints/coordinate"][resting, 0] == pytest.approx(1.0, abs=1e-12)
    assert (np.abs(recorded["friction/force"][resting, 0]) <= 4.0 + 1e-9).all()
    assert recorded["friction/dissipation"][-1, 0] == pytest.approx(4.0, rel=1e-8)


@pytest.mark.parametrize("steps", ["dop853", "rk4"])
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_braked_rotor_strikes_a_wall_and_comes_to_rest_on_its_way_back(formulation, steps):
    """ω² falls by 2 torque/J for each radian; the wall at 20 rad gives back half of the speed."""
    text = rotor("{torque: 10}", steps=steps, formulation=formulation)
    text = text.replace(
        "axis: [0, 0, 1], ", "axis: [0, 0, 1], limits: {angle: {range: [null, 20], rigid: true, restitution: 0.5}}, "
    )
    _, recorded = run(text)
    struck = np.sqrt(30.0**2 - 2.0 * 20.0 * 20.0)
    first = (30.0 - struck) / 20.0
    time, way = exact.brake_stops(J, 0.5 * struck, 10.0)
    (hit,) = recorded.of("impact")
    assert hit.time == pytest.approx(first, abs=1e-9)
    assert hit.impulse == pytest.approx(1.5 * J * struck, rel=1e-9)
    (sticks,) = recorded.of("stick")
    assert sticks.time == pytest.approx(first + time, abs=1e-9)
    assert recorded["joints/coordinate"][-1, 0] == pytest.approx(20.0 - way, abs=1e-9)
    assert recorded.unbalanced < 1e-8


def test_a_block_slides_down_to_a_wall_and_rests_there():
    """tan 0.5 is above the static coefficient: what friction does not hold, the wall does."""
    text = incline("0.5", "{coefficient: 0.3, static: 0.4}", duration=1.5)
    text = text.replace("speed: 0.0", "speed: 0, limits: {displacement: {range: [-1, null], rigid: true}}")
    _, recorded = run(text)
    a = exact.down_an_incline(0.5, 0.3, 9.81)
    (hit,) = recorded.of("impact")
    assert hit.time == pytest.approx(np.sqrt(2.0 / a), abs=1e-9)
    assert hit.energy == pytest.approx(3.0 * a, rel=1e-9)
    assert recorded["joints/coordinate"][-1, 1] == pytest.approx(-1.0, abs=1e-10)
    together = recorded["friction/force"][-1, 0] + recorded["stops/force"][-1, 0]
    assert together == pytest.approx(3.0 * 9.81 * np.sin(0.5), rel=1e-9)
    assert abs(recorded["friction/force"][-1, 0]) <= 0.4 * 3.0 * 9.81 * np.cos(0.5) + 1e-9
    assert recorded.unbalanced < 1e-8
