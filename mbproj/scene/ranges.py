"""Reads ranges, which are written as

0.8:1.2:41                 41 values from 0.8 to 1.2; with units: 0.8 m:120 cm:41
1:1000:4:log               4 values, evenly spaced by their logarithms
[1, 2, 4]                  values one by one; 1,2,4 on the command line
{linspace: [0.8, 1.2, 41]}, {log: [1, 1000, 4]}       the first two as mappings
{uniform: [0.8, 1.2]}, {normal: {mean: 1, deviation: 0.1}}       distributions
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.scene.expressions.dimensions import describe as in_words
from mbproj.scene.expressions.evaluate import Unavailable, Value, evaluate
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.expressions.units import Dimension
from mbproj.scene.fields.fields import Field, Schema
from mbproj.scene.fields.quantities import Integer
from mbproj.scene.fields.reading import Reading, label
from mbproj.scene.ranges.values import Item, Listed, Normal, Range, Spaced, Uniform
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode, describe, flow

#: The ranges that are mappings of one key: an example of the value, by the key.
FORMS: Mapping[str, str] = {
    "linspace": "[first, last, count]",
    "log": "[first, last, count]",
    "uniform": "[low, high]",
    "normal": "{mean: .., deviation: ..}",
}
LOGARITHMIC = "log"


class _Wrong(Exception):
    """A range is wrong, which is reported already."""


class RangeField(Field[Range]):
    """A range, in one of the forms in the text of this module."""

    @property
    def expects(self) -> str:
        return "a list of values, first:last:count, or one of {" + ", ".join(FORMS) + "}"

    def takes(self, node: Node) -> bool:
        return True

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Range | None:
        try:
            return self._read(node, path, reading)
        except _Wrong:
            return None

    def schema(self) -> Schema:
        return {"description": self.expects, "type": ["string", "number", "boolean", "array", "object"]}

    def _read(self, node: Node, path: KeyPath, reading: Reading) -> Range:
        match node:
            case ScalarNode() if ":" in node.text:
                return _spaced_text(node, path, reading)
            case ScalarNode() if node.text:
                return _read_list([node], path, reading)
            case SequenceNode() if node.items:
                return _read_list(node.items, path, reading)
            case MappingNode() if len(node.values) == 1:
                ((form, inside),) = node.values.items()
                if form in FORMS:
                    return _FORM[form](inside, (*path, form), reading)
                reading.report(f"unknown range '{form}'", node.keys[form], choose_from(form, FORMS))
                raise _Wrong
        self.reject(node, path, reading)
        raise _Wrong


RANGE = RangeField()


class BoundsField(Field[Uniform]):
    """[low, high]: the values between the two."""

    @property
    def expects(self) -> str:
        return FORMS["uniform"]

    def takes(self, node: Node) -> bool:
        return isinstance(node, SequenceNode)

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Uniform | None:
        try:
            return _uniform(node, path, reading)
        except _Wrong:
            return None

    def schema(self) -> Schema:
        return {"description": self.expects, "type": "array", "minItems": 2, "maxItems": 2}


BOUNDS = BoundsField()


def named_range(text: str, option: str) -> tuple[str, Range]:
    """The name and the range of the option's text NAME=RANGE. Raises InputError at the option."""
    name, equals, written = text.partition("=")
    if not equals or not name.strip() or not written.strip():
        raise InputError(Problem(f"'{text}' is not NAME=RANGE", Place(option), f"e.g. {option} length=0.8:1.2:5"))
    return name.strip(), given_range(written, f"{option} {name.strip()}")


def given_range(text: str, option: str) -> Range:
    """The range that the text of an option describes. Raises InputError at the option."""
    place, reading = Place(option), Reading()
    items = [] if ":" in text else [ScalarNode(part.strip(), place) for part in text.split(",")]
    node: Node = SequenceNode(tuple(items), place) if len(items) > 1 else ScalarNode(text.strip(), place)
    spread = RANGE.read(node, (option,), reading)
    if spread is None:
        raise InputError(reading.problems)
    return spread


def _read_list(nodes: Sequence[Node], path: KeyPath, reading: Reading) -> Listed:
    if any(isinstance(node, ScalarNode) and not node.text for node in nodes):
        reading.report(f"{label(path)} has an empty value", nodes[0].place, "leave the comma out, or give a value")
        raise _Wrong
    values = [_number(node) for node in nodes]
    items: list[Item] = [
        flow(node) if value is None else value.number for node, value in zip(nodes, values, strict=True)
    ]
    known = next((value.dimension for value in values if value is not None), None)
    return Listed(tuple(nodes), known, tuple(items))


