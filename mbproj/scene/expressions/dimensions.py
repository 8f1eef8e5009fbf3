"""Dimensions in words, and the dimension of an expression: what follows from its parts, and which do not fit.

A number without unit is in SI, in the unit that its place asks for. So it fits every term of a sum. Beside a quantity
with a unit it is a pure number: `2 * 3 m` is a length. Beside what moves it may be a gain in any unit, which may be 1:
`20*pin.angle` and `pin.angle - 0.1` may be torques, and `pin.angle` is an angle. Beside the time it may be a rate:
`0.1*t` may be a length, and `sin(3*t)` is a number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING

from mbproj.base.dataclass import dataclass
from mbproj.scene.expressions.syntax_tree import Binary, Call, ExpressionError, QuantityNode
from mbproj.scene.expressions.units import (
    ACCELERATION,
    ANGLE,
    ANGULAR_VELOCITY,
    BARE,
    CURRENT,
    DAMPING,
    DENSITY,
    FLOW,
    FORCE,
    INDUCTANCE,
    INERTIA,
    LENGTH,
    MASS,
    POWER,
    PRESSURE,
    RESISTANCE,
    STIFFNESS,
    TIME,
    TORQUE,
    TORSION_DAMPING,
    TORSION_STIFFNESS,
    VELOCITY,
    VOLTAGE,
    Dimension,
    unit_of,
)

if TYPE_CHECKING:
    from mbproj.scene.expressions.evaluate import ExpressionFunction


class Origin(Enum):
    """What a dimension comes from, which decides what numbers without unit beside it may be."""

    NUMBER = 0  # numbers without unit
    PURE = 1  # ratios, and functions such as the sine, whose factor may be 1 of any unit too
    FIXED = 2  # quantities with a unit, and products with one
    TIME = 3  # the time alone, and numbers
    MOVING = 4  # coordinates, signals and states with a unit
    SHIFTED = 5  # sums of MOVING and numbers
    MIXED = 6  # sums of FIXED and others


#: Those beside which a number may be a gain in any unit.
_TAKES_GAIN = (Origin.MOVING, Origin.SHIFTED, Origin.MIXED)


@dataclass(frozen=True)
class Inferred:
    """The dimension of an expression, None where it is not known, and its origin. `scaled`: it is FIXED, with a number
    without unit as a factor. `loose`: such a number may bring powers of the time into it."""

    dimension: Dimension | None
    origin: Origin = Origin.FIXED
    loose: bool = False
    scaled: bool = False

    @staticmethod
    def of(dimension: Dimension | None, *, scaled: bool = False) -> Inferred:
        """That of a constant."""
        return Inferred(dimension, Origin.NUMBER if dimension == BARE else Origin.FIXED, scaled=scaled)

    @property
    def certain(self) -> Dimension | None:
        """The dimension, where numbers without unit leave no other one possible; else None, or BARE."""
        if self.origin is Origin.TIME:
            return BARE
        return None if self.loose else self.dimension

    def is_pure(self, *others: Dimension) -> bool:
        """Whether it may be a number without unit, or of one of these other dimensions."""
        if self.dimension is None or self.origin is Origin.TIME:
            return True
        return (self.dimension._replace(time=0) if self.loose else self.dimension) in (BARE, *others)

    def agrees(self, wanted: Dimension) -> bool:
        """Whether the expression may stand for a quantity of this dimension."""
        if self.dimension is None or self.origin in (Origin.TIME, Origin.SHIFTED):
            return True
        if self.loose:
            return wanted._replace(time=0).agrees(self.dimension._replace(time=0))
        return wanted.agrees(self.dimension)


UNKNOWN = Inferred(None, Origin.MOVING)
_PURE = Inferred(BARE, Origin.PURE)
_ANY_RATE = Inferred(BARE, Origin.TIME, loose=True)
#: The time, in expressions of it.
OF_TIME = Inferred(TIME, Origin.TIME)


def of_quantity(tree: QuantityNode, operand: Inferred) -> Inferred:
    """The dimension of an operand with a unit behind it. Raises ExpressionError where it has a unit already."""
    if not operand.is_pure():
        raise ExpressionError(f"'{tree.unit}' stands after what has a unit already", tree.at)
    return Inferred(unit_of(tree.unit).dimension)


def of_binary(tree: Binary, left: Inferred, right: Inferred, exponent: float | None) -> Inferred:
    """The dimension of a sum, product or power. `exponent` is the number on the right, None where that is no
    constant."""
    if tree.operator == "**":
        return _to_power(tree, left, right, exponent)
    if tree.operator in "+-":
        return _common(tree.at, [left, right])
    over = right if tree.operator == "*" or right.dimension is None else _raised(right, -1)
    return _product(left, over)


def of_call(tree: Call, function: ExpressionFunction, arguments: Sequence[Inferred]) -> Inferred:
    """The dimension of a function's value."""
    if function.paired:
        x, y = _common(tree.at, [arguments[0], *arguments[1::2]]), _common(tree.at, arguments[2::2])
        constant = arguments[0].origin in (Origin.NUMBER, Origin.FIXED)
        return y if constant or y.origin is not Origin.NUMBER or x.dimension is None else UNKNOWN
    if not function.same:
        for each in arguments:
            if not each.is_pure(ANGLE):
                assert each.dimension is not None
                raise ExpressionError(f"'{tree.function}' cannot take {describe(each.dimension)}", tree.at)
    common = _common(tree.at, arguments)
    if function.result is None:
        return _raised(common, function.power)
    if all(each.origin in (Origin.NUMBER, Origin.FIXED) for each in arguments):
        return Inferred.of(function.result)
    return _PURE if function.result == BARE else Inferred(function.result, Origin.MOVING)


