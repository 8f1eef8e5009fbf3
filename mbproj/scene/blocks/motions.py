"""The `motions` block: coordinates of joints as functions of time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from mbproj.base.dataclass import dataclass
from mbproj.functions.program import Code, Program
from mbproj.functions.standard import harmonic, polynomial, smooth_step, tabulated, uniform
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.fields.fields import Alternatives, Converted, Field, NameReference, OneOf, Record, Schema
from mbproj.scene.fields.functions import Function, table
from mbproj.scene.fields.quantities import Number, PositionAngle, position_in
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath, Motion
from mbproj.scene.text.nodes import Node, SequenceNode

#: A function of time, and whether it is added to the coordinate's value at the start.
Driver = tuple[Program, bool]


def _driven(field: Field[Any], code: Callable[[Any], Code]) -> Field[Driver]:
    return Converted(field, lambda value: (Program(code(value)), False))


@dataclass(frozen=True)
class _Coefficients(Field[tuple[float, ...]]):
    """The coefficients of a polynomial of time: the one of t^k is in `unit`/s^k, the constant one comes first."""

    unit: str
    node_type: ClassVar[type] = SequenceNode

    @property
    def expects(self) -> str:
        return f"a list of coefficients, in {self.unit}, {self.unit}/s, {self.unit}/s^2, ..."

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[float, ...] | None:
        if not isinstance(node, SequenceNode) or not node.items:
            self.reject(node, path, reading)
            return None
        values = [self._coefficient(power).read(item, path, reading) for power, item in enumerate(node.items)]
        right = tuple(value for value in values if value is not None)
        return right if len(right) == len(values) else None

    def schema(self) -> Schema:
        return {"description": self.expects, "type": "array", "items": Number(None).schema(), "minItems": 1}

    def _coefficient(self, power: int) -> Number:
        return Number(f"{self.unit}/s^{power}") if power else position_in(self.unit)


def _kinds(unit: str) -> dict[str, Field[Driver]]:
    """The fields of the kinds of motion of a coordinate in m or rad, by key."""
    number = position_in(unit)
    wave = {"amplitude": number, "frequency": Number("rad/s"), "phase": PositionAngle(), "offset": number}
    step = {"from": number, "to": number, "start": Number("s"), "duration": Number("s", above=0.0)}
    return {
        "constant_speed": Converted(Number(f"{unit}/s"), lambda speed: (Program(uniform(speed)), True)),
        "harmonic": _driven(Record("a harmonic", wave, dict, ("amplitude", "frequency")), lambda w: harmonic(**w)),
        "polynomial": _driven(_Coefficients(unit), polynomial),
        "smooth_step": _driven(
            Record("a smooth_step", step, dict, ("to", "duration")),
            lambda s: smooth_step(s.get("from", 0.0), s["to"], s.get("start", 0.0), s["duration"]),
        ),
        "table": _driven(table("s", unit, ("natural", "clamped")), tabulated),
        "expression": Converted(Function(unit), lambda program: (program, False)),
    }


def _function(unit: str) -> Field[Driver]:
    """The field of a function of time: an expression alone, or a mapping with one of the kinds."""
    kinds = _kinds(unit)
    choice = (OneOf(tuple(kinds), needed=True),)
    one: Field[Driver] = Record("a motion", kinds, lambda **driver: next(iter(driver.values())), choices=choice)
    return Alternatives((kinds["expression"], one))


def _motion(name: str, joint: str, **drivers: Driver) -> Motion:
    ((coordinate, (function, from_start)),) = drivers.items()
    return Motion(name, joint, coordinate, function, from_start)


KINDS = tuple(_kinds("rad"))
_BY_UNIT: Mapping[str, Field[Driver]] = {unit: _function(unit) for unit in ("rad", "m")}

MOTION: Record[Motion] = Record(
    "a motion",
    {"joint": NameReference("joint", "joints"), **{name: _BY_UNIT[unit] for name, unit in COORDINATES.items()}},
    _motion,
    required=("joint",),
    choices=(OneOf(tuple(COORDINATES), needed=True, hint="a motion drives one; write another for the other"),),
    named=True,
)