def _number(node: Node) -> Value | None:
    """The value of a number; None for anything else: a word, a list, an expression of the scene's parameters."""
    if not isinstance(node, ScalarNode):
        return None
    try:
        return evaluate(parse(node.text, frozenset()), {})
    except (ExpressionError, Unavailable):
        return None


def _value(node: Node, path: KeyPath, reading: Reading) -> Value:
    """The value of a node that must be a number. Raises _Wrong where it is none, which is reported."""
    if not isinstance(node, ScalarNode) or not node.text.strip():
        reading.report(f"{label(path)} needs numbers, found {describe(node)}", node.place)
        raise _Wrong
    value = reading.value(node, reading.parse(node))
    if value is None:
        raise _Wrong
    return value


def _spaced_text(node: ScalarNode, path: KeyPath, reading: Reading) -> Spaced:
    parts, at = [], 0
    for text in node.text.split(":"):
        skipped = len(text) - len(text.lstrip())
        column = None if node.column is None else node.column + at + skipped
        parts.append(ScalarNode(text.strip(), node.place_at(at + skipped), column))
        at += len(text) + 1
    logarithmic = parts[-1].text == LOGARITHMIC
    return _spaced(parts[: -1 if logarithmic else None], node, path, reading, logarithmic)


def _spaced_form(node: Node, path: KeyPath, reading: Reading) -> Spaced:
    items = node.items if isinstance(node, SequenceNode) else ()
    return _spaced(items, node, path, reading, logarithmic=path[-1] == LOGARITHMIC)


def _spaced(parts: Sequence[Node], node: Node, path: KeyPath, reading: Reading, logarithmic: bool) -> Spaced:
    if len(parts) != 3:
        _refuse(FORMS["linspace"] if isinstance(node, SequenceNode) else "first:last:count", node, path, reading)
    first, last = (_value(part, path, reading) for part in parts[:2])
    count = Integer(2).read(parts[2], (*path, "count"), reading)
    if count is None:
        raise _Wrong
    if logarithmic and not (first.number > 0.0 and last.number > 0.0):
        reading.report(f"{label(path)} needs numbers above 0 for their logarithms", node.place)
        raise _Wrong
    return Spaced(
        tuple(parts[:2]), _one_dimension(first, last, parts[1], reading), first.number, last.number, count, logarithmic
    )


def _uniform(node: Node, path: KeyPath, reading: Reading) -> Uniform:
    if not isinstance(node, SequenceNode) or len(node.items) != 2:
        _refuse(FORMS["uniform"], node, path, reading)
    low, high = (_value(part, path, reading) for part in node.items)
    if not low.number < high.number:
        reading.report(f"{label(path)} has nothing between {low.number:g} and {high.number:g}", node.place)
        raise _Wrong
    return Uniform(node.items, _one_dimension(low, high, node.items[1], reading), low.number, high.number)


def _normal(node: Node, path: KeyPath, reading: Reading) -> Normal:
    if not isinstance(node, MappingNode) or set(node.values) != {"mean", "deviation"}:
        _refuse(FORMS["normal"], node, path, reading)
    mean, deviation = (_value(node.values[key], (*path, key), reading) for key in ("mean", "deviation"))
    if not deviation.number > 0.0:
        reading.report(
            f"'deviation' must be greater than 0, found {deviation.number:g}", node.values["deviation"].place
        )
        raise _Wrong
    dimension = _one_dimension(mean, deviation, node.values["deviation"], reading)
    return Normal((node.values["mean"],), dimension, mean.number, deviation.number)


def _refuse(expected: str, node: Node, path: KeyPath, reading: Reading) -> NoReturn:
    reading.report(f"{label(path)} needs {expected}, found {describe(node)}", node.place)
    raise _Wrong


def _one_dimension(first: Value, second: Value, node: Node, reading: Reading) -> Dimension | None:
    """The common dimension of both values; a number without unit takes that of the other. Raises _Wrong where they
    differ, which is reported."""
    one, two = first.dimension, second.dimension
    if one is not None and two is not None and not one.agrees(two):
        reading.report(f"{in_words(one)} and {in_words(two)} are no range", node.place)
        raise _Wrong
    return max((one, two), key=lambda dimension: any(dimension or ()))


_FORM: Mapping[str, Any] = {
    "linspace": _spaced_form,
    "log": _spaced_form,
    "uniform": _uniform,
    "normal": _normal,
}
