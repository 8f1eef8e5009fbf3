"""Fields of expressions that name coordinates, signals and states, and the units of such expressions."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.expressions.dimensions import Found, called
from mbproj.scene.expressions.evaluate import RESERVED
from mbproj.scene.expressions.units import BARE, Dimension
from mbproj.scene.fields.fields import Field, Schema
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node

#: Names that no signal or state may have, since expressions use them for constants, functions and coordinates.
NOT_FREE = RESERVED | {"s", "l"} | {*COORDINATES} | {f"{name}_dot" for name in ("s", "l", *COORDINATES)}
EXPRESSION = Function(None, names_channels=True)


@dataclass(frozen=True)
class _Expression(Field["tuple[Program, Found]"]):
    """A function of channels (coordinates, signals, states), with its dimension."""

    @property
    def expects(self) -> str:
        return "an expression of t, coordinates, signals and states"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[Program, Found] | None:
        return EXPRESSION.with_dimension(node, path, reading)

    def schema(self) -> Schema:
        return {**EXPRESSION.schema(), "description": self.expects}


def unit_name(dimension: Dimension | None) -> str:
    """The name of the SI unit in results; "" where the dimension is not known, or a number has no unit."""
    return "" if dimension is None or dimension == BARE else called(dimension)


VALUE = _Expression()
