"""Fields that are functions: expressions of time, or of a coordinate and its rate, and tables."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Set
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any, ClassVar

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import did_you_mean
from mbproj.functions.program import CHANNELS, COORDINATE, RATE, TIME, Program
from mbproj.functions.table import CubicTable, periodic, polygon, spline
from mbproj.scene.expressions.dimensions import OF_TIME, Inferred, Origin, describe
from mbproj.scene.expressions.evaluate import CONSTANTS
from mbproj.scene.expressions.syntax_tree import Expression, NameNode, names, walk
from mbproj.scene.expressions.units import ANGLE, BARE, SYMBOLS
from mbproj.scene.fields.fields import Alternatives, Converted, Field, List, NameChoice, Record, Schema
from mbproj.scene.fields.quantities import Number, dimension_of, note_degrees, unit_hint, unit_text
from mbproj.scene.fields.reading import Reading, Unfit, label
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, ScalarNode, SequenceNode


@dataclass(frozen=True)
class Function(Field[Program]):
    """A number in `unit` (None: any), from an expression that may name `variables` beside parameters: the time, and in
    the law of a force its coordinate and its rate. Programs know these by the numbers `operands`; `units` are those of
    the variables, where they are known. With `names_channels` the expression may also name signals, states, and names
    with a point, as pin.angle."""

    unit: str | None
    variables: tuple[str, ...] = ("t",)
    operands: tuple[int, ...] = (TIME, COORDINATE, RATE)
    units: tuple[str, ...] = ("s",)
    names_channels: bool = False

    @property
    def expects(self) -> str:
        number = f"a number in {self.unit}" if self.unit else "a number"
        return f"{number} or an expression of {', '.join(self.variables)}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Program | None:
        pair = self.with_dimension(node, path, reading)
        return None if pair is None else pair[0]

    def with_dimension(self, node: Node, path: KeyPath, reading: Reading) -> tuple[Program, Inferred] | None:
        """The function and the dimension of its value; None where it is wrong, which is reported."""
        if not isinstance(node, ScalarNode) or not node.text.strip():
            self.reject(node, path, reading)
            return None
        tree = reading.parse(node, self.variables)
        variables = dict(zip(self.variables, self.operands, strict=False))
        reads = channels_in(tree, variables, reading) if self.names_channels and tree is not None else ()
        if self.names_channels and tree is not None and is_misspelt(tree, {*variables, *reads}, node, reading):
            return None
        channels = {name: CHANNELS + at for at, name in enumerate(reads)}
        pair = reading.program(node, tree, variables | channels, self._dimensions(reads, reading))
        if pair is None:
            return None
        reads = tuple(reading.inner.get(name, name) for name in reads)
        program, inferred = replace(pair[0], reads=reads), pair[1]
        pure = self.unit != "" or inferred.certain in (None, BARE, ANGLE)
        if self.unit is not None and not (pure and inferred.agrees(dimension_of(self.unit))):
            assert inferred.dimension is not None
            wanted = f"is in {self.unit}" if self.unit else "has no unit"
            message = f"{label(path)} {wanted}, this is {describe(inferred.dimension, with_unit=True)}"
            scaled = (
                "a number without unit is a pure number beside these: give it its unit" if inferred.scaled else None
            )
            reading.report(message, node.place, unit_hint(node.text, tree) or scaled)
            return None
        if self.unit == "rad":
            note_degrees(node, path, reading)
        reading.units[path] = unit_text(self.unit, inferred.certain)
        return program, inferred

    def _dimensions(self, channels: Iterable[str], reading: Reading) -> dict[str, Inferred]:
        """The dimensions of the variables and channels that have known ones."""
        of_variables = zip(self.variables, self.units, strict=False)
        known = {name: Inferred(dimension_of(unit), Origin.MOVING) for name, unit in of_variables}
        dimensions = {name: reading.dimension_of(name, reading) for name in channels}
        read = {name: Inferred(each, Origin.MOVING) for name, each in dimensions.items() if each is not None}
        return {**known, **read, **({"t": OF_TIME} if "t" in known else {})}

    def schema(self) -> Schema:
        return {"description": self.expects, "type": ["number", "string"], "pattern": r"\S"}


@dataclass(frozen=True)
class Varying(Field[float | Program]):
    """A `number`, or an expression in its unit that names t, signals, states or coordinates. The bounds of the number
    are not checked for such an expression."""

    number: Number

    @property
    def expects(self) -> str:
        return self.number.expects

    @property
    def unit(self) -> str | None:
        """The SI unit of the value, as in `Number`."""
        return self.number.unit

    def read(self, node: Node, path: KeyPath, reading: Reading) -> float | Program | None:
        tree = reading.parse(node) if isinstance(node, ScalarNode) and node.text.strip() else None
        if isinstance(node, ScalarNode) and tree is not None:
            changes = "t" in names(tree) or channels_in(tree, {}, reading)
            if changes or is_misspelt(tree, reading.names.keys(), node, reading):
                return Function(self.unit, names_channels=True).read(node, path, reading) if changes else None
        return self.number.read(node, path, reading)

    def schema(self) -> Schema:
        return self.number.schema()


def channels_in(tree: Expression, variables: Mapping[str, int], reading: Reading) -> tuple[str, ...]:
    """The names of channels in an expression, in their order."""
    nodes = [node for node, _ in walk(tree) if isinstance(node, NameNode) and node.name not in variables]
    return tuple(
        dict.fromkeys(
            node.name
            for node in sorted(nodes, key=lambda node: node.at)
            if "." in node.name or any(node.name in block for block in _blocks(reading))
        )
    )


def _blocks(reading: Reading) -> tuple[Collection[str], ...]:
    """The names of channels without a point: signals and states, and names that hold within an item."""
    return (reading.inner, *(reading.items.get(block, ()) for block in ("signals", "states")))


def is_misspelt(tree: Expression, known: Set[str], node: ScalarNode, reading: Reading) -> bool:
    """Whether an unknown name in the expression is similar to that of a signal or a state, which is reported."""
    able = [name for block in _blocks(reading) for name in block]
    for each, _ in walk(tree):
        if isinstance(each, NameNode) and not {each.name} & {*known, *reading.names, *CONSTANTS, *SYMBOLS}:
            hint = did_you_mean(each.name, able)
            if hint is not None:
                reading.report(f"unknown name '{each.name}'", node.place_at(each.at), hint)
                return True
    return False


def _increasing(rows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """The rows. Raises Unfit where there are fewer than two, or their first numbers do not increase."""
    if len(rows) < 2:
        raise Unfit("has one row", "a table has two or more")
    for number, ((before, _), (after, _)) in enumerate(pairwise(rows), 2):
        if not after > before:
            hint = "the first numbers of its rows must increase"
            raise Unfit(f"has {after:g} after {before:g} in row {number}", hint)
    return rows


def _repeated(rows: tuple[tuple[float, float], ...]) -> CubicTable:
    """The periodic spline through the rows. Raises Unfit for fewer than four, or a last value unlike the first."""
    if len(rows) < 4:
        raise Unfit(f"has {len(rows)} rows", "a periodic table has four or more, the last with the value of the first")
    if rows[-1][1] != rows[0][1]:
        raise Unfit(f"begins with {rows[0][1]:g} and ends with {rows[-1][1]:g}", "a periodic table ends as it begins")
    return periodic(rows[:-1], rows[-1][0] - rows[0][0])


#: The ways to interpolate a table between its rows.
BETWEEN: Mapping[str, Callable[[Any], CubicTable]] = {
    "natural": partial(spline, ends="natural"),
    "clamped": partial(spline, ends="clamped"),
    "linear": polygon,
    "periodic": _repeated,
}


@dataclass(frozen=True)
class _TableRow(Field[tuple[float, float]]):
    """A row of a table: two numbers, each read by its own field."""

    first: Number
    second: Number
    node_type: ClassVar[type] = SequenceNode

    @property
    def expects(self) -> str:
        return f"[{self.first.expects}, {self.second.expects}]"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[float, float] | None:
        if not isinstance(node, SequenceNode) or len(node.items) != 2:
            self.reject(node, path, reading)
            return None
        first, second = (
            number.read(item, (*path, at), reading)
            for at, (number, item) in enumerate(zip((self.first, self.second), node.items, strict=True))
        )
        return None if first is None or second is None else (first, second)

    def schema(self) -> Schema:
        numbers = [self.first.schema(), self.second.schema()]
        return {"description": self.expects, "type": "array", "prefixItems": numbers, "minItems": 2, "maxItems": 2}


def table(unit: str | None, value_unit: str | None, ways: tuple[str, ...]) -> Field[CubicTable]:
    """The field of a table of values in `value_unit` over numbers in `unit`: rows alone (a natural spline), or {rows,
    between}; `ways` are the values that `between` may have."""
    rows: Field[Any] = Converted(List(_TableRow(Number(unit), Number(value_unit)), None, "rows"), _increasing)
    return Alternatives(
        (
            Converted(rows, BETWEEN["natural"]),
            Record(
                "a table",
                {"rows": rows, "between": NameChoice("way between rows", lambda: ways)},
                lambda rows, between="natural": BETWEEN[between](rows),
                required=("rows",),
            ),
        )
    )
