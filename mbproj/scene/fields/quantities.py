"""Fields of numbers: one in a unit, within bounds, whole; and three, as points, directions, the rows of a matrix."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, final

from mbproj.dataclass import dataclass
from mbproj.errors import Problem
from mbproj.scene.expressions.dimensions import describe, symbol_of
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.syntax_tree import Binary, Expression, QuantityNode
from mbproj.scene.expressions.units import BARE, Dimension, unit_of
from mbproj.scene.fields.checks import direction
from mbproj.scene.fields.fields import Converted, Field, List, Schema
from mbproj.scene.fields.reading import Reading, label
from mbproj.scene.records import KeyPath, Vector
from mbproj.scene.text.nodes import Node, ScalarNode

#: A bound that no quantity of a mechanism reaches. Below it, the square of a mass times a squared length is still a
#: finite number (the largest is 1.8e308).
LARGEST = 1e50


#: The bounds of a number: the attribute, its words in messages, and the test that a number is within.
LIMITS = (
    ("above", "greater than", operator.gt),
    ("minimum", "at least", operator.ge),
    ("maximum", "at most", operator.le),
)
#: Most numbers are written in this form, and need no tree of an expression.
_PLAIN = re.compile(r"-?[0-9]{1,15}(\.[0-9]{1,20})?")


def _plain(text: str) -> Value | None:
    """The value of a number without unit; None for any other expression."""
    return Value(float(text)) if _PLAIN.fullmatch(text) else None


@dataclass(frozen=True)
class Number(Field[float]):
    """A finite number in SI and radians, from an expression. `unit` is its SI unit, "" for none, None for any.

    Bounds are inclusive but for `above`.
    """

    unit: str | None = ""
    minimum: float | None = None
    above: float | None = None
    maximum: float | None = None

    @property
    def expects(self) -> str:
        return f"a number in {self.unit}" if self.unit else "a number"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> float | None:
        if not isinstance(node, ScalarNode) or not node.text.strip():
            self.reject(node, path, reading)
            return None
        tree = None if (value := _plain(node.text)) else reading.parse(node)
        value = value or reading.value(node, tree)
        if value is None:
            return None
        if self.unit is not None and value.dimension is not None and not agrees(self.unit, value.dimension):
            mine = f"is in {self.unit}" if self.unit else "has no unit"
            message = f"{label(path)} {mine}, this is {describe(value.dimension, with_unit=True)}"
            reading.report(message, node.place, unit_hint(node.text, tree))
            return None
        reading.units[path] = unit_text(self.unit, value.dimension)
        return self._bounded(value.number, node, path, reading)

    def _bounded(self, number: float, node: Node, path: KeyPath, reading: Reading) -> float | None:
        for name, words, holds in LIMITS:
            limit = getattr(self, name)
            if limit is not None and not holds(number, limit):
                reading.report(f"{label(path)} must be {words} {limit:g}, found {number:.6g}", node.place)
                return None
        if not self._is_usual(number):
            beyond = f"beyond {LARGEST:g} in SI units overflow when multiplied"
            below = f"below {1.0 / LARGEST:g} in SI units overflow when divided by"
            message = f"{label(path)} is {number:.6g}: numbers {beyond if abs(number) > LARGEST else below}"
            reading.report(message, node.place, "check the number and its unit")
            return None
        return number

    def _is_usual(self, number: float) -> bool:
        """Whether the number lies in a range where products do not overflow, nor quotients where it must be positive.
        Numbers without a unit that may have any sign pass: they are components of directions, or parts of values with
        bounds of their own."""
        if self.above == 0.0:
            return 1.0 / LARGEST <= number <= LARGEST
        return not self.unit or abs(number) <= LARGEST

    def schema(self) -> Schema:
        limits = {"minimum": self.minimum, "exclusiveMinimum": self.above, "maximum": self.maximum}
        given = {key: limit for key, limit in limits.items() if limit is not None}
        return {"description": self.expects, "type": ["number", "string"], "pattern": r"\S", **given}


@dataclass(frozen=True)
class PositionAngle(Number):
    """An angle in rad that gives a position: a number that looks like degrees is noted."""

    unit: str | None = "rad"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> float | None:
        number = super().read(node, path, reading)
        note_degrees(node, path, reading)
        return number


def position_in(unit: str) -> Number:
    """The field of a coordinate in m or rad."""
    return PositionAngle() if unit == "rad" else Number(unit)


#: A whole or half number without unit looks like degrees where, taken as radians, it is more than this many turns.
MANY_TURNS = 2.0


def note_degrees(node: Node, path: KeyPath, reading: Reading) -> None:
    """Note a plain number that looks like degrees: 90, but not 62.8319, 3 * pi or 90 rad."""
    try:
        number = float(node.text) if isinstance(node, ScalarNode) else 0.0
    except ValueError:
        return
    turns = abs(number) / (2.0 * math.pi)
    if MANY_TURNS < turns < math.inf and (2.0 * number).is_integer():
        assert isinstance(node, ScalarNode)
        message = f"{label(path)} is {number:g} rad, {turns:.3g} turns"
        hint = f"did you mean {number:g} deg? ({number:g} rad says that it is in radians)"
        reading.notes.append(Problem(message, node.place, hint))


def agrees(unit: str, dimension: Dimension | None) -> bool:
    """Whether a number of that dimension may stand where `unit` is wanted; "" wants a number without unit."""
    return dimension is None or (dimension_of(unit).agrees(dimension) and (bool(unit) or dimension == BARE))


def dimension_of(unit: str) -> Dimension:
    """The dimension of a unit; "" is no unit."""
    return unit_of(unit).dimension if unit else BARE


def unit_text(unit: str | None, dimension: Dimension | None) -> str:
    """The wanted `unit`; where that is None, the SI unit of the dimension `dimension`, "" for none."""
    if unit is not None:
        return unit
    return symbol_of(dimension) if dimension is not None and dimension != BARE else ""


def unit_hint(text: str, tree: Expression | None) -> str | None:
    """A hint for a quotient that ends in a unit, which belongs to the divisor alone, as in 360/7 deg; else None."""
    text = text.rstrip()
    if not isinstance(tree, Binary) or tree.operator != "/" or not isinstance(tree.right, QuantityNode):
        return None
    unit = tree.right
    return f"write ({text[: unit.at].strip()}) {unit.unit}" if unit.at + len(unit.unit) == len(text) else None


@dataclass(frozen=True)
class Integer(Field[int]):
    """A whole number without unit, at least `minimum`, that fits into 32 bits."""

    minimum: int
    maximum: int = 10**9

    @property
    def expects(self) -> str:
        return "a whole number"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> int | None:
        number = Number(minimum=self.minimum, maximum=self.maximum).read(node, path, reading)
        if number is None:
            return None
        if not number.is_integer():
            self.reject(node, path, reading)
            return None
        return int(number)

    def schema(self) -> Schema:
        return {
            **Number(minimum=self.minimum, maximum=self.maximum).schema(),
            "description": self.expects,
            "type": ["integer", "string"],
        }


#: Directions by name, as x or -z.
NAMED: Mapping[str, Vector] = MappingProxyType(
    {
        "x": (1.0, 0.0, 0.0),
        "y": (0.0, 1.0, 0.0),
        "z": (0.0, 0.0, 1.0),
        "-x": (-1.0, 0.0, 0.0),
        "-y": (0.0, -1.0, 0.0),
        "-z": (0.0, 0.0, -1.0),
    }
)


def vector(unit: str | None) -> List[float]:
    """The field of three numbers in `unit` (see `Number`)."""
    return List(Number(unit), 3)


POINT: Field[Any] = vector("m")


_BY_NUMBERS = Converted(vector(None), direction)


@final
@dataclass(frozen=True)
class Direction(Field[Vector]):
    """A unit vector, given by three numbers of any length or by the name of an axis. Messages ask for numbers."""

    @property
    def expects(self) -> str:
        return _BY_NUMBERS.expects

    def takes(self, node: Node) -> bool:
        return _is_name(node) or _BY_NUMBERS.takes(node)

    def fits(self, node: Node) -> bool:
        return _is_name(node) or _BY_NUMBERS.fits(node)

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Vector | None:
        if not isinstance(node, ScalarNode) or not node.text:
            return _BY_NUMBERS.read(node, path, reading)
        if node.text not in NAMED:
            hint = f"give {self.expects}, or {', '.join(NAMED)}"
            reading.report(f"unknown direction '{node.text}'", node.place, hint)
        return NAMED.get(node.text)

    def schema(self) -> Schema:
        return {"description": self.expects, "anyOf": [_BY_NUMBERS.schema(), {"enum": list(NAMED)}]}


def _is_name(node: Node) -> bool:
    return isinstance(node, ScalarNode) and bool(node.text)


DIRECTION: Field[Any] = Direction()


def rows(unit: str) -> List[tuple[float, ...]]:
    """The field of the rows of a 3 x 3 matrix."""
    return List(vector(unit), 3, "rows of 3 numbers")
