"""Ranges of a quantity: values one by one, evenly spaced ones, a distribution; read from files and the command line."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from math import exp, log
from pathlib import Path
from statistics import NormalDist
from typing import Any, NoReturn, TypeAlias

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.scene.expressions.dimensions import describe as in_words
from mbproj.scene.expressions.dimensions import symbol_of
from mbproj.scene.expressions.evaluate import Unavailable, Value, evaluate
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.expressions.units import BARE, Dimension
from mbproj.scene.fields.fields import Field, Record, Schema
from mbproj.scene.fields.quantities import Integer
from mbproj.scene.fields.reading import Reading, in_text_order, label
from mbproj.scene.records import KeyPath
from mbproj.scene.scene import Scene, SceneText
from mbproj.scene.text.document import compose, read_text
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode, describe, flow

# --- Ranges as records ------------------------------------------------------------------------------------------------
# Those with a finite number of values, and distributions, which are sampled.


#: A value: a number in SI, or a word, or a list or mapping in YAML's flow style.
Item: TypeAlias = "float | str"


@dataclass(frozen=True)
class Range(ABC):
    """A range of a quantity. `nodes` are its values as written, which the reader of the quantity checks; `dimension` is
    that of its numbers, None where it is not known."""

    nodes: tuple[Node, ...] = field(repr=False, compare=False)
    dimension: Dimension | None

    @abstractmethod
    def quantile(self, share: float) -> Item:
        """The value below which this share of samples lies, 0 < share < 1; `Points` are sampled evenly."""


@dataclass(frozen=True)
class Points(Range):
    """A range with a finite number of values."""

    @property
    @abstractmethod
    def count(self) -> int:
        """The number of values."""

    @abstractmethod
    def item(self, number: int) -> Item:
        """The value with this number, from 0."""

    @property
    def items(self) -> tuple[Item, ...]:
        """All values, in order."""
        return tuple(map(self.item, range(self.count)))


@dataclass(frozen=True)
class Listed(Points):
    """A range of values that are listed one by one."""

    listed: tuple[Item, ...]

    @property
    def count(self) -> int:
        return len(self.listed)

    def item(self, number: int) -> Item:
        return self.listed[number]

    def quantile(self, share: float) -> Item:
        return self.listed[min(int(share * len(self.listed)), len(self.listed) - 1)]


@dataclass(frozen=True)
class Spaced(Points):
    """`count` values from `first` to `last`, evenly spaced, or evenly by their logarithms."""

    first: float
    last: float
    steps: int
    logarithmic: bool = False

    @property
    def count(self) -> int:
        return self.steps

    def item(self, number: int) -> float:
        if number == self.steps - 1:
            return self.last
        return self.quantile(number / (self.steps - 1)) if number else self.first

    def quantile(self, share: float) -> float:
        if self.logarithmic:
            return exp(log(self.first) + share * (log(self.last) - log(self.first)))
        return self.first + share * (self.last - self.first)


@dataclass(frozen=True)
class Uniform(Range):
    """The uniform distribution between `low` and `high`."""

    low: float
    high: float

    def quantile(self, share: float) -> float:
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class Normal(Range):
    """The normal distribution of this mean and standard deviation."""

    mean: float
    deviation: float

    def quantile(self, share: float) -> float:
        return NormalDist(self.mean, self.deviation).inv_cdf(share)


# --- Ranges as they are written ---------------------------------------------------------------------------------------
#     0.8:1.2:41                                             41 values from 0.8 to 1.2; with units: 0.8 m:120 cm:41
#     1:1000:4:log                                           4 values, evenly spaced by their logarithms
#     [1, 2, 4]                                              values one by one; 1,2,4 on the command line
#     {linspace: [0.8, 1.2, 41]}, {log: [1, 1000, 4]}        the first two as mappings
#     {uniform: [0.8, 1.2]}, {normal: {mean: 1, deviation: 0.1}}    distributions


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


# --- Reads the file of a study of many variants of a scene ------------------------------------------------------------
# The scene that it names, and the units of the varied values.


def read_mapping(path: Path, what: str, begins: str) -> tuple[str, MappingNode, Reading]:
    """The text of the file, its mapping, and a new reading for it. Raises InputError where it is no mapping: `what` is
    the kind of file, as "a sweep", and `begins` its usual first line."""
    text = read_text(path)
    root, problems = compose(text, str(path))
    if not isinstance(root, MappingNode):
        raise InputError(Problem(f"{what} is a mapping of keys, found {describe(root)}", root.place, begins))
    return text, root, Reading(places={(): root.place}, problems=list(problems))


def scene_named(path: Path, root: MappingNode, reading: Reading, record: Record[Any]) -> tuple[SceneText, Scene]:
    """The scene that the file's key `scene` names: its text, taken apart, and the scene without changes. Raises
    InputError where there is no such scene, with the other faults that `record` finds, or where the scene is wrong."""
    node = root.values.get("scene")
    if not isinstance(node, ScalarNode) or not node.text:
        record.read(root, (), reading)
        raise InputError(in_text_order(reading.problems))
    where = path.parent / node.text
    try:
        text = SceneText(read_text(where), str(where), where)
    except InputError as error:
        problems = [_at(problem, str(where), node) for problem in error.problems]
        raise InputError(problems) from error
    return text, text.scene()


def _at(problem: Problem, scene: str, node: ScalarNode) -> Problem:
    """The problem; one of the scene as a whole is placed at the key that names the scene."""
    if problem.place is None or problem.place.line is not None:
        return problem
    return replace(problem, message=f"scene '{scene}': {problem.message}", place=node.place)


def column_of(path: str) -> str:
    """The name in tables of a quantity that varies: a parameter's name, or the path of another value."""
    return path.removeprefix("parameters.")


def with_unit(name: str, unit: str) -> str:
    """The heading of a column: the name, with its unit in brackets."""
    return f"{name} ({unit})" if unit else name


def units_of(dimensions: Mapping[str, Dimension | None], scene: SceneText) -> dict[str, str]:
    """The SI units of the quantities that vary, by path: as the scene has them, or from the dimensions of the values
    `dimensions`. "" is none."""
    known = {".".join(map(str, path)): unit for path, unit in scene.units().items()}
    units = {}
    for path, dimension in dimensions.items():
        symbol = symbol_of(dimension) if dimension is not None and dimension != BARE else ""
        units[path] = known.get(path) or known.get(f"parameters.{path}") or symbol
    return units
