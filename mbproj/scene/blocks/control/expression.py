"""Fields of expressions that name coordinates, signals and states, and the units of such expressions."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.expressions.evaluate import FUNCTIONS, RESERVED
from mbproj.scene.expressions.syntax_tree import Binary, Call, Expression, NameNode, Negative, QuantityNode
from mbproj.scene.expressions.unit_text import unit_of
from mbproj.scene.expressions.units import BARE, Dimension, called
from mbproj.scene.fields.fields import Field, Schema
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, ScalarNode

#: Names that no signal or state may have, since expressions use them for constants, functions and coordinates.
NOT_FREE = RESERVED | {"s", "l"} | {*COORDINATES} | {f"{name}_dot" for name in ("s", "l", *COORDINATES)}
EXPRESSION = Function(None, names_channels=True)


@dataclass(frozen=True)
class _Expression(Field["tuple[Program, Dimension | None]"]):
    """A function of channels (coordinates, signals, states), with its dimension where its terms tell that."""

    @property
    def expects(self) -> str:
        return "an expression of t, coordinates, signals and states"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[Program, Dimension | None] | None:
        program = EXPRESSION.read(node, path, reading)
        if program is None or not isinstance(node, ScalarNode):
            return None
        tree = reading.parse(node)
        return program, None if tree is None else _dimension_of(tree)

    def schema(self) -> Schema:
        return {**EXPRESSION.schema(), "description": self.expects}


def _dimension_of(tree: Expression) -> Dimension | None:
    """The dimension of an expression, from the first term of a sum, or argument of a function, that tells it: a number
    with a unit, or a coordinate. None where none does."""
    match tree:
        case QuantityNode():
            return unit_of(tree.unit).dimension
        case Negative():
            return _dimension_of(tree.operand)
        case Binary() if tree.operator in "+-":
            return _dimension_of(tree.left) or _dimension_of(tree.right)
        case Call() if tree.function in FUNCTIONS and FUNCTIONS[tree.function].keeps_dimension:
            return next((dimension for each in tree.arguments if (dimension := _dimension_of(each))), None)
        case NameNode() if "." in tree.name:
            return _of_coordinate(tree.name)
        case _:
            return None


def _of_coordinate(name: str) -> Dimension | None:
    """The dimension of the channel "item.part": a joint's coordinate, a marker's x, y or z, a length, or the rate of
    one. None for other parts."""
    part = name.rpartition(".")[2]
    coordinate = part.removesuffix("_dot")
    unit = COORDINATES.get(coordinate, "m" if coordinate in ("x", "y", "z", "length") else None)
    if unit is None:
        return None
    return dimension_of(f"{unit}/s" if part.endswith("_dot") else unit)


def unit_name(dimension: Dimension | None) -> str:
    """The name of the SI unit in results; "" where the dimension is not known, or a number has no unit."""
    return "" if dimension is None or dimension == BARE else called(dimension)


VALUE = _Expression()
