"""Signals and states of a scene: a controlled pendulum in every formulation, and what expressions mean and record."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbproj import Scene, assemble, compile_system, equilibrium, initial_guess, linearize, read_scene_text
from mbproj.equations.instant import of_signals
from tests.elements.scenes import FORMULATIONS, PID, SELDOM_FULL, columns, ran, reference

SATURATED = PID.replace(
    "U: 20*error + 30*integral - 2*filtered", "U: clip(20*error + 30*integral - 2*filtered, -12 V, 12 V)"
)


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_it_moves_as_the_equations_of_the_motor_and_the_controller_say(formulation):
    system, found, _ = ran(PID, formulation=formulation)
    assert np.abs(columns(system, found) - reference()[:, 1:]).max() < 2e-9  # current of 20 A, 12 digits
    assert np.abs(columns(system, found)[:, :2] - reference()[:, 1:3]).max() < 1e-10


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(("formulation", "integrator"), [("full", "radau5"), ("auto", "esdirk4"), ("auto", "auto")])
def test_implicit_steps_take_states_along(formulation, integrator):
    system, found, _ = ran(PID, formulation=formulation, integrator=integrator, tolerance=1e-8)
    assert np.abs(columns(system, found)[:, :2] - reference()[:, 1:3]).max() < 2e-6


@pytest.mark.parametrize("text", [PID, SATURATED], ids=["smooth", "saturated"])
@pytest.mark.parametrize(("integrator", "counts", "order"), [("rk4", (200, 400), 4.0), ("dop853", (50, 100), 7.5)])
def test_the_order_holds(text, integrator, counts, order):
    """Of fixed steps, also where the voltage leaves its bound in one of them."""
    exact, errors = columns(*ran(text, tolerance=1e-13)[:2])[-1, :2], []
    for count in counts:
        system, found, _ = ran(text, integrator=integrator, tolerance=None, step=0.5 / count, output_step=0.5 / count)
        errors.append(np.abs(columns(system, found)[-1, :2] - exact).max())
    assert np.log2(errors[0] / errors[1]) > order
    assert errors[1] < (1e-9 if integrator == "rk4" else 1e-12)


def test_where_a_voltage_begins_or_ends_to_saturate_a_step_ends():
    """Against two smooth integrations of the equations in five unknowns, from one to the other at 12 V."""

    def voltage(y):
        return 20.0 * (1.0 - y[0]) + 30.0 * y[3] - 2.0 * y[4]

    def rates(y, U):
        turning = (2.0 * y[2] - 3.924 * np.sin(y[0])) / 0.18
        return [y[1], turning, (U - 0.8 * y[2] - 2.0 * y[1]) / 2e-3, 1.0 - y[0], (y[1] - y[4]) / 0.01]

    def leaves(t, y):
        return voltage(y) - 12.0

    leaves.terminal = True
    to = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}
    first = solve_ivp(lambda t, y: rates(y, 12.0), (0.0, 0.5), np.zeros(5), events=leaves, **to)
    rest = solve_ivp(lambda t, y: rates(y, voltage(y)), (first.t[-1], 0.5), first.y[:, -1], **to)
    assert 0.01 < first.t[-1] < 0.1
    errors, evaluations = [], []
    for tolerance in (1e-8, 1e-12):
        system, found, report = ran(SATURATED, tolerance=tolerance)
        errors.append(np.abs(columns(system, found)[-1] - rest.y[:, -1]).max())
        evaluations.append(report.counters["evaluations"])
    assert errors[1] < 1e-12
    assert evaluations[1] < 4.0 * evaluations[0]  # order 8: 10,000 times the accuracy for some 3.2 times the steps


def test_it_rests_where_its_states_rest():
    scene = read_scene_text(PID)
    found = equilibrium(scene)
    assert found.coordinates["pin.angle"] == pytest.approx(1.0, abs=1e-12)
    assert found.states["current"] == pytest.approx(1.65096607219, abs=1e-10)
    assert found.states["integral"] == pytest.approx(0.0440257619251, abs=1e-11)


def test_an_integrator_without_a_rest_is_named():
    text = PID.replace("20*error + 30*integral", "20*error").replace("{derivative: error,", "{derivative: error + 1,")
    with pytest.raises(Exception, match="integral"):
        equilibrium(read_scene_text(text))


def test_signals_are_recorded_as_they_are_written():
    system, found, _ = ran(SATURATED, duration=0.1)
    names, values = system.names, found["signals/value"]
    assert (names.signals, names.signal_units) == (("error", "U"), ("rad", "V"))
    assert names.state_units == ("s*rad", "A", "")
    angle, integral, filtered = (columns(system, found)[:, at] for at in (0, 3, 4))
    assert np.allclose(values[:, 0], 1.0 - angle, atol=1e-15)
    assert np.allclose(values[:, 1], np.clip(20 * (1 - angle) + 30 * integral - 2 * filtered, -12, 12), atol=1e-13)
    assert values[0, 1] == 12.0


PLACES = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  bob-1:
    mass: 2 kg
    inertia: [0.1, 0.1, 0.1]
    position: [0.3, 0, -0.4]
    velocity: [0.4, 0, 0.3]
    angular_velocity: [0, -1, 0]
joints:
  pin-1: {type: revolute, bodies: [ground, bob-1], location: [0, 0, 0], axis: [0, -1, 0]}
markers:
  tip: {body: bob-1, location: [0.6, 0, -0.8]}
forces:
  spring-1:
    type: spring_damper
    points: {ground: [1, 0, 0], bob-1: [0.6, 0, -0.8]}
    stiffness: 30
    damping: 2
    free_length: 0.5
  rubber: {type: torsion_maxwell, joint: pin-1, stiffness: 5, damping: 1}
signals:
  what: EXPRESSION
"""
LENGTH = np.hypot(0.4, 0.8)
#: The tip moves with (0.8, 0.6) m/s, the spring's end away from (1, 0).
STRETCH = (-0.4 * 0.8 - 0.8 * 0.6) / LENGTH


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("tip.x - 2*tip.z", 2.2),
        ("tip.x_dot + 10*tip.z_dot", 6.8),
        ("pin_1.angle", 0.0),
        ("2*pin_1.angle_dot", 2.0),
        ("spring_1.length", LENGTH),
        ("spring_1.length_dot", STRETCH),
        ("spring_1.force", -30 * (LENGTH - 0.5) - 2 * STRETCH),
        ("rubber.stretch + t + 4", 4.0),
        ("clip(5 m, -1, 2)", 2.0),
        ("clip(-5*tip.x, -1, 2)", -1.0),
        ("deadband(tip.x, 0.1 m)", 0.5),
        ("deadband(tip.z, 1 m)", 0.0),
        ("table(tip.x, 0, 5, 0.5, 6, 1, 8)", 6.4),
        ("table(-tip.x, 0, 5, 0.5, 6)", 3.8),
        ("table(0.25, 0, 5, 0.5, 6)", 5.5),
    ],
)
def test_expressions_name_places_speeds_lengths_and_forces(expression, value):
    scene = read_scene_text(PLACES.replace("EXPRESSION", expression))
    system = compile_system(scene)
    at = assemble(system, initial_guess(scene, system)).instant(system)
    assert of_signals(at)[..., 0] == pytest.approx(value, abs=1e-12)


