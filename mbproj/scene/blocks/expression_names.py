"""The dimensions of what expressions name: coordinates, markers, forces; signals and states with a declared unit."""

from __future__ import annotations

from collections.abc import Mapping

from mbproj.base.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.elements import ELEMENTS, SPRINGS, element_type
from mbproj.scene.expressions.dimensions import Inferred, called
from mbproj.scene.expressions.evaluate import RESERVED, Unavailable, evaluate
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.expressions.units import BARE, TIME, Dimension, unit_at
from mbproj.scene.fields.fields import Field, Schema
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode

#: The keys of a state, or of what a controller holds, whose numbers declare its unit.
DECLARING = ("initial", "scale")


#: The items of each block by their names in expressions, which write _ for a hyphen.
Items = dict[str, Mapping[str, Node]]


def dimension_in(root: MappingNode, items: Items, name: str, reading: Reading) -> Dimension | None:
    """The dimension of what an expression in the scene `root` calls by this name; None where it is not known. `items`
    is empty at first, and is filled here."""

    def item(block: str, name: str) -> Node | None:
        if block not in items:
            mapping = _at(root, block)
            values = mapping.values.items() if isinstance(mapping, MappingNode) else ()
            items[block] = {key.replace("-", "_"): node for key, node in values}
        return items[block].get(name)

    owner, _, part = reading.inner.get(name, name).rpartition(".")
    if not owner:
        return _of_signal(item("signals", part)) or _of_state(item("states", part), reading)
    coordinate, unit = part.removesuffix("_dot"), None
    if item("joints", owner) is not None:
        unit = COORDINATES.get(coordinate)
    elif item("markers", owner) is not None:
        unit = "m" if coordinate in ("x", "y", "z") else None
    elif (controller := item("controllers", owner)) is not None:
        held = (_at(controller, block, part) for block in ("hold", "states"))
        return next((_of_state(each, reading) for each in held if each is not None), None)
    else:
        force = item("forces", owner)
        return _of_force(item("forces", owner.rpartition(".")[0]) if force is None else force, part)
    if unit is None:
        return None
    dimension = dimension_of(unit)
    return dimension * TIME**-1 if part.endswith("_dot") else dimension


def _of_signal(node: Node | None) -> Dimension | None:
    """The dimension of a signal's declared unit. A text that is no unit is reported where it is read."""
    unit = _at(node, "unit")
    parsed = unit_at(unit.text, 0) if isinstance(unit, ScalarNode) else None
    return None if parsed is None else parsed[0].dimension


def _of_state(node: Node | None, reading: Reading) -> Dimension | None:
    """The dimension of the numbers that a state begins with and is scaled by; None where they have no unit."""
    for key in DECLARING:
        number = _at(node, key)
        if isinstance(number, ScalarNode):
            try:
                dimension = evaluate(parse(number.text, frozenset(reading.names)), reading.names).dimension
            except (ExpressionError, Unavailable):  # reported where the number is read
                continue
            if dimension not in (None, BARE):
                return dimension
    return None


def _of_force(force: Node | None, part: str) -> Dimension | None:
    """The dimension of "spring.force", "spring.length" and its rate, and "motor.current", a state of an element."""
    if force is None:
        return None
    if part in ("length", "length_dot"):
        return dimension_of("m" if part == "length" else "m/s")
    kind = _at(force, "type")
    if not isinstance(kind, ScalarNode) or not (kind.text in SPRINGS or kind.text in ELEMENTS):
        return None
    if part == "force":
        return dimension_of("N*m" if element_type(kind.text).along == "rad" else "N")
    unit = element_type(kind.text).states.get(part)
    return None if unit is None else dimension_of(unit)


def _at(node: Node | None, *keys: str) -> Node | None:
    """The node at these keys; None where there is none."""
    for key in keys:
        node = node.values.get(key) if isinstance(node, MappingNode) else None
    return node


# --- Fields of expressions --------------------------------------------------------------------------------------------
# Fields of expressions that name coordinates, signals and states, and the units of such expressions.


#: Names that no signal or state may have, since expressions use them for constants, functions and coordinates.
NOT_FREE = RESERVED | {"s", "l"} | {*COORDINATES} | {f"{name}_dot" for name in ("s", "l", *COORDINATES)}
EXPRESSION = Function(None, names_channels=True)


@dataclass(frozen=True)
class _Expression(Field["tuple[Program, Inferred]"]):
    """A function of channels (coordinates, signals, states), with its dimension."""

    @property
    def expects(self) -> str:
        return "an expression of t, coordinates, signals and states"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[Program, Inferred] | None:
        return EXPRESSION.with_dimension(node, path, reading)

    def schema(self) -> Schema:
        return {**EXPRESSION.schema(), "description": self.expects}


def unit_name(dimension: Dimension | None) -> str:
    """The name of the SI unit in results; "" where the dimension is not known, or a number has no unit."""
    return "" if dimension is None or dimension == BARE else called(dimension)


VALUE = _Expression()
