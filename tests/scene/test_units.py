"""Units, the dimensions that they bring, and the units of formulas."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj.base.errors import InputError
from mbproj.scene.expressions.dimensions import describe
from mbproj.scene.expressions.evaluate import Value, evaluate
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.expressions.units import (
    ANGLE,
    ANGULAR_VELOCITY,
    BARE,
    COMPOUNDS,
    DAMPING,
    DENSITY,
    INERTIA,
    LENGTH,
    MASS,
    STIFFNESS,
    SYMBOLS,
    TIME,
    TORQUE,
    VELOCITY,
    Dimension,
    unit_of,
)
from mbproj.scene.scene import SceneText, read_scene_text
from tests.scene.scenes import read_with

SI = {
    "m": 1,
    "mm": 1e-3,
    "um": 1e-6,
    "us": 1e-6,
    "cm": 1e-2,
    "km": 1e3,
    "kg": 1,
    "g": 1e-3,
    "s": 1,
    "ms": 1e-3,
    "min": 60,
    "rad": 1,
    "deg": math.pi / 180,
    "rad/s": 1,
    "deg/s": math.pi / 180,
    "rpm": 2 * math.pi / 60,
    "m/s": 1,
    "mm/s": 1e-3,
    "cm/s": 1e-2,
    "m/s^2": 1,
    "kg*m^2": 1,
    "kg/m^3": 1,
    "g/cm^3": 1e3,
    "Hz": 2 * math.pi,
    "N": 1,
    "kN": 1e3,
    "N*m": 1,
    "J": 1,
    "N/m": 1,
    "N/mm": 1e3,
    "N*s/m": 1,
    "N*m/rad": 1,
    "N*m*s/rad": 1,
    "W": 1,
    "kW": 1e3,
    "A": 1,
    "mA": 1e-3,
    "V": 1,
    "mV": 1e-3,
    "ohm": 1,
    "H": 1,
    "mH": 1e-3,
    "Pa": 1,
    "kPa": 1e3,
    "MPa": 1e6,
    "bar": 1e5,
    "l/s": 1e-3,
    "l/min": 1e-3 / 60,
}


def value(text: str, **known: Value) -> Value:
    return evaluate(parse(text), known)


def test_every_unit_in_si() -> None:
    assert {*SYMBOLS} <= {*SI}
    assert {unit: value(f"1 {unit}").number for unit in SI} == pytest.approx(SI, rel=1e-15)


@settings(derandomize=True, deadline=None)
@given(st.integers(-(10**9), 10**9))
def test_decimal_units_are_exact(number: int) -> None:
    assert value(f"{number} mm").number == float(f"{number}e-3")
    assert value(f"{number} cm").number == float(f"{number}e-2")
    assert value(f"{number}g").number == float(f"{number}e-3")


@settings(derandomize=True, deadline=None)
@given(st.integers(-(10**6), 10**6))
def test_powers_and_quotients_of_decimal_units_are_exact(number: int) -> None:
    assert value(f"{number} kg*mm^2").number == float(f"{number}e-6")
    assert value(f"{number} g/cm^3").number == float(f"{number}e3")
    assert value(f"{number} mm/ms").number == float(number)


FACTORS = st.tuples(st.sampled_from(sorted(SYMBOLS)), st.integers(-3, 3).filter(bool))


@settings(derandomize=True, deadline=None)
@given(st.lists(FACTORS, min_size=1, max_size=4), st.data())
def test_a_unit_is_the_product_of_its_factors(factors: list[tuple[str, int]], data: st.DataObject) -> None:
    """Written with any operators, powers and spaces, against the symbols' own numbers and dimensions."""
    text, number, dimension = "", 1.0, BARE
    for symbol, power in factors:
        over = bool(text) and data.draw(st.booleans())
        sign = data.draw(st.sampled_from(["/", " / "] if over else ["*", "·", " * "])) if text else ""
        text += sign + (symbol if power == 1 else f"{symbol}^{power}")
        exponent = -power if over else power
        number, dimension = number * SI[symbol] ** exponent, dimension * SYMBOLS[symbol].dimension ** exponent
    found = value(f"1 {text}")
    assert (found.number, found.dimension) == (pytest.approx(number, rel=1e-13), dimension)