def _raised(base: Inferred, exponent: float) -> Inferred:
    if base.dimension is None or exponent == 1.0:
        return base
    origin = Origin.MOVING if base.origin is Origin.MIXED else base.origin
    return Inferred(base.dimension**exponent, origin, base.loose)


def _to_power(tree: Binary, left: Inferred, right: Inferred, exponent: float | None) -> Inferred:
    if not right.is_pure():
        assert right.dimension is not None
        raise ExpressionError(f"an exponent has no unit, this is {describe(right.dimension, with_unit=True)}", tree.at)
    if left.dimension == BARE:
        origins = (left.origin, right.origin)
        if origins == (Origin.NUMBER, Origin.NUMBER):
            return left
        return _ANY_RATE if left.origin is Origin.TIME else _PURE
    return UNKNOWN if exponent is None or None in (left.dimension, right.dimension) else _raised(left, exponent)


def _product(left: Inferred, right: Inferred) -> Inferred:
    if left.dimension is None or right.dimension is None:
        return UNKNOWN
    dimension, loose = left.dimension * right.dimension, left.loose or right.loose
    origins = (left.origin, right.origin)
    if Origin.FIXED in origins:
        if dimension == BARE and Origin.NUMBER not in origins:
            return _PURE
        scaled = left.scaled or right.scaled
        loose = loose or (scaled and Origin.TIME in origins)
        return Inferred(dimension, Origin.FIXED, loose, scaled or Origin.NUMBER in origins)
    if not {Origin.NUMBER, Origin.PURE}.isdisjoint(origins):
        factor, other = (left, right) if left.origin in (Origin.NUMBER, Origin.PURE) else (right, left)
        if other.origin in _TAKES_GAIN and other.dimension != BARE:
            return UNKNOWN
        if other.origin is Origin.TIME:
            return _ANY_RATE if factor.origin is Origin.NUMBER else other
        return Inferred(BARE, Origin.NUMBER if Origin.NUMBER in origins else Origin.PURE)
    if Origin.TIME in origins:
        return Inferred(dimension, Origin.TIME, loose) if {*origins} == {Origin.TIME} else UNKNOWN
    return Inferred(dimension, Origin.SHIFTED if Origin.SHIFTED in origins else Origin.MOVING, loose)


def _common(at: int, terms: Sequence[Inferred]) -> Inferred:
    """The common dimension of terms that are added or compared; numbers without unit take it. Raises ExpressionError
    where dimensions differ."""
    known = [each for each in terms if each.dimension is not None]
    with_unit = [each for each in known if each.dimension != BARE]
    for first, second in pairwise(with_unit):
        _check_alike(at, first, second)
    origins = {each.origin for each in known}
    if not with_unit:
        if len(known) < len(terms):
            return UNKNOWN
        return next(
            (each for each in (_ANY_RATE, _PURE) if each.origin in origins),
            Inferred(BARE, Origin.MOVING if Origin.MOVING in origins else Origin.NUMBER),
        )
    dimension, loose = with_unit[0].dimension, any(each.loose for each in known)
    fixed = any(each.origin in (Origin.FIXED, Origin.MIXED) for each in with_unit)
    if Origin.TIME in origins:
        if not fixed:
            return UNKNOWN if origins & {*_TAKES_GAIN} else _rate(dimension, with_unit, known)
        return Inferred(dimension, Origin.TIME if dimension == TIME else Origin.FIXED, loose)
    if len(known) < len(terms):
        return Inferred(dimension, Origin.MIXED, loose) if fixed else UNKNOWN
    if {each.origin for each in with_unit} == {Origin.FIXED}:
        return Inferred(dimension, Origin.FIXED, loose)
    shifted = not {each.origin for each in known} <= {Origin.MOVING}
    return Inferred(dimension, Origin.MIXED if fixed else Origin.SHIFTED if shifted else Origin.MOVING, loose)


def _rate(dimension: Dimension | None, with_unit: Sequence[Inferred], known: Sequence[Inferred]) -> Inferred:
    """The sum of terms of the time; numbers beside it may be in any unit."""
    return Inferred(dimension, Origin.TIME) if len(with_unit) == len(known) else _ANY_RATE


def _check_alike(at: int, first: Inferred, second: Inferred) -> None:
    """Raises ExpressionError where two terms with units cannot be added."""
    assert first.dimension is not None
    assert second.dimension is not None
    if {first.origin, second.origin} in ({Origin.TIME, Origin.MOVING}, {Origin.TIME, Origin.SHIFTED}):
        return  # the time may stand for 1 of any unit each second
    loose = first.loose or second.loose
    one, two = (each._replace(time=0) if loose else each for each in (first.dimension, second.dimension))
    if not one.agrees(two):
        raise ExpressionError(
            f"{describe(first.dimension)} and {describe(second.dimension)} cannot be added or compared", at
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
