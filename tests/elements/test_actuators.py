"""Servos, motors, hydraulic cylinders and gas springs: against SciPy, closed forms, and in their energy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm

from mbproj import compile_system, equilibrium, modes, read_scene_text
from mbproj.base.errors import InputError
from mbproj.studies.variants import rescaled
from tests.elements.scenes import FORMULATIONS, PID, SELDOM_FULL, ran, reference

WHEEL = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.3, output_step: 0.05, integrator: dop853, tolerance: 1e-11, formulation: auto}
bodies:
  wheel: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  pin-1: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], speed: 2}
forces:
  drive-1: DRIVE
"""
SLIDE = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.3, output_step: 0.05, integrator: dop853, tolerance: 1e-11, formulation: auto}
bodies:
  load: {mass: 200, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, load], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.1}
forces:
  push: PUSH
"""


def end(text, **options):
    """Place, speed and states by name at the end, and what was recorded."""
    system, found, _ = ran(text, **options)
    names = system.names.states
    states = dict(zip(names, found["states/value"][-1], strict=True)) if names else {}
    return found["joints/coordinate"][-1, 0], found["joints/speed"][-1, 0], states, found


def balance(found):
    """How far the energy balance is off, relative to what was put in, or moved."""
    moved = [np.abs(found[f"diagnostics/{name}"]).max() for name in ("work", "kinetic_energy")]
    return np.abs(found["diagnostics/energy_balance"]).max() / max(1.0, *moved)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_servo_without_limits_is_a_spring_and_a_damper(formulation):
    drive = "{type: servo, joint: pin-1, position: 0.4, stiffness: 30, damping: 1.2, motor_constant: 0.5}"
    angle, speed, states, found = end(WHEEL.replace("DRIVE", drive), formulation=formulation)
    A = np.array([[0, 1.0], [-300, -12]])
    expected = expm(0.3 * A) @ [-0.4, 2.0]
    assert [angle - 0.4, speed] == pytest.approx(expected, abs=1e-9)

    def heat(t):
        return (0.1 * (A @ expm(t * A) @ [-0.4, 2.0])[1] / 0.5) ** 2

    assert states["drive-1.heat"] == pytest.approx(quad(heat, 0, 0.3, epsabs=1e-12)[0], rel=1e-9)
    assert balance(found) < 1e-10


def test_a_servo_that_is_saturated_brakes_evenly_and_then_holds():
    drive = "{type: servo, joint: pin-1, speed: -1, damping: 5, max_torque: 2}"
    _, speed, _, found = end(WHEEL.replace("DRIVE", drive))
    until = (2.0 + 1.0 - 0.4) / 20.0  # until 5 (v - s') is as small as the limit
    assert speed == pytest.approx(-1.0 + 0.4 * np.exp(-(0.3 - until) * 50.0), abs=1e-9)
    assert found["joints/speed"][1, 0] == pytest.approx(1.0, abs=1e-11)
    limited = "{type: servo, joint: pin-1, position: 9, stiffness: 60, damping: 6, max_speed: 2}"
    assert end(WHEEL.replace("DRIVE", limited))[1] == pytest.approx(2.0, abs=1e-12)


def test_a_curve_drives_behind_its_gear():
    drive = "{type: speed_torque, joint: pin-1, torque: 2 N*m - 0.05*speed, command: 0.5, gear: 4, friction: 0.3}"
    _, speed, states, found = end(WHEEL.replace("DRIVE", drive))
    free, rate = 4.0, -(0.5 * 0.05 * 16 + 0.3) / 0.1
    rest = -free / 0.1 / rate
    assert speed == pytest.approx(rest + (2.0 - rest) * np.exp(0.3 * rate), abs=1e-9)
    assert states["drive-1.heat"] > 0.0
    assert balance(found) < 1e-10
    by_table = drive.replace("2 N*m - 0.05*speed", "'table(speed, 0, 2, 100, -3)'")
    assert end(WHEEL.replace("DRIVE", by_table))[1] == pytest.approx(speed, abs=1e-10)


@pytest.mark.parametrize("exponent", [1.0, 1.3])
def test_gas_swings_as_its_energy_says(exponent):
    push = f"""
    {{type: pneumatic_spring, joint: rail, area: 50 cm^2, volume: 1000 cm^3, pressure: 6 bar, ambient: 1 bar, at: 0.1 m,
     exponent: {exponent}}}"""

    def pushed(_, y):
        return [y[1], 0.005 * (6e5 * (1e-3 / (1e-3 + 0.005 * (y[0] - 0.1))) ** exponent - 1e5) / 200]

    place, speed, _, found = end(SLIDE.replace("PUSH", push))
    expected = solve_ivp(pushed, (0, 0.3), [0.1, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert [place, speed] == pytest.approx(expected, rel=1e-9)
    assert balance(found) < 1e-10
    assert np.abs(found["diagnostics/work"]).max() < 1e-8  # of 600 J in the gas
    damped = push.replace("at: 0.1 m", "at: 0.1 m, damping: 400 N*s/m")
    *_, found = end(SLIDE.replace("PUSH", damped))
    assert balance(found) < 1e-10 and np.abs(found["diagnostics/work"]).max() < 1e-8
    assert found["diagnostics/dissipation"][-1] > 1.0


CYLINDER = """
    type: hydraulic_cylinder
    joint: rail
    opening: 0.5*sin(30*t)
    supply: 160 bar
    flow: 40 l/min
    drop: 35 bar
    area: 20 cm^2
    rod_side: 12 cm^2
    stroke: 0.5 m
    dead_volume: 100 cm^3
    bulk_modulus: 1.4e9 Pa
    leak: 1e-13 m^3/(s*Pa)
    damping: 2000 N*s/m
    pressure_1: 48 bar
    pressure_2: 80 bar"""


def oil(t, y):
    """Place, speed, pressures of the cylinder."""
    s, v, p1, p2 = y
    u, K, E = 0.5 * np.sin(30 * t), 40e-3 / 60 / 35e5**0.5, 1.4e9

    def q(opening, dp):
        return K * opening * dp / (dp**2 + (1e-3 * 160e5) ** 2) ** 0.25

    q1 = q(max(u, 0), 160e5 - p1) - q(max(-u, 0), p1)
    q2 = q(max(-u, 0), 160e5 - p2) - q(max(u, 0), p2)
    leak = 1e-13 * (p1 - p2)
    V1, V2 = 1e-4 + 20e-4 * s, 1e-4 + 12e-4 * (0.5 - s)
    push = 20e-4 * p1 - 12e-4 * p2 - 2000 * v
    return [v, push / 200, E / V1 * (q1 - leak - 20e-4 * v), E / V2 * (q2 + leak + 12e-4 * v)]


@pytest.fixture(scope="module")
def cylinder_reference():
    start = [0.1, 0.0, 48e5, 80e5]
    knot = np.pi / 30  # where the valve changes over
    parts = [(0.0, knot), (knot, 0.15)]
    for span in parts:
        found = solve_ivp(oil, span, start, method="Radau", rtol=1e-11, atol=[1e-12, 1e-11, 1e-5, 1e-5])
        start = found.y[:, -1]
    return start


@pytest.mark.parametrize("integrator", ["esdirk4", "radau5", "auto"])
def test_a_cylinder_moves_as_another_program_says(cylinder_reference, integrator):
    text = SLIDE.replace("PUSH", CYLINDER)
    place, speed, states, found = end(text, integrator=integrator, tolerance=1e-10, duration=0.15, output_step=0.05)
    found_there = [place, speed, states["push.pressure_1"], states["push.pressure_2"]]
    assert found_there == pytest.approx(cylinder_reference, rel=1e-9, abs=1e-9)
    assert balance(found) < 1e-9


def test_a_pump_puts_in_what_moves_the_load_compresses_oil_and_becomes_heat():
    *_, states, found = end(SLIDE.replace("PUSH", CYLINDER), tolerance=1e-12, duration=0.1, output_step=0.02)
    assert balance(found) < 1e-10
    assert states["push.heat"] > 10.0
    assert found["diagnostics/dissipation"][-1] == pytest.approx(states["push.heat"], rel=1e-12)


def test_a_cylinder_rings_as_its_oil_is_stiff():
    shut = CYLINDER.replace("0.5*sin(30*t)", "0").replace("leak: 1e-13 m^3/(s*Pa)", "leak: 0").replace("2000 N", "0 N")
    found = modes(read_scene_text(SLIDE.replace("PUSH", shut)), at="start")
    stiffness = 1.4e9 * ((20e-4) ** 2 / 3e-4 + (12e-4) ** 2 / 5.8e-4)
    assert np.abs(found.eigenvalues.imag).max() == pytest.approx((stiffness / 200) ** 0.5, rel=1e-9)


def test_heat_does_not_hinder_a_rest():
    """A controlled cylinder that holds a weight leaks, and a motor that holds one warms up; both are at rest."""
    loop = CYLINDER.replace("0.5*sin(30*t)", "4*(0.25 m - rail.displacement)")
    rest = equilibrium(read_scene_text(SLIDE.replace("PUSH", loop).replace("gravity: [0", "gravity: [-9.81")))
    pressures = [rest.states[f"push.pressure_{at}"] for at in (1, 2)]
    assert 20e-4 * pressures[0] - 12e-4 * pressures[1] == pytest.approx(200 * 9.81, rel=1e-9)
    by_states = "  current: {derivative: (U - 0.8*current - 2*pin.angle_dot)/2e-3, scale: 1 A}\n"
    motor = "{type: dc_motor, joint: pin, voltage: U, resistance: 0.8, inductance: 2e-3, constant: 0.04, gear: 50}"
    text = PID.replace(by_states, "").replace("{type: torsion_spring_damper, joint: pin, torque: 2*current}", motor)
    held = equilibrium(read_scene_text(text))
    assert held.states["motor.current"] == pytest.approx(1.65096607219, abs=1e-10)
    assert held.states["integral"] == pytest.approx(0.0440257619251, abs=1e-12)


WRONG = {
    "both": ("DRIVE", "{type: servo, joint: pin-1, position: 1, speed: 1, stiffness: 1, damping: 1}", "cannot both"),
    "neither": ("DRIVE", "{type: servo, joint: pin-1, stiffness: 1, damping: 1}", "missing key"),
    "no stiffness": ("DRIVE", "{type: servo, joint: pin-1, position: 1, damping: 1}", "missing key 'stiffness'"),
    "units": ("DRIVE", "{type: servo, joint: pin-1, speed: 1 m, damping: 1}", "is in rad/s"),
    "a name": ("DRIVE", "{type: speed_torque, joint: pin-1, torque: 2*sped}", "sped"),
    "gas": ("PUSH", "{type: pneumatic_spring, joint: rail, area: 1, volume: 1, pressure: 1}", "missing key 'ambient'"),
    "area": ("PUSH", CYLINDER.replace("20 cm^2", "20 cm"), "is in m^2"),
    "supply": ("PUSH", CYLINDER.replace("160 bar", "0 bar"), "must be greater than 0"),
}


@pytest.mark.parametrize("case", WRONG)
def test_mistakes_are_told(case):
    where, given, message = WRONG[case]
    with pytest.raises(InputError) as caught:
        compile_system(read_scene_text((WHEEL if where == "DRIVE" else SLIDE).replace(where, given)))
    assert message in str(caught.value)


# A motor with a coil: its motion, where its energy goes, and the same motor written with states.

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


def test_mistakes_of_motors_are_told():
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