VALUES = {
    "90 deg": (math.pi / 2, ANGLE),
    "180deg": (math.pi, ANGLE),
    "(360/8) deg": (math.pi / 4, ANGLE),
    "2*pi rad": (2 * math.pi, ANGLE),
    "60 rpm": (2 * math.pi, ANGULAR_VELOCITY),
    "0.12 + 80 mm": (0.12 + 0.08, LENGTH),
    "-5 mm": (-0.005, LENGTH),
    "sqrt(9 m * 4 m)": (6.0, LENGTH),
    "hypot(3 m, 400 cm)": (5.0, LENGTH),
    "abs(-3 s)": (3.0, TIME),
    "max(1, 2 kg)": (2.0, MASS),
    "(2 m)**3": (8.0, Dimension(length=3)),
    "6 rad/s * 0.5 m": (3.0, Dimension(length=1, time=-1, angle=1)),
    "6 m/2 s": (3.0, Dimension(length=1, time=-1)),
    "2 kg*m^2 / 2": (1.0, INERTIA),
    "2 kg*mm^2": (2e-6, INERTIA),
    "2 kg·m²": (2.0, INERTIA),
    "2 N*s/mm": (2e3, DAMPING),
    "2 N / (m*s) * 3 s": (6.0, Dimension(0, 1, -2)),
    "4 N/(m/(1/s))": (4.0, Dimension(0, 1, -3)),
    "6 N/(2 m)": (3.0, STIFFNESS),
    "6 N/(mm)": (6e3, STIFFNESS),
    "25 1/s": (25.0, Dimension(time=-1)),
    "(2*pi) s^-1": (2 * math.pi, Dimension(time=-1)),
    "3 1/(m*s^2)": (3.0, Dimension(-1, 0, -2)),
    "2 N·mm + 1 J": (1.002, TORQUE),
    "7.85 g/(cm^3)": (7850.0, DENSITY),
    "2 kg*max(3 m, 1)": (6.0, Dimension(1, 1)),
    "2 N*min(3, 4)": (6.0, Dimension(1, 1, -2)),
    "2 m^2 - 1 m^2": (1.0, Dimension(2)),
    "2 kg * (3 m)**2": (18.0, INERTIA),
    "2 m / 4 m": (0.5, BARE),
    "sin(30 deg) * 2 m": (math.sin(math.pi / 6) * 2, LENGTH),
    "atan2(1 m, 1 m)": (math.pi / 4, ANGLE),
    "exp(1 rad)": (math.e, BARE),
    "360/8 deg": (45 * 180 / math.pi, Dimension(angle=-1)),
}


@pytest.mark.parametrize("text", VALUES)
def test_values_and_dimensions(text: str) -> None:
    number, dimension = VALUES[text]
    found = value(text)
    assert (found.number, found.dimension) == (pytest.approx(number, rel=1e-15), dimension)


@pytest.mark.parametrize("text", ["x", "2*x", "x + 1", "1 kg / x", "x**2", "min(x, 1)", "(2 m)**x", "-x"])
def test_what_follows_from_a_number_without_unit_may_be_anything(text: str) -> None:
    assert value(text, x=Value(2.0, None)).dimension is None


@pytest.mark.parametrize("text", ["x + 1 m", "1 m - x", "min(x, 1 m)", "clip(x, -1 m, 2*x)", "2*(x + 1 m)"])
def test_a_sum_has_the_unit_of_the_terms_that_have_one(text: str) -> None:
    assert value(text, x=Value(2.0, None)).dimension == LENGTH


def test_a_unit_binds_to_what_stands_right_before_it() -> None:
    assert value("a mm", a=Value(5.0)).number == 0.005
    assert value("(1 + 2) mm").number == 0.003
    assert value("max(1, 2) mm").number == 0.002
    assert value("1 + 2 mm").number == 1.002


#: Units of which some symbols are parameters too; all parameters are 10 and without unit.
BESIDE_PARAMETERS = {
    "2 m": 2.0,  # right behind a number it is the unit,
    "25 1/s": 25.0,
    "3 m/s^2": 3.0,  # and before a power,
    "2 kg*m^2": 2.0,
    "3 N/(s^2)": 3.0,
    "5 N*m*s/rad": 5.0,  # before a symbol that is no parameter,
    "2 kN * s/cm": 2e5,
    "2 kN/(s*mm)": 2e6,
    "7 (kN/m)": 7e3,  # beside one in parentheses,
    "3 (kg*g)": 3e-3,
    "5 N*m": 5.0,  # and in the usual units without spaces
    "3 kN*m": 3e3,
    "7 kN/m": 7e3,
    "7 kg/s": 7.0,
    "2 N*m*s": 2.0,
    "30 l/s": 0.03,
    "7 kN/m*h": 7e4,
    "2*m": 20.0,  # after an operator it is the parameter,
    "m/s": 1.0,
    "m*g*h": 1000.0,
    "(2 m)/h": 0.2,
    "(5 N)*m": 50.0,  # and after parentheses
    "m * 3 m/s^2 * h": 300.0,
    "2 N*(m + 1)": 22.0,
    "2 N*max(m, 3)": 20.0,
    "h mm": 0.01,
}
#: The symbol that could be both, and its place.
UNCLEAR = {
    "2 kg*g": ("g", 5),
    "3 N * m": ("m", 6),
    "2 m*m": ("m", 4),
    "2 kg/(s)": ("s", 6),
    "2 N/(m*s)": ("s", 7),
    "4 m/s^2 * m": ("m", 10),
    "2 N/m*s": ("s", 6),
    "1 kg*m**2": ("m", 5),
    "1 N*m**2": ("m", 4),
    "2 (m)": ("m", 3),
    "m g": ("g", 2),
    "(m + h) s": ("s", 8),
}
NAMED = {name: Value(10.0, None) for name in ("m", "s", "g", "h")}


