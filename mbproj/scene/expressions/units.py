"""Units: their factors to SI and radians, their dimensions, and how they are written.

Written are products, quotients and powers of the symbols, as in kg*mm^2, N·s/mm, N/(m*s), 1/s:

    unit   = [1 /] factor {(* | · | /) factor}
    factor = (symbol | (unit)) [^ number | ² | ³]

Where a unit ends depends on the parameters. After the first factor the name of a parameter is that parameter: with a
parameter `g`, `2 kg*g` is 2 kg times g. The units of COMPOUNDS, written without spaces, are units all the same: with a
parameter `m`, `5 N*m` is a torque, and `5 N * m` is 5 N times m.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Set
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple

from mbproj.dataclass import dataclass
from mbproj.errors import did_you_mean


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

#: The units by symbol; `unit_at` reads their products, quotients and powers.
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
_NAMES: Mapping[Dimension, str] = MappingProxyType(
    {
        LENGTH: "a length",
        MASS: "a mass",
        TIME: "a time",
        ANGLE: "an angle",
        VELOCITY: "a velocity",
        ANGULAR_VELOCITY: "an angular velocity",
        ACCELERATION: "an acceleration",
        INERTIA: "a moment of inertia",
        DENSITY: "a density",
        FORCE: "a force",
        TORQUE: "a torque",
        STIFFNESS: "a stiffness",
        DAMPING: "a damping",
        TORSION_STIFFNESS: "a torsional stiffness",
        TORSION_DAMPING: "a torsional damping",
        POWER: "a power",
        PRESSURE: "a pressure",
        FLOW: "a flow",
        CURRENT: "a current",
        VOLTAGE: "a voltage",
        RESISTANCE: "a resistance",
        INDUCTANCE: "an inductance",
        BARE: "a number without unit",
    }
)
#: The names in results of SI units that have a name of their own.
_OWN_NAMES: Mapping[Dimension, str] = MappingProxyType(
    {FORCE: "N", TORQUE: "N m", POWER: "W", PRESSURE: "Pa", VOLTAGE: "V", RESISTANCE: "ohm", INDUCTANCE: "H"}
)


def describe(dimension: Dimension) -> str:
    """The dimension in words: "a length", or "in m^2/s" where it has no name."""
    return _NAMES[dimension] if dimension in _NAMES else f"in {symbol_of(dimension)}"


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


#: Units that stay units whatever the names of the parameters are.
COMPOUNDS = (
    "rad/s",
    "deg/s",
    "m/s",
    "mm/s",
    "cm/s",
    "m/s^2",
    "kg*m^2",
    "kg/m^3",
    "g/cm^3",
    "N*m",
    "N/m",
    "N/mm",
    "N*s/m",
    "N*m/rad",
    "N*m*s/rad",
    "l/min",
    "l/s",
)
#: Symbols that are units in COMPOUNDS alone: elsewhere l is the length of a spring.
IN_COMPOUNDS = {"l": Unit(Dimension(length=3), divide=1000.0)}
#: The most levels of parentheses in a unit.
MAX_DEPTH = 5

_LONGEST_FIRST = sorted(COMPOUNDS, key=len, reverse=True)
_COMPOUND = re.compile(rf"(?:{'|'.join(map(re.escape, _LONGEST_FIRST))})(?![A-Za-z0-9_])")
_NAME = re.compile(r"\s*([A-Za-z_][A-Za-z0-9_]*)(?![A-Za-z0-9_]|\.[A-Za-z_])")
_OPERATOR = re.compile(r"\s*([*·⋅/])(?!\*)")
_POWER = re.compile(r"\s*(?:\^\s*(?P<number>[-+]?[0-9]{1,6}(?:\.[0-9]{1,12})?)(?![0-9.])|(?P<raised>[²³]))")
_ONE_OVER = re.compile(r"\s*1\s*/(?!\*)")
_OPEN, _CLOSE = re.compile(r"\s*\("), re.compile(r"\s*\)")
_RAISED = {"²": 2, "³": 3}
#: Units that are often written without a sign between them: Nm, kgm, Ns.
_RUN_TOGETHER = {a + b: f"{a}*{b}" for a in ("N", "kN", "kg", "g") for b in ("m", "mm", "cm")}
_RUN_TOGETHER |= {"Ns": "N*s", "Nms": "N*m*s"}


def unit_at(text: str, at: int, parameters: Set[str] = frozenset()) -> tuple[Unit, int] | None:
    """The unit that begins at this character of the text, and where it ends; None where none does."""
    compound = _COMPOUND.match(text, at)
    return _Reader(text, parameters, compound.end() if compound else at + 1, compound is not None).unit(at, MAX_DEPTH)


@lru_cache(maxsize=256)
def unit_of(text: str) -> Unit:
    """The unit that the whole text is. Raises ValueError where it is none."""
    unit = unit_at(text, 0)
    if unit is None or text[unit[1] :].strip():
        raise ValueError(f"'{text}' is no unit")
    return unit[0]


def similar_unit(word: str) -> str | None:
    """A hint with the unit that an unknown word was probably meant to be; None where none is similar."""
    if word in _RUN_TOGETHER:
        return f"did you mean '{_RUN_TOGETHER[word]}'?"
    return did_you_mean(word, (*SYMBOLS, *COMPOUNDS)) if len(word) > 1 else None


class _Reader:
    """Reads a unit in a text. Up to the character `free` all symbols are units; from there on the name of a parameter
    is none. `compound`: the text begins with one of `COMPOUNDS`."""

    def __init__(self, text: str, parameters: Set[str], free: int, compound: bool) -> None:
        self._text, self._parameters, self._free, self._compound = text, parameters, free, compound

    def unit(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """The unit at this character, and where it ends."""
        one = _ONE_OVER.match(self._text, at)
        factor = self.factor(at if one is None else one.end(), depth)
        if factor is None:
            return None
        unit, end = factor if one is None else (factor[0] ** -1, factor[1])
        while (sign := _OPERATOR.match(self._text, end)) is not None:
            factor = self.factor(sign.end(), depth)
            if factor is None:
                break
            unit, end = unit * (factor[0] ** -1 if sign[1] == "/" else factor[0]), factor[1]
        return unit, end

    def factor(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """A symbol or a unit in parentheses, with its power, and where it ends."""
        unit_and_end = self._symbol(at) or self._group(at, depth)
        if unit_and_end is None:
            return None
        unit, end = unit_and_end
        power = _POWER.match(self._text, end)
        if power is None:
            return unit, end
        exponent = float(power["number"]) if power["number"] else _RAISED[power["raised"]]
        return unit**exponent, power.end()

    def _symbol(self, at: int) -> tuple[Unit, int] | None:
        name = _NAME.match(self._text, at)
        if name is None:
            return None
        is_free = name.start(1) >= self._free
        if name[1] in IN_COMPOUNDS and self._compound and not is_free:
            return IN_COMPOUNDS[name[1]], name.end()
        if name[1] not in SYMBOLS:
            return None
        means_more = name[1] in self._parameters or _OPEN.match(self._text, name.end())
        return None if means_more and is_free else (SYMBOLS[name[1]], name.end())

    def _group(self, at: int, depth: int) -> tuple[Unit, int] | None:
        opened = _OPEN.match(self._text, at)
        inner = self.unit(opened.end(), depth - 1) if opened is not None and depth > 0 else None
        closed = None if inner is None else _CLOSE.match(self._text, inner[1])
        return None if inner is None or closed is None else (inner[0], closed.end())
