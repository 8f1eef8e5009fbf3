"""A motor with a coil: its motion, where its energy goes, and the same motor written with states."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from mbproj import compile_system, read_scene_text
from mbproj.studies import rescaled
from tests.elements.scenes import PID, SELDOM_FULL, ran, reference

DRIVE = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.2, output_step: 0.01, integrator: dop853, tolerance: 1e-11, formulation: auto}
bodies:
  wheel: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  pin-1: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], speed: 0.5}
forces:
  drive-1:
    type: dc_motor
    joint: pin-1
    voltage: 24 V
    resistance: 0.8 ohm
    inductance: 20 mH
    constant: 0.05
    gear: 30
    friction: 0.02
"""


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_it_turns_and_heats_as_its_equations_say(formulation):
    system, found, _ = ran(DRIVE, formulation=formulation)
    A = np.array([[-0.02 / 0.1, 1.5 / 0.1, 0], [-1.5 / 0.02, -0.8 / 0.02, 24 / 0.02], [0, 0, 0]])
    speed, current, _ = expm(A * 0.2) @ [0.5, 0.0, 1.0]
    states = dict(zip(system.names.states, found["states/value"][-1], strict=True))
    assert found["joints/speed"][-1, 0] == pytest.approx(speed, abs=1e-9)
    assert states["drive-1.current"] == pytest.approx(current, abs=1e-9)
    assert system.names.state_units == ("A", "J")
    assert found["diagnostics/dissipation"][-1] == pytest.approx(states["drive-1.heat"], rel=1e-12)
    assert abs(found["diagnostics/energy_balance"]).max() < 1e-9
    put_in = 0.05 * (speed**2 - 0.25) + 0.01 * current**2 + states["drive-1.heat"]
    assert found["diagnostics/work"][-1] == pytest.approx(put_in, rel=1e-10)


def test_with_a_controller_it_is_the_motor_that_states_make():
    by_states = "  current: {derivative: (U - 0.8*current - 2*pin.angle_dot)/2e-3, scale: 1 A}\n"
    motor = "{type: dc_motor, joint: pin, voltage: U, resistance: 0.8, inductance: 2e-3, constant: 0.04, gear: 50}"
    text = PID.replace(by_states, "").replace("{type: torsion_spring_damper, joint: pin, torque: 2*current}", motor)
    system, found, _ = ran(text)
    assert np.abs(found["joints/coordinate"][:, 0] - reference()[:, 1]).max() < 1e-10
    at = system.names.states.index("motor.current")
    assert np.abs(found["states/value"][:, at] - reference()[:, 3]).max() < 2e-8
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-8


def test_mistakes_are_told():
    for before, after, words in (
        ("voltage: 24 V", "voltage: 24 A", "is in V"),
        ("voltage: 24 V", "voltage: 10*pin_1.angl", "did you mean 'pin_1.angle'"),
        ("inductance: 20 mH", "inductance: 0 H", "must be greater than 0"),
        ("    constant: 0.05\n", "", "missing key 'constant'"),
    ):
        with pytest.raises(Exception) as caught:
            compile_system(read_scene_text(DRIVE.replace(before, after)))
        assert words in str(caught.value)
    with pytest.raises(Exception, match="cannot be made larger"):
        rescaled(read_scene_text(DRIVE), 1000.0)
