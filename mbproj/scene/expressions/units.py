"""Units: their factors to SI and radians, their dimensions, and how they are written: products, quotients and powers of
the symbols, as in kg*mm^2, N·s/mm, N/(m*s), 1/s.

    unit   = [1 /] factor {(* | · | /) factor}
    factor = (symbol | (unit)) [^ number | ² | ³]

A symbol may be a name of the scene as well, as a parameter `m`. Right behind a number it is the unit: `2 m`. Further on
it is the unit where nothing else can stand. That is before a power (`2 kg*m^2`), before a symbol that is no name
(`2 N*m/rad`), and within parentheses that have such a symbol (`2 (kg*m)`). So it is in the usual units of `COMPOUNDS`
without spaces: `2 N*m`, `40 kN/m`. Elsewhere it could be both, as in `2 kg*m` and `2 N * m`, which is an error.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Set
from functools import lru_cache
from itertools import product
from types import MappingProxyType
from typing import NamedTuple

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import did_you_mean


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

#: The usual units of two symbols and more: torques, stiffnesses, dampings, masses by length, velocities, flows.
_USUAL = ("F*L", "F/L", "F*T/L", "F*L*T", "M/T", "M/L", "L/T", "L^3/T", "A/T")
_KINDS = {"F": FORCE, "L": LENGTH, "M": MASS, "T": TIME, "A": ANGLE}
#: Symbols that are units in compounds alone: elsewhere l is the length of a spring.
_LITRES = {"l": Unit(Dimension(length=3), divide=1000.0)}


def _compounds() -> Iterator[str]:
    """The usual units, with all symbols of their kinds."""
    alike = {kind: [name for name, unit in SYMBOLS.items() if unit.dimension == its] for kind, its in _KINDS.items()}
    for pattern in _USUAL:
        yield from map("".join, product(*(alike.get(each, each) for each in pattern)))
    yield from (f"{litre}/{time}" for litre in _LITRES for time in ("min", "s"))


#: Units that are units without spaces, whatever the names of the scene are.
COMPOUNDS = frozenset(_compounds())
#: The most levels of parentheses in a unit.
MAX_DEPTH = 5

_NAME = re.compile(r"\s*([A-Za-z_][A-Za-z0-9_]*)(?![A-Za-z0-9_]|\.[A-Za-z_])")
_LITRE = re.compile(r"\s*(l)(?=/(?:min|s)(?![A-Za-z0-9_]))")
_OPERATOR = re.compile(r"\s*([*·⋅/])(?!\*)")
_POWER = re.compile(r"\s*(?:\^\s*(?P<number>[-+]?[0-9]{1,6}(?:\.[0-9]{1,12})?)(?![0-9.])|(?P<raised>[²³]))")
_ONE_OVER = re.compile(r"\s*1\s*/(?!\*)")
_OPEN, _CLOSE = re.compile(r"\s*\("), re.compile(r"\s*\)")
_POWER_OF_NUMBER = re.compile(r"\s*\*\*")
_RAISED = {"²": 2, "³": 3}
#: Units that are often written without a sign between them: Nm, kgm, Ns.
_RUN_TOGETHER = {a + b: f"{a}*{b}" for a in ("N", "kN", "kg", "g") for b in ("m", "mm", "cm")}
_RUN_TOGETHER |= {"Ns": "N*s", "Nms": "N*m*s"}


class UnclearUnit(Exception):
    """A symbol that could be a unit, or what has its name in the scene.

    `word`: the symbol; `at`: its character in the text; `certain`: where what is surely a unit ends; `end`: where the
    whole unit would end; `settles`: whether parentheses around the whole make it a unit."""

    def __init__(self, word: str, at: int, certain: int, end: int, settles: bool) -> None:
        super().__init__(word)
        self.word, self.at, self.certain, self.end, self.settles = word, at, certain, end, settles


def unit_at(text: str, at: int, names: Set[str] = frozenset()) -> tuple[Unit, int] | None:
    """The unit that begins at this character of the text, and where it ends; None where none does. `names` are the
    symbols that are names of the scene as well. Raises UnclearUnit where one of them could be both."""
    reader = _Reader(text, at, names)
    parsed = reader.unit(at, MAX_DEPTH)
    if parsed is None or reader.unclear is None:
        return parsed
    usual = text[at : parsed[1]] in COMPOUNDS and _POWER_OF_NUMBER.match(text, parsed[1]) is None
    if not usual:
        raise UnclearUnit(*reader.unclear, reader.certain, parsed[1], reader.settled)
    return parsed


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
    return did_you_mean(word, SYMBOLS) if len(word) > 1 else None


class _Reader:
    """Reads a unit in a text. `unclear` is the last symbol that could be a name, and its place, where nothing after it
    settles that it is a unit; `certain` is where what is settled ends."""

    def __init__(self, text: str, start: int, names: Set[str]) -> None:
        self._text, self._start, self._names = text, start, names
        self.unclear: tuple[str, int] | None = None
        self.certain = start
        self.settled = False

    def unit(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """The unit at this character, and where it ends."""
        one = _ONE_OVER.match(self._text, at)
        factor = self._factor(at if one is None else one.end(), depth)
        if factor is None:
            return None
        unit, end = factor if one is None else (factor[0] ** -1, factor[1])
        if depth == MAX_DEPTH and _OPEN.match(self._text, at) is None:
            self.unclear = None  # right behind a number
        certain = at if self.unclear else end
        while (sign := _OPERATOR.match(self._text, end)) is not None:
            so_far = self.unclear, self.settled
            factor = self._factor(sign.end(), depth)
            if factor is None:
                self.unclear, self.settled = so_far
                break
            unit, end = unit * (factor[0] ** -1 if sign[1] == "/" else factor[0]), factor[1]
            certain = certain if self.unclear else end
        self.certain = certain
        return unit, end

    def _factor(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """A symbol or a unit in parentheses, with its power, and where it ends."""
        unit_and_end = self._symbol(at) or self._group(at, depth)
        if unit_and_end is None:
            return None
        unit, end = unit_and_end
        power = _POWER.match(self._text, end)
        if power is None:
            return unit, end
        self.unclear, self.settled = None, True
        exponent = float(power["number"]) if power["number"] else _RAISED[power["raised"]]
        return unit**exponent, power.end()

    def _symbol(self, at: int) -> tuple[Unit, int] | None:
        litre, name = _LITRE.match(self._text, at), _NAME.match(self._text, at)
        if name is None or (name[1] not in SYMBOLS and litre is None):
            return None
        if name.start(1) != self._start and _OPEN.match(self._text, name.end()):
            return None  # a function
        is_name = name[1] in self._names
        self.unclear = (name[1], name.start(1)) if is_name else None
        self.settled = self.settled or not is_name
        return (_LITRES if litre else SYMBOLS)[name[1]], name.end()

    def _group(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """A unit in parentheses. One symbol that is no name of the scene settles that all of them are units."""
        before, self.settled = self.settled, False
        opened = _OPEN.match(self._text, at)
        inner = self.unit(opened.end(), depth - 1) if opened is not None and depth > 0 else None
        closed = None if inner is None else _CLOSE.match(self._text, inner[1])
        self.unclear = None if self.settled else self.unclear
        self.settled = self.settled or before
        return None if inner is None or closed is None else (inner[0], closed.end())
