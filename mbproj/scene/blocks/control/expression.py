"""Expressions that name what moves, as fields, and the unit that their numbers give them."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.expressions.evaluate import FUNCTIONS, RESERVED
from mbproj.scene.expressions.syntax_tree import Binary, Call, Expression, Name, Negative, Quantity
from mbproj.scene.expressions.unit_text import unit_of
from mbproj.scene.expressions.units import BARE, Dimension, called
from mbproj.scene.fields.fields import Field, Schema
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, ScalarNode

#: Names that no signal or state may have: they mean something in expressions of forces.
NOT_FREE = RESERVED | {"s", "l"} | {*COORDINATES} | {f"{name}_dot" for name in ("s", "l", *COORDINATES)}
EXPRESSION = Function(None, names_channels=True)


@dataclass(frozen=True)
class _Expression(Field["tuple[Program, Dimension | None]"]):
    """A function that names channels, and the dimension that its numbers with a unit give it."""

    @property
    def expects(self) -> str:
        return "an expression of t, coordinates, signals and states"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[Program, Dimension | None] | None:
        program = EXPRESSION.read(node, path, reading)
        if program is None or not isinstance(node, ScalarNode):
            return None
        tree = reading.parse(node)
        return program, None if tree is None else told(tree)

    def schema(self) -> Schema:
        return {**EXPRESSION.schema(), "description": self.expects}


def told(tree: Expression) -> Dimension | None:
    """The dimension of what is added or chosen from, where one of it tells: a number with a unit, a coordinate."""
    match tree:
        case Quantity():
            return unit_of(tree.unit).dimension
        case Negative():
            return told(tree.operand)
        case Binary() if tree.operator in "+-":
            return told(tree.left) or told(tree.right)
        case Call() if tree.function in FUNCTIONS and FUNCTIONS[tree.function].keeps_dimension:
            return next((found for each in tree.arguments if (found := told(each))), None)
        case Name() if "." in tree.name:
            return _of_coordinate(tree.name)
        case _:
            return None


def _of_coordinate(name: str) -> Dimension | None:
    """The dimension of a coordinate or its rate, of a marker's place, of a length."""
    what = name.rpartition(".")[2]
    own = what.removesuffix("_dot")
    unit = COORDINATES.get(own, "m" if own in ("x", "y", "z", "length") else None)
    if unit is None:
        return None
    return dimension_of(f"{unit}/s" if what.endswith("_dot") else unit)


def named(dimension: Dimension | None) -> str:
    """The unit that results name; "" where it is not known."""
    return "" if dimension is None or dimension == BARE else called(dimension)


VALUE = _Expression()
