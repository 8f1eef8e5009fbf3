"""Fields that are functions: expressions of time, or of a coordinate and its rate, and tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import Any, ClassVar

from mbproj.dataclass import dataclass
from mbproj.functions.program import COORDINATE, RATE, TIME, Program
from mbproj.functions.table import Table, periodic, polygon, spline
from mbproj.scene.expressions.units import describe
from mbproj.scene.fields.alternatives import Alternatives
from mbproj.scene.fields.choices import Choice
from mbproj.scene.fields.containers import Record
from mbproj.scene.fields.fields import Converted, Field, List, Schema
from mbproj.scene.fields.quantities import Number, dimension_of, note_degrees, unit_hint
from mbproj.scene.fields.reading import Reading, Unfit, label
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, ScalarNode, SequenceNode


@dataclass(frozen=True)
class Function(Field[Program]):
    """A number in `unit` (None: any), from an expression in which `variables` may stand beside parameters: the time,
    and for the law of a force its coordinate and the rate of that, which programs call `operands`."""

    unit: str | None
    variables: tuple[str, ...] = ("t",)
    operands: tuple[int, ...] = (TIME, COORDINATE, RATE)

    @property
    def expects(self) -> str:
        number = f"a number in {self.unit}" if self.unit else "a number"
        return f"{number} or an expression of {', '.join(self.variables)}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Program | None:
        if not isinstance(node, ScalarNode) or not node.text.strip():
            self.reject(node, path, reading)
            return None
        tree = reading.parse(node)
        found = reading.program(node, tree, dict(zip(self.variables, self.operands, strict=False)))
        if found is None:
            return None
        program, dimension = found
        if self.unit is not None and dimension is not None and not dimension_of(self.unit).agrees(dimension):
            message = f"{label(path)} is in {self.unit}, this is {describe(dimension)}"
            reading.report(message, node.place, unit_hint(node.text, tree))
            return None
        if self.unit == "rad":
            note_degrees(node, path, reading)
        return program

    def schema(self) -> Schema:
        return {"description": self.expects, "type": ["number", "string"], "pattern": r"\S"}


def _increasing(rows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Rows whose first numbers increase, two at least."""
    if len(rows) < 2:
        raise Unfit("has one row", "a table has two or more")
    for number, ((before, _), (after, _)) in enumerate(pairwise(rows), 2):
        if not after > before:
            hint = "the first numbers of its rows must increase"
            raise Unfit(f"has {after:g} after {before:g} in row {number}", hint)
    return rows


def _repeated(rows: tuple[tuple[float, float], ...]) -> Table:
    """The periodic spline whose last row is its first again."""
    if len(rows) < 4:
        raise Unfit(f"has {len(rows)} rows", "a periodic table has four or more, the last with the value of the first")
    if rows[-1][1] != rows[0][1]:
        raise Unfit(f"begins with {rows[0][1]:g} and ends with {rows[-1][1]:g}", "a periodic table ends as it begins")
    return periodic(rows[:-1], rows[-1][0] - rows[0][0])


#: How a table is read between its rows.
BETWEEN: Mapping[str, Callable[[Any], Table]] = {
    "natural": partial(spline, ends="natural"),
    "clamped": partial(spline, ends="clamped"),
    "linear": polygon,
    "periodic": _repeated,
}


@dataclass(frozen=True)
class _Row(Field[tuple[float, float]]):
    """Two numbers, each of its own kind."""

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


def table(unit: str | None, value_unit: str | None, ways: tuple[str, ...]) -> Field[Table]:
    """A table of values in `value_unit` over numbers in `unit`: rows alone (a natural spline), or {rows, between}."""
    rows: Field[Any] = Converted(List(_Row(Number(unit), Number(value_unit)), None, "rows"), _increasing)
    return Alternatives(
        (
            Converted(rows, BETWEEN["natural"]),
            Record(
                "a table",
                {"rows": rows, "between": Choice("way between rows", lambda: ways)},
                lambda rows, between="natural": BETWEEN[between](rows),
                required=("rows",),
            ),
        )
    )
