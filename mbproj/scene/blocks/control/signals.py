"""The `signals` and `states` blocks: expressions by name, and what follows from a derivative.

signals: {error: 1 rad - pin.angle, U: {value: 20*error + 30*integral, unit: V}}
states:  {integral: {derivative: error}, current: {derivative: (U - 0.8*current)/2e-3, initial: 0 A, scale: 1 A}}
"""

from __future__ import annotations

from typing import Any

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import ScalarState, Signal
from mbproj.functions.program import Program
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.expectations import MEASURE, Measure
from mbproj.scene.expressions.evaluate import FUNCTIONS, RESERVED, Value
from mbproj.scene.expressions.syntax_tree import Binary, Call, Expression, Name, Negative, Quantity
from mbproj.scene.expressions.unit_text import unit_at, unit_of
from mbproj.scene.expressions.units import BARE, TIME, Dimension, called, describe
from mbproj.scene.fields.alternatives import Alternatives
from mbproj.scene.fields.containers import Record
from mbproj.scene.fields.fields import Converted, Field, Schema, Text
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.fields.reading import Reading, Unfit
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


def _unit(text: str) -> str:
    """A unit of SI as results call it."""
    found = unit_at(text, 0)
    if found is None or text[found[1] :].strip():
        raise Unfit(f"is '{text}', which is no unit", "write it as in kg*m^2/s, V, A or bar")
    if (found[0].multiply, found[0].divide) != (1.0, 1.0):
        raise Unfit(f"is '{text}', which is not of SI", f"signals are in SI: {called(found[0].dimension)}")
    return called(found[0].dimension)


def _signal(name: str, value: tuple[Program, Dimension | None], unit: str | None = None) -> Signal:
    program, dimension = value
    return Signal(name, program, named(dimension) if unit is None else unit)


def named(dimension: Dimension | None) -> str:
    """The unit that results name; "" where it is not known."""
    return "" if dimension is None or dimension == BARE else called(dimension)


@dataclass(frozen=True)
class _Alone(Field[Signal]):
    """A signal that is nothing but its expression."""

    @property
    def expects(self) -> str:
        return VALUE.expects

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Signal | None:
        found = VALUE.read(node, path, reading)
        return None if found is None else _signal(str(path[-1]), found)

    def schema(self) -> Schema:
        return VALUE.schema()


VALUE = _Expression()
SIGNAL_KEYS: dict[str, Field[Any]] = {"value": VALUE, "unit": Converted(Text(), _unit)}
SIGNAL: Field[Signal] = Alternatives(
    (
        _Alone(),
        Record("a signal", SIGNAL_KEYS, _signal, ("value",), named=True),
    )
)


def _state(
    name: str,
    derivative: tuple[Program, Dimension | None],
    initial: Value | None = None,
    scale: Value | None = None,
) -> ScalarState:
    """Its unit is that of its numbers, or of its derivative times a second."""
    rate, of_rate = derivative
    given = [each.dimension for each in (initial, scale) if each is not None and each.dimension not in (None, BARE)]
    found = given[0] if given else None
    for other in given[1:]:
        if found is not None and other is not None and not found.agrees(other):
            raise Unfit(f"begins with {describe(found)} and has a scale that is {describe(other)}")
    if of_rate is not None and of_rate != BARE:
        integrated = of_rate * TIME
        if found is not None and not found.agrees(integrated):
            raise Unfit(f"is {describe(found)}, and its derivative is {describe(of_rate)}", "check the units of both")
        found = found or integrated
    return ScalarState(
        name, rate, 0.0 if initial is None else initial.number, 1.0 if scale is None else scale.number, named(found)
    )


STATE_KEYS: dict[str, Field[Any]] = {"derivative": VALUE, "initial": MEASURE, "scale": Measure(above=0.0)}
STATE: Record[ScalarState] = Record("a state", STATE_KEYS, _state, ("derivative",), named=True)
