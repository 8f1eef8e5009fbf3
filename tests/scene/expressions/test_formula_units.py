"""The units of formulas: what fits is read, what does not is an error with the unit found and the unit wanted."""

from __future__ import annotations

import pytest

from mbproj.base.errors import InputError
from mbproj.scene.scene import SceneText, read_scene_text

SCENE = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1, step: 1}
parameters: {k: 300 N/m, M: 12 N*m, F: 7 N, c: 2 N*s/m, L: 0.4 m, w: 5 rad/s, T: 3 s, v: 0.2 m/s, n: 4, K: 0.03 N*m/V}
bodies:
  cart: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  arm: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  rail-1: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: x}
  pin: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: y}
markers: {tip: {body: arm, location: [1, 0, 0]}}
signals:
  error: 1 rad - pin.angle
  U: {value: 24*error, unit: V}
states:
  current: {derivative: (3*U - current)/0.2, initial: 0 A}
  sum: {derivative: error}
controllers:
  pd: {period: 0.1, hold: {u: {value: 3*error, initial: 0 N*m}, x: 2*error}}
forces:
  pull: {type: linear_spring_damper, joint: rail-1, stiffness: 1}
  twist: {type: torsion_spring_damper, joint: pin, stiffness: 1}
  motor: {type: dc_motor, joint: pin, voltage: U, resistance: 1, inductance: 1, constant: 1}