@pytest.mark.parametrize("text", BESIDE_PARAMETERS)
def test_where_a_symbol_is_a_unit_beside_a_parameter_of_its_name(text: str) -> None:
    found = evaluate(parse(text, frozenset(NAMED)), NAMED).number
    assert found == pytest.approx(BESIDE_PARAMETERS[text], rel=1e-15)


@pytest.mark.parametrize("text", UNCLEAR)
def test_a_symbol_that_could_be_both_is_an_error_that_names_both(text: str) -> None:
    word, at = UNCLEAR[text]
    with pytest.raises(ExpressionError) as error:
        parse(text, frozenset(NAMED))
    assert (error.value.message, error.value.at) == (
        f"'{word}' could be the unit {word}, or the '{word}' that is named here",
        at,
    )


def test_the_hint_has_both_meanings() -> None:
    with pytest.raises(ExpressionError) as error:
        parse("3 kg*g", frozenset(NAMED))
    assert error.value.hint == "write (3 kg)*g for what 'g' names, 3 (kg*g) for the unit"
    for text, number in (("(3 kg)*g", 30.0), ("3 (kg*g)", 0.003)):
        assert evaluate(parse(text, frozenset(NAMED)), NAMED).number == number


@settings(derandomize=True, deadline=None)
@given(st.sampled_from(sorted(COMPOUNDS)), st.integers(1, 10**6), st.sets(st.sampled_from(sorted(SYMBOLS))))
def test_a_usual_unit_behind_a_number_is_the_same_whatever_the_parameters_are(
    unit: str, number: int, named: set[str]
) -> None:
    known = {name: Value(7.0, None) for name in named}
    assert evaluate(parse(f"{number} {unit}", frozenset(known)), known) == value(f"{number} {unit}")


@settings(derandomize=True, deadline=None)
@given(st.lists(FACTORS, min_size=1, max_size=4), st.sets(st.sampled_from(sorted(SYMBOLS))), st.data())
def test_no_unit_is_silently_another_one_beside_parameters(
    factors: list[tuple[str, int]], named: set[str], data: st.DataObject
) -> None:
    """With any names, a number with a unit has the value that it has without them, or is an error."""
    text = "3 "
    for at, (symbol, power) in enumerate(factors):
        sign = data.draw(st.sampled_from(["/", " / ", "*", "·", " * "])) if at else ""
        text += sign + (symbol if power == 1 else f"{symbol}^{power}")
    known = {name: Value(7.0, None) for name in named}
    try:
        found = evaluate(parse(text, frozenset(known)), known)
    except ExpressionError as error:
        assert "could be the unit" in error.message
    else:
        assert found == value(text)


def test_a_scene_knows_all_its_parameters_when_it_reads_the_first() -> None:
    given = "{crank_length: 0.08, weight: (2 kg)*g, torque: 5 N*m, g: 9.81, m: 3}"
    scene = read_with("{crank_length: 0.08, rod_length: 0.3}", given, parameters={"weight": "(3 kg)*g"})
    assert scene.parameters == {"crank_length": 0.08, "weight": 3 * 9.81, "torque": 5.0, "g": 9.81, "m": 3.0}


@pytest.mark.parametrize("text", ["", "2", "kg*", "m m", "1/", "m^", "m**2", "((m)"])
def test_what_is_no_unit(text: str) -> None:
    with pytest.raises(ValueError, match="is no unit"):
        unit_of(text)


AGREE = [
    (BARE, MASS),
    (LENGTH, BARE),
    (LENGTH, LENGTH),
    (ANGLE, ANGLE),
    (LENGTH, Dimension(length=1, angle=1)),
    (VELOCITY, Dimension(length=1, time=-1, angle=1)),
    (ANGULAR_VELOCITY, Dimension(time=-1)),
]
DISAGREE = [
    (LENGTH, MASS),
    (ANGLE, LENGTH),
    (ANGLE, Dimension(angle=-1)),
    (ANGULAR_VELOCITY, Dimension(time=1)),
    (LENGTH, VELOCITY),
]


def test_which_dimensions_agree() -> None:
    assert [one.agrees(other) and other.agrees(one) for one, other in AGREE] == [True] * len(AGREE)
    assert [one.agrees(other) or other.agrees(one) for one, other in DISAGREE] == [False] * len(DISAGREE)


def test_dimensions_in_words() -> None:
    assert [describe(dimension) for dimension in (LENGTH, INERTIA, Dimension(2, 1, -4), Dimension(angle=-1), BARE)] == [
        "a length",
        "a moment of inertia",
        "in m^2*kg/s^4",
        "in 1/rad",
        "a number without unit",
    ]


# The units of formulas: what fits is read, what does not is an error with the unit found and the unit wanted.

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
