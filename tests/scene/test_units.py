"""Units and the dimensions that they bring."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj.scene.evaluate import Value, evaluate
from mbproj.scene.expressions import parse
from mbproj.scene.units import (
    ANGLE,
    ANGULAR_VELOCITY,
    BARE,
    INERTIA,
    LENGTH,
    MASS,
    TIME,
    UNITS,
    VELOCITY,
    Dimension,
    describe,
)

SI = {
    "m": 1, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "kg": 1, "g": 1e-3, "s": 1, "ms": 1e-3, "min": 60, "rad": 1,
    "deg": math.pi / 180, "rad/s": 1, "deg/s": math.pi / 180, "rpm": 2 * math.pi / 60,
    "m/s": 1, "mm/s": 1e-3, "cm/s": 1e-2, "m/s^2": 1, "kg*m^2": 1, "kg/m^3": 1, "g/cm^3": 1e3,
    "Hz": 2 * math.pi, "N": 1, "kN": 1e3, "N*m": 1, "J": 1, "N/m": 1, "N/mm": 1e3, "N*s/m": 1,
    "N*m/rad": 1, "N*m*s/rad": 1,
}


def value(text: str, **known: Value) -> Value:
    return evaluate(parse(text), known)


def test_every_unit_in_si() -> None:
    assert {unit: value(f"1 {unit}").number for unit in UNITS} == pytest.approx(SI, rel=1e-15)


@settings(derandomize=True, deadline=None)
@given(st.integers(-10**9, 10**9))
def test_decimal_units_are_exact(number: int) -> None:
    assert value(f"{number} mm").number == float(f"{number}e-3")
    assert value(f"{number} cm").number == float(f"{number}e-2")
    assert value(f"{number}g").number == float(f"{number}e-3")


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


@pytest.mark.parametrize("text", ["x", "2*x", "x + 1 m", "1 kg / x", "x**2", "min(x, 1 m)", "(2 m)**x", "-x"])
def test_what_follows_from_a_number_without_unit_may_be_anything(text: str) -> None:
    assert value(text, x=Value(2.0, None)).dimension is None


def test_a_unit_binds_to_what_stands_right_before_it() -> None:
    assert value("a mm", a=Value(5.0)).number == 0.005
    assert value("(1 + 2) mm").number == 0.003
    assert value("max(1, 2) mm").number == 0.002
    assert value("1 + 2 mm").number == 1.002


AGREE = [
    (BARE, MASS), (LENGTH, BARE), (LENGTH, LENGTH), (ANGLE, ANGLE),
    (LENGTH, Dimension(length=1, angle=1)), (VELOCITY, Dimension(length=1, time=-1, angle=1)),
    (ANGULAR_VELOCITY, Dimension(time=-1)),
]
DISAGREE = [
    (LENGTH, MASS), (ANGLE, LENGTH), (ANGLE, Dimension(angle=-1)), (ANGULAR_VELOCITY, Dimension(time=1)),
    (LENGTH, VELOCITY),
]


def test_which_dimensions_agree() -> None:
    assert [one.agrees(other) and other.agrees(one) for one, other in AGREE] == [True] * len(AGREE)
    assert [one.agrees(other) or other.agrees(one) for one, other in DISAGREE] == [False] * len(DISAGREE)


def test_dimensions_in_words() -> None:
    assert [describe(dimension) for dimension in (LENGTH, INERTIA, Dimension(2, 1, -3), Dimension(angle=-1), BARE)] == [
        "a length", "a moment of inertia", "in m^2*kg/s^3", "in 1/rad", "a number without unit",
    ]