"""
#: Formulas of a force in N along a displacement.
FITS = [
    "-k*displacement - c*displacement_dot",
    "-k*max(0, displacement - 0.2)",
    "k*(L*sin(w*t) - displacement)",
    "k*displacement/2 - 3*displacement_dot",
    "-c*displacement_dot - 20*displacement",
    "2*k*L*t/T",
    "0.5*(3 kg)*v**2/L",
    "F*0.3*t",
    "sin(t)/rail_1.displacement - rail_1.displacement_dot",
    "F*sin(2*pi*t/T)",
    "F*exp(-3*t/T)*cos(w*t + 2*pi*t/T)",
    "F*2**(3*t/T)",
    "F*min(1, 3*t/T)",
    "k*(displacement - 0.05*sin(2*pi*t/T))",
    "k*displacement*(1 + displacement/L)",
    "clip(-k*displacement, -50, 50)",
    "table(displacement, 0 mm, 0 N, 100 mm, 50 N)",
    "F*clip(displacement_dot/0.01, -1, 1)",
    "(3 W)/max(displacement_dot, 0.1)",
    "k*(0.1*pin.angle*(1 m) - displacement)",
    "F*tip.x/hypot(tip.x, tip.z)",
    "F*(1 - t/2)",
    "F*max(0, min(1, (2.5 - t)/0.2))",
    "F*max(0, min(1, (2.5 s - t)/0.2))",
    "F*exp(-t/T)*sin(3*t) + F*cos(t)",
    "F*2**(-t) + F*2**(t/T)",
    "20*error + 30*sum - 2*pin.angle_dot",
    "n*displacement",
    "-(displacement + 0.1)",
    "clip(20*error, -12, 12)",
    "clip(20*error, -12 N, 12 N)",
    "table(t, 0, 0, 1, 5)",
    "K*clip(20*error, -12, 12)/L",
    "K*table(rail_1.displacement, 0, 0, 1, 24)/L",
    "5*tanh(100*displacement_dot)",
    "-5*tanh(displacement_dot)",
    "n*sin(displacement) + pin.angle",
    "M*pin.angle/L",
    "M*tip.x/L**2",
    "pull.force + K*U/L + pd.u/L",
    "hypot(F, 3*displacement)",
    "4*current",
    "pd.x",
    "0.1*t",
    "t",
    "3",
]
#: Formulas that are in another unit, and what the message says.
MISFITS = {
    "M*max(0, min(1, (2.5 - t)/0.2))": "'force' is in N, this is a torque, in N*m",
    "2*M*sin(3*t)": "'force' is in N, this is a torque, in N*m",
    "k": "'force' is in N, this is a stiffness, in N/m",
    "-k*displacement_dot": "'force' is in N, this is in m*kg/s^3",
    "c*t": "'force' is in N, this is a mass, in kg",
    "F*t": "'force' is in N, this is in m*kg/s",
    "pin.angle": "'force' is in N, this is an angle, in rad",
    "-rail_1.displacement_dot": "'force' is in N, this is a velocity, in m/s",
    "tip.x_dot": "'force' is in N, this is a velocity, in m/s",
    "twist.force": "'force' is in N, this is a torque, in N*m",
    "U": "'force' is in N, this is a voltage, in V",
    "K*U": "'force' is in N, this is a torque, in N*m",
    "current": "'force' is in N, this is a current, in A",
    "motor.current": "'force' is in N, this is a current, in A",
    "pd.u": "'force' is in N, this is a torque, in N*m",
    "clip(20*error, -12 V, 12 V)": "'force' is in N, this is a voltage, in V",
    "sqrt(F*M)": "'force' is in N, this is in m^1.5*kg/s^2",
    "F**2": "'force' is in N, this is in m^2*kg^2/s^4",
    "F + M": "a force and a torque cannot be added or compared",
    "max(F, M)": "a force and a torque cannot be added or compared",
    "k*(displacement - pin.angle)": "a length and an angle cannot be added or compared",
    "-k*displacement - c*displacement": "a force and in m*kg/s cannot be added or compared",
    "F*atan2(L, T)": "a length and a time cannot be added or compared",
    "F*sin(c*t)": "'sin' cannot take a mass",
    "F*sin(displacement)": "'sin' cannot take a length",
    "F*exp(pin.angle_dot)": "'exp' cannot take an angular velocity",
    "F*2**displacement": "an exponent has no unit, this is a length, in m",
    "(2 kg)*9.81*sin(pin.angle)": "'force' is in N, this is a mass, in kg",
    "displacement mm": "'mm' stands after what has a unit already",
}


def problems(text: str) -> list[str]:
    try:
        read_scene_text(text, "f")
    except InputError as error:
        return [problem.message for problem in error.problems]
    return []


def with_force(formula: str) -> str:
    return f'{SCENE}  x: {{type: linear_spring_damper, joint: rail-1, force: "{formula}"}}\n'


@pytest.mark.parametrize("formula", FITS)
def test_a_formula_that_may_be_in_the_wanted_unit_is_read(formula: str) -> None:
    assert problems(with_force(formula)) == []


@pytest.mark.parametrize("formula", MISFITS)
def test_a_formula_in_another_unit_is_an_error_with_both(formula: str) -> None:
    assert problems(with_force(formula)) == [MISFITS[formula]]


def test_the_error_is_at_the_formula() -> None:
    with pytest.raises(InputError) as raised:
        read_scene_text(with_force("L*k*t"), "f")
    (problem,) = raised.value.problems
    assert str(problem).splitlines()[0] == "f:24:57: error: 'force' is in N, this is in m*kg/s"


def test_a_number_without_unit_beside_a_quantity_gets_a_hint() -> None:
    with pytest.raises(InputError, match="a number without unit is a pure number beside these: give it its unit"):
        read_scene_text(with_force("(3 kg)*9.81*cos(pin.angle)"), "f")


#: A block with a formula that does not fit, by the field that has it.
FIELDS = {
    "a force's component": "  x: {type: force, body: cart, force: [0, M*sin(t), 0]}",
    "a torque's component": "  x: {type: torque, body: cart, torque: [0, 0, 2*F]}",
    "a stiffness that changes": "  x: {type: torsion_spring_damper, joint: pin, stiffness: F*(1 + sin(t))}",
    "a free length that changes": "  x: {type: spring_damper, points: {ground: [0, 0, 1], arm: [0, 0, 0]}, "
    "stiffness: 1, free_length: F*sin(t)}",
    "friction": "  x: {type: friction, joint: pin, coulomb: {torque: F*(1 + sin(t))}}",
    "a voltage": "  x: {type: dc_motor, joint: pin, voltage: M*sin(t), resistance: 1, inductance: 1, constant: 1}",
    "a speed": "  x: {type: servo, joint: pin, speed: v*sin(t), damping: 1}",
    "a command": "  x: {type: speed_torque, joint: pin, torque: 1 N*m, command: F*sin(t)}",
    "a curve of the speed": "  x: {type: speed_torque, joint: pin, torque: K*speed}",
    "a motion": "motions:\n  x: {joint: pin, angle: L*sin(t)}",
    "a motion's expression": "motions:\n  x: {joint: rail-1, displacement: {expression: v*sin(w*t)}}",
}


@pytest.mark.parametrize("field", FIELDS)
def test_every_field_of_formulas_is_checked(field: str) -> None:
    (message,) = problems(SCENE + FIELDS[field] + "\n")
    assert ", this is " in message


def test_a_signal_with_a_declared_unit_has_it() -> None:
    wrong = SCENE.replace("U: {value: 24*error, unit: V}", "U: {value: F*sin(t), unit: V}")
    assert problems(wrong) == ["'U' is in V, and its expression is a force, in N"]


def test_a_unit_that_changes_is_checked_again() -> None:
    text = SceneText(with_force("K*U/L"), "f")
    text.scene()
    text.scene()
    with pytest.raises(InputError, match="'force' is in N"):
        text.scene({"signals.U.unit": "A"})
    text.scene()


def test_the_states_of_elements_have_their_units() -> None:
    """Those that types of force declare for the check are those that their elements have."""
    from mbproj.scene.blocks.elements import ELEMENTS

    given = {"voltage": "0", "opening": "0", "position": "0", "torque": "0"}
    for name, kind in ELEMENTS.builtin.items():
        keys = {**dict.fromkeys(kind.required, "1"), "motor_constant": "1", "damping": "1", "stiffness": "1"}
        keys = {key: given.get(key, each) for key, each in keys.items() if key in kind.keys}
        keys |= {"position": "0"} if "position" in kind.keys else {}
        joint = "pin" if kind.along == "rad" else "rail-1"
        block = ", ".join(f"{key}: {each}" for key, each in keys.items())
        scene = read_scene_text(f"{SCENE}  x: {{type: {name}, joint: {joint}, {block}}}\n", "f")
        force = next(each for each in scene.forces if each.name == "x")
        made = kind.make("x", "s", **force.element.values)  # type: ignore[union-attr]
        assert {state.name: state.unit for state in made.states}.items() <= kind.states.items(), name
