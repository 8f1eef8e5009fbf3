"""Fields of numbers: one in a unit, within bounds, whole; and three, as points, directions, the rows of a matrix."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, TypeVar, final

from mbproj.base.cases import per_case
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, did_you_mean
from mbproj.scene.expressions.dimensions import describe, symbol_of
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.syntax_tree import Binary, Expression, QuantityNode
from mbproj.scene.expressions.units import BARE, Dimension, unit_of
from mbproj.scene.fields import rotations
from mbproj.scene.fields.fields import Complaint, Converted, Field, List, Schema
from mbproj.scene.fields.reading import Reading, Unfit, label
from mbproj.scene.records import KeyPath, Matrix, Pair, Quaternion, Vector
from mbproj.scene.text.nodes import Node, ScalarNode, from_value

# --- Rules on single values, which convert them for the records or raise Unfit ----------------------------------------
# Rules on several values of an item.


#: A point or direction as read: global for both bodies, or one by body in that body's axes.
Placed = Pair | Mapping[str, Vector]

#: The sine below which two axes count as parallel.
PARALLEL = 1e-9


def direction(vector: Vector) -> Vector:
    """The unit vector along `vector`."""
    unit_vector = rotations.unit(vector)
    if unit_vector is None:
        raise Unfit("is a zero vector", "a direction needs a length")
    x, y, z = unit_vector
    return (x, y, z)


def unit_quaternion(quaternion: Quaternion) -> Quaternion:
    """The quaternion divided by its norm. Raises Unfit where that is 0."""
    normalised = rotations.unit(quaternion)
    if normalised is None:
        raise Unfit("is zero", "write [1, 0, 0, 0] for no rotation")
    w, x, y, z = normalised
    return (w, x, y, z)


def orientation_of(matrix: Matrix) -> Quaternion:
    """The quaternion of a rotation matrix. Raises Unfit for another matrix."""
    error = rotations.orthonormality_error(matrix)
    if not error <= rotations.ORTHONORMAL:
        raise Unfit(f"is not orthonormal (off by {error:.2g})", "give 7 digits, or expressions like cos(30 deg)")
    if rotations.determinant(matrix) < 0:
        raise Unfit("is a reflection: its determinant is -1", "its columns are the body's axes, right-handed")
    return rotations.from_matrix(matrix)


def inertia_of(matrix: Matrix) -> Matrix:
    """The inertia tensor, made exactly symmetric. Raises Unfit where no body can have it."""
    symmetric = rotations.symmetric(matrix)
    if symmetric is None:
        raise Unfit("is not symmetric", "Ixy stands in row 1, column 2 and in row 2, column 1")
    reason = rotations.impossible(symmetric)
    if reason is not None:
        raise Unfit(reason, "it is about the centre of mass, in kg m^2")
    return symmetric


def different(names: tuple[str, ...]) -> tuple[str, ...]:
    """The names. Raises Unfit where one is repeated."""
    for at, name in enumerate(names):
        if name in names[:at]:
            count = {2: "two", 3: "three"}[len(names)]
            raise Unfit(f"names '{name}' twice", f"give {count} different ones")
    return names


def nonzero(number: float) -> float:
    """The number. Raises Unfit where it is zero."""
    if number == 0.0:
        raise Unfit("is zero")
    return number


def tooth_count(number: float) -> float:
    """The number of teeth, whose sign says which way the wheel turns. Raises Unfit where it is not whole, or zero."""
    if number == 0.0 or not number.is_integer():
        raise Unfit(
            f"has {number:g} for a number of teeth", "give a whole number; a negative one is an internal gear or a belt"
        )
    return number


def slot_count(number: float) -> float:
    """The number of slots. Raises Unfit where it is not whole, or leaves no room for a pin between them."""
    if number < 3.0 or not number.is_integer():
        raise Unfit(f"has {number:g} for a number of slots", "give a whole number, 3 or more")
    return number


def two_points(points: tuple[Vector, Vector]) -> Pair:
    """The pair of global points, the first on the first body. Raises Unfit where they are the same."""
    if points[0] == points[1]:
        raise Unfit("are one point", "give two points, or use a spherical joint")
    return Pair(*points)


@per_case
def _sine(first: Vector, second: Vector) -> float:
    """The sine of the angle between two unit vectors."""
    return math.hypot(*rotations.cross(first, second))


def two_axes(axes: tuple[Vector, Vector]) -> Pair:
    """The pair of global axes. Raises Unfit where they are parallel."""
    if _sine(*axes) <= PARALLEL:
        raise Unfit("are parallel", "the two axes must span a plane")
    return Pair(*axes)


def global_pair(vector: Vector) -> Pair:
    """The pair of one global vector for both bodies."""
    return Pair(vector, vector)


def pair_of(placed: Placed, bodies: tuple[str, str]) -> Pair:
    """The pair in the order of `bodies`; where only the first body has a vector, it stands for both."""
    if isinstance(placed, Pair):
        return placed
    return Pair(placed[bodies[0]], placed.get(bodies[1], placed[bodies[0]]), local=True)


def of_these_bodies(
    key: str, alone: bool = False
) -> Callable[[tuple[str, str] | str, Placed | Vector], Iterator[Complaint]]:
    """A check that a mapping by body under `key` has exactly the item's bodies, one or two. With `alone` it may have
    the first of two only."""

    def find(bodies: tuple[str, str] | str, placed: Placed | Vector) -> Iterator[Complaint]:
        wanted = (bodies,) if isinstance(bodies, str) else bodies[:1] if alone else bodies
        if not isinstance(placed, Mapping):
            return
        needs = f"it is given for {' and '.join(repr(name) for name in wanted)}"
        for name in placed:
            if name not in wanted:
                hint = did_you_mean(name, wanted) or needs
                yield Complaint((key, name), f"unexpected '{name}' in '{key}'", hint)
        for name in wanted:
            if name not in placed:
                yield Complaint((key,), f"'{key}' lacks '{name}'", needs)

    return find


def same_kind(point: str, key: str) -> Callable[[Placed, Placed], Iterator[Complaint]]:
    """A check that the points under `point` and the axes under `key` are both global or both by body."""

    def find(location: Placed, axes: Placed) -> Iterator[Complaint]:
        if isinstance(location, Pair) != isinstance(axes, Pair):
            kinds = ("global", "by body") if isinstance(axes, Pair) else ("by body", "global")
            yield Complaint(
                (key,),
                f"'{key}' is {kinds[0]} but '{point}' is {kinds[1]}",
                "give both as lists (global), or both by body in the bodies' axes",
            )

    return find


def not_along(key: str) -> Callable[[Placed | Vector, Placed | Vector], Iterator[Complaint]]:
    """A check that the direction under `key` is not along the joint's axis."""

    def by_body(direction: Placed | Vector) -> Mapping[str, Vector]:
        if isinstance(direction, Mapping):
            return direction
        return {"": direction.first if isinstance(direction, Pair) else direction}

    def find(axis: Placed | Vector, other: Placed | Vector) -> Iterator[Complaint]:
        first, second = by_body(axis), by_body(other)
        if any(_sine(first[name], x) <= PARALLEL for name, x in second.items() if name in first):
            yield Complaint((key,), f"'{key}' is along the axis", "give a direction across it")

    return find


# --- Fields of numbers ------------------------------------------------------------------------------------------------


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
        bounds = {key: limit for key, limit in limits.items() if limit is not None}
        return {"description": self.expects, "type": ["number", "string"], "pattern": r"\S", **bounds}


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


# --- Numbers that are given on the command line or from Python --------------------------------------------------------
# Read by the same rules as those of a scene.


Read = TypeVar("Read")


def given_number(text: object, option: str, field: Field[Read]) -> Read:
    """Read `text`, or a number (of NumPy, too), by the field of a scene; the result is in SI units.

    Raises InputError at the option.
    """
    reading = Reading()
    number = field.read(from_value(text, Place(option)), (option,), reading)
    if number is None:
        raise InputError(reading.problems)
    return number