def test_a_force_on_a_body_goes_by_a_state_of_the_mechanism():
    text = PLACES.replace("EXPRESSION", "-40 N/m*tip.x").replace(
        "forces:", "forces:\n  pull: {type: force, body: bob-1, force: [what, 0, 0]}"
    )
    named = [columns_of(text, formulation) for formulation in FORMULATIONS]
    spring = "spring_damper, points: {ground: [0, 0, 0], bob-1: [0.6, 0, -0.8]}"
    assert np.isfinite(named[0]).all() and spring
    assert all(np.abs(named[0] - other).max() < 1e-8 for other in named[1:])


def columns_of(text, formulation):
    found = ran(text, duration=0.2, output_step=0.02, tolerance=1e-10, integrator="dop853", formulation=formulation)[1]
    return np.column_stack([found["joints/coordinate"][:, 0], found["signals/value"]])


def test_the_linear_model_of_a_loop_has_its_eigenvalues():
    model = linearize(read_scene_text(PID), at="equilibrium", inputs=["pin.angle"], outputs=["pin.angle"])
    A = np.zeros((5, 5))  # angle, rate, current, integral, filtered
    A[0, 1], A[1, 0], A[1, 2] = 1.0, -3.924 * np.cos(1.0) / 0.18, 2.0 / 0.18
    A[2] = np.array([-20.0, -2.0, -0.8, 30.0, -2.0]) / 2e-3
    A[3, 0], A[4, 1], A[4, 4] = -1.0, 100.0, -100.0
    assert np.allclose(np.sort_complex(np.linalg.eigvals(model.A)), np.sort_complex(np.linalg.eigvals(A)), rtol=1e-9)


