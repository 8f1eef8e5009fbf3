"""Units: their factors to SI and radians, and their dimensions. `unit_text` reads how they are written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from mbproj.dataclass import dataclass


class Dimension(NamedTuple):
    """The exponents of metre, kilogram, second, radian and ampere."""

    length: float = 0
    mass: float = 0
    time: float = 0
    angle: float = 0
    current: float = 0

    def __mul__(self, other: Dimension) -> Dimension:  # type: ignore[override]
        return Dimension(*(mine + its for mine, its in zip(self, other, strict=True)))

    def __pow__(self, exponent: float) -> Dimension:
        return Dimension(*(exponent * mine for mine in self))

    def agrees(self, other: Dimension) -> bool:
        """Whether a number of one dimension may stand for the other: a radian is dropped beside any other unit
        (6 rad/s x 0.1 m is a velocity), and a number without unit is in SI."""
        if BARE in (self, other):
            return True
        mine, its = (each._replace(angle=0) for each in (self, other))
        return mine == its and (mine != BARE or self.angle == other.angle)


@dataclass(frozen=True)
class Unit:
    """A number x in this unit is x * multiply / divide in SI. Two factors, because 7 * 0.001 is not 7 / 1000."""

    dimension: Dimension
    multiply: float = 1.0
    divide: float = 1.0

    def __mul__(self, other: Unit) -> Unit:
        multiply, divide = self.multiply * other.multiply, self.divide * other.divide
        return Unit(self.dimension * other.dimension, *_in_lowest_terms(multiply, divide))

    def __pow__(self, exponent: float) -> Unit:
        factors = (self.multiply, self.divide) if exponent >= 0 else (self.divide, self.multiply)
        multiply, divide = (_raised(factor, abs(exponent)) for factor in factors)
        return Unit(self.dimension**exponent, multiply, divide)


def _in_lowest_terms(multiply: float, divide: float) -> tuple[float, float]:
    """The two factors without their common divisor, so that g/cm^3 multiplies by 1000 and rounds once."""
    if not (multiply.is_integer() and divide.is_integer()):
        return multiply, divide
    shared = math.gcd(int(multiply), int(divide))
    return float(int(multiply) // shared), float(int(divide) // shared)


def _raised(factor: float, exponent: float) -> float:
    """The factor to a power, infinite where that is too large."""
    try:
        return factor**exponent
    except OverflowError:
        return math.inf


BARE = Dimension()
LENGTH, MASS, TIME, ANGLE = Dimension(length=1), Dimension(mass=1), Dimension(time=1), Dimension(angle=1)
VELOCITY, ANGULAR_VELOCITY = Dimension(length=1, time=-1), Dimension(angle=1, time=-1)
ACCELERATION, INERTIA = Dimension(length=1, time=-2), Dimension(mass=1, length=2)
DENSITY = Dimension(mass=1, length=-3)
FORCE, TORQUE = Dimension(1, 1, -2), Dimension(2, 1, -2)
STIFFNESS, DAMPING = Dimension(0, 1, -2), Dimension(0, 1, -1)
TORSION_STIFFNESS, TORSION_DAMPING = Dimension(2, 1, -2, -1), Dimension(2, 1, -1, -1)
POWER, PRESSURE, FLOW = Dimension(2, 1, -3), Dimension(-1, 1, -2), Dimension(3, 0, -1)
CURRENT, VOLTAGE = Dimension(current=1), Dimension(2, 1, -3, current=-1)
RESISTANCE, INDUCTANCE = Dimension(2, 1, -3, current=-2), Dimension(2, 1, -2, current=-2)

#: The units by symbol; `unit_text.unit_at` reads their products, quotients and powers.
SYMBOLS: Mapping[str, Unit] = MappingProxyType(
    {
        "m": Unit(LENGTH),
        "mm": Unit(LENGTH, divide=1000.0),
        "cm": Unit(LENGTH, divide=100.0),
        "km": Unit(LENGTH, 1000.0),
        "um": Unit(LENGTH, divide=1e6),
        "kg": Unit(MASS),
        "g": Unit(MASS, divide=1000.0),
        "s": Unit(TIME),
        "ms": Unit(TIME, divide=1000.0),
        "us": Unit(TIME, divide=1e6),
        "min": Unit(TIME, 60.0),
        "rad": Unit(ANGLE),
        "deg": Unit(ANGLE, math.pi, 180.0),
        "rpm": Unit(ANGULAR_VELOCITY, 2 * math.pi, 60.0),
        "Hz": Unit(ANGULAR_VELOCITY, 2 * math.pi),
        "N": Unit(FORCE),
        "kN": Unit(FORCE, 1000.0),
        "J": Unit(TORQUE),
        "W": Unit(POWER),
        "kW": Unit(POWER, 1000.0),
        "A": Unit(CURRENT),
        "mA": Unit(CURRENT, divide=1000.0),
        "V": Unit(VOLTAGE),
        "mV": Unit(VOLTAGE, divide=1000.0),
        "ohm": Unit(RESISTANCE),
        "H": Unit(INDUCTANCE),
        "mH": Unit(INDUCTANCE, divide=1000.0),
        "Pa": Unit(PRESSURE),
        "kPa": Unit(PRESSURE, 1000.0),
        "MPa": Unit(PRESSURE, 1e6),
        "bar": Unit(PRESSURE, 1e5),
    }
)

#: The symbols of the base units, from which the unit of a dimension without a name is composed.
_SYMBOLS = ("m", "kg", "s", "rad", "A")
#: Quantities in words, and their units as scenes have them.
_NAMES: Mapping[Dimension, tuple[str, str]] = MappingProxyType(
    {
        LENGTH: ("a length", "m"),
        MASS: ("a mass", "kg"),
        TIME: ("a time", "s"),
        ANGLE: ("an angle", "rad"),
        VELOCITY: ("a velocity", "m/s"),
        ANGULAR_VELOCITY: ("an angular velocity", "rad/s"),
        ACCELERATION: ("an acceleration", "m/s^2"),
        INERTIA: ("a moment of inertia", "kg*m^2"),
        DENSITY: ("a density", "kg/m^3"),
        FORCE: ("a force", "N"),
        TORQUE: ("a torque", "N*m"),
        STIFFNESS: ("a stiffness", "N/m"),
        DAMPING: ("a damping", "N*s/m"),
        TORSION_STIFFNESS: ("a torsional stiffness", "N*m/rad"),
        TORSION_DAMPING: ("a torsional damping", "N*m*s/rad"),
        POWER: ("a power", "W"),
        PRESSURE: ("a pressure", "Pa"),
        FLOW: ("a flow", "m^3/s"),
        CURRENT: ("a current", "A"),
        VOLTAGE: ("a voltage", "V"),
        RESISTANCE: ("a resistance", "ohm"),
        INDUCTANCE: ("an inductance", "H"),
        BARE: ("a number without unit", ""),
    }
)
#: The names in results of SI units that have a name of their own.
_OWN_NAMES: Mapping[Dimension, str] = MappingProxyType(
    {FORCE: "N", TORQUE: "N m", POWER: "W", PRESSURE: "Pa", VOLTAGE: "V", RESISTANCE: "ohm", INDUCTANCE: "H"}
)


def describe(dimension: Dimension, *, with_unit: bool = False) -> str:
    """The dimension in words: "a length", or "in m^2/s" where it has no name; "a length, in m" with its unit."""
    if dimension not in _NAMES:
        return f"in {symbol_of(dimension)}"
    words, unit = _NAMES[dimension]
    return f"{words}, in {unit}" if with_unit and unit else words


def symbol_of(dimension: Dimension) -> str:
    """The SI unit of a dimension, composed of base units: "kg*m/s^2"; "1" for a number without unit."""
    powers = [(symbol, power) for symbol, power in zip(_SYMBOLS, dimension, strict=True) if power]
    above = "*".join(_power(symbol, power) for symbol, power in powers if power > 0)
    below = "".join("/" + _power(symbol, -power) for symbol, power in powers if power < 0)
    return f"{above or '1'}{below}"


def called(dimension: Dimension) -> str:
    """The name of the SI unit of a dimension in results: its own name, where it has one, else `symbol_of`."""
    return _OWN_NAMES.get(dimension, symbol_of(dimension))


def _power(symbol: str, power: float) -> str:
    return symbol if power == 1 else f"{symbol}^{power:g}"
