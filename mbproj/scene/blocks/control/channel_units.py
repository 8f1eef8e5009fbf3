"""The dimensions of what expressions name: coordinates, markers, forces; signals and states with a declared unit."""

from __future__ import annotations

from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.elements import ELEMENTS, SPRINGS, element_type
from mbproj.scene.expressions.evaluate import Unavailable, evaluate
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.expressions.units import BARE, TIME, Dimension, unit_at
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.fields.reading import Reading
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode

#: The keys of a state, or of what a controller holds, whose numbers declare its unit.
DECLARING = ("initial", "scale")


def dimension_in(root: MappingNode, name: str, reading: Reading) -> Dimension | None:
    """The dimension of what an expression in the scene `root` calls by this name; None where it is not known."""
    name = reading.inner.get(name, name)
    item, _, part = name.rpartition(".")
    if not item:
        return _of_signal(root, name) or _of_state(_at(root, "states", name), reading)
    coordinate = part.removesuffix("_dot")
    unit = None
    if _at(root, "joints", item) is not None:
        unit = COORDINATES.get(coordinate)
    elif _at(root, "markers", item) is not None:
        unit = "m" if coordinate in ("x", "y", "z") else None
    elif (controller := _at(root, "controllers", item)) is not None:
        held = (_at(controller, block, part) for block in ("hold", "states"))
        return next((_of_state(each, reading) for each in held if each is not None), None)
    else:
        return _of_force(root, item, part)
    if unit is None:
        return None
    dimension = dimension_of(unit)
    return dimension * TIME**-1 if part.endswith("_dot") else dimension


def _of_signal(root: MappingNode, name: str) -> Dimension | None:
    """The dimension of a signal's declared unit. A text that is no unit is reported where it is read."""
    unit = _at(_at(root, "signals", name), "unit")
    found = unit_at(unit.text, 0) if isinstance(unit, ScalarNode) else None
    return None if found is None else found[0].dimension


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


def _of_force(root: MappingNode, name: str, part: str) -> Dimension | None:
    """The dimension of "spring.force", "spring.length" and its rate, and "motor.current", a state of an element."""
    force = _at(root, "forces", name)
    force = _at(root, "forces", name.rpartition(".")[0]) if force is None else force  # "door.angle.force"
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
    """The node at these keys, where an expression writes _ for a hyphen; None where there is none."""
    for key in keys:
        if not isinstance(node, MappingNode):
            return None
        inside = node.values.get(key)
        if inside is None and "_" in key:
            inside = next((each for name, each in node.values.items() if name.replace("-", "_") == key), None)
        node = inside
    return node