WRONG = {
    "a chain": ("U: 20*error", "U: 2*V\n  V: W + 1\n  W: U*t", "U -> V -> W -> U"),
    "a force of itself": ("torque: 2*current", "torque: 2*current + 0.1*motor.force", "motor.force -> motor.force"),
    "a name": ("derivative: error,", "derivative: eror,", "did you mean 'error'"),
    "a coordinate": ("1 rad - pin.angle", "1 rad - pin.angel", "did you mean 'pin.angle'"),
    "an acceleration": ("1 rad - pin.angle", "1 rad - pin.angle_ddot", "algebraic loop"),
    "units": ("1 rad - pin.angle", "1 rad - 2 s + pin.angle", "cannot be added"),
    "units of a state": ("scale: 1 A}", "scale: 1 A, initial: 1 V}", "begins with a voltage"),
    "a unit that is none": ("1 rad - pin.angle", "{value: 1 - pin.angle, unit: volts}", "which is no unit"),
    "a number": ("mass: 1 kg", "mass: error", "changes during a run"),
    "in a mass": ("mass: 1 kg", "mass: 2*pin.angle", "cannot be used here"),
    "a name taken": ("error: 1", "angle: 1", "'angle' is a reserved name"),
    "a hyphen": ("error: 1", "err-or: 1", "cannot name a signal"),
    "rows": ("1 rad - pin.angle", "table(pin.angle, 0, 1, 0, 2)", "x must increase"),
    "a row that varies": ("1 rad - pin.angle", "table(pin.angle, 0, 1, t, 2)", "rows of a 'table' are numbers"),
    "an expectation": (
        "forces:",
        "expect: {a: {signal: V, quantity: value, at: end, value: 1, absolute: 1, source: me}}\nforces:",
        "unknown signal 'V'",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_mistakes_are_told_at_their_line(case):
    before, after, message = WRONG[case]
    assert before in PID
    with pytest.raises(Exception) as caught:
        compile_system(read_scene_text(PID.replace(before, after, 1)))
    told = str(caught.value)
    assert message in told, told


def test_a_driven_angle_is_a_function_of_time_alone():
    text = PLACES.replace("EXPRESSION", "t").replace(
        "forces:", "motions: {drive: {joint: pin-1, angle: 2*pin_1.angle}}\nforces:"
    )
    with pytest.raises(Exception, match="functions of t alone"):
        read_scene_text(text)


def test_what_has_no_unit_is_not_made_larger():
    from mbproj.studies.variants import rescaled

    with pytest.raises(Exception, match="cannot be made larger"):
        rescaled(read_scene_text(PID), 1000.0)


def test_a_scene_built_in_python_has_them():
    scene = read_scene_text(PID)
    built = Scene.build(
        bodies={"rod": {"mass": 1, "inertia": [0.02] * 3, "position": [0, 0, -0.4]}},
        gravity=[0, 0, -9.81],
        joints={"pin": {"type": "revolute", "bodies": ["ground", "rod"], "location": [0, 0, 0], "axis": [0, -1, 0]}},
        signals={"error": "1 rad - pin.angle"},
        states={"integral": {"derivative": "error", "initial": "0 rad*s"}},
    )
    assert (built.signals[0], built.states[0]) == (scene.signals[0], scene.states[0])
