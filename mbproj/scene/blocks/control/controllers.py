"""The `controllers` block: values computed at instants and held in between, and states that a controller remembers.

controllers:
  speed:
    period: 20 ms
    delay: 1 ms
    hold: {u: -80*rail.displacement - 8*rail.displacement_dot - 5*sum}
    states: {sum: {next: sum + rail.displacement}}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import Controller, Held
from mbproj.functions.program import Program
from mbproj.scene.blocks.control.expression import NOT_FREE, VALUE, unit_name
from mbproj.scene.blocks.expectations import MEASURE
from mbproj.scene.blocks.parameters import NAME, NAME_RULE
from mbproj.scene.expressions.dimensions import Found
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.fields.choices import Alternatives
from mbproj.scene.fields.containers import Named, Record
from mbproj.scene.fields.fields import Field, Schema
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Reading, Unfit
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, as_mapping


def _hold(
    name: str,
    value: tuple[Program, Found] | None = None,
    initial: Value | None = None,
    next: tuple[Program, Found] | None = None,
) -> Held:
    given = value or next
    assert given is not None
    program, dimension = given[0], given[1].certain
    if initial is not None and dimension is not None and initial.dimension is not None:
        if not initial.dimension.agrees(dimension):
            raise Unfit("has an initial value in another unit than its expression", "check the units of both")
        dimension = dimension or initial.dimension
    start = 0.0 if initial is None else initial.number
    return Held(name, program, start, unit_name(dimension or (initial.dimension if initial is not None else None)))


@dataclass(frozen=True)
class _PlainHeldValue(Field[Held]):
    """A held value that is written as its expression alone."""

    @property
    def expects(self) -> str:
        return VALUE.expects

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Held | None:
        value = VALUE.read(node, path, reading)
        return None if value is None else _hold(str(path[-1]), value)

    def schema(self) -> Schema:
        return VALUE.schema()


HELD: Field[Held] = Alternatives(
    (_PlainHeldValue(), Record("a held value", {"value": VALUE, "initial": MEASURE}, _hold, ("value",), named=True))
)
NEXT: Record[Held] = Record(
    "a state of a controller", {"next": VALUE, "initial": MEASURE}, _hold, ("next",), named=True
)


def _controller(
    name: str,
    period: float,
    hold: Mapping[str, Held] | None = None,
    states: Mapping[str, Held] | None = None,
    delay: float = 0.0,
    start: float = 0.0,
) -> Controller:
    held, kept = hold or {}, states or {}
    if not held:
        raise Unfit("holds nothing", "write what it computes: hold: {u: ..}")
    both = sorted(held.keys() & kept.keys())
    if both:
        raise Unfit(f"has '{both[0]}' twice", "a held value and a state cannot share a name")
    if not delay < period:
        raise Unfit(f"has a delay of {delay:g} s and a period of {period:g} s", "the delay is shorter than the period")
    return Controller(name, period, tuple(held.values()), tuple(kept.values()), delay, start)


@dataclass(frozen=True)
class ControllerRecord(Record[Controller]):
    """A controller. Its expressions name its own held values and states without its name in front."""

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Controller | None:
        mapping = as_mapping(node)
        blocks = [] if mapping is None else [mapping.values[key] for key in ("hold", "states") if key in mapping.values]
        own = [name for block in map(as_mapping, blocks) if block is not None for name in block.keys]
        reading.inner = {name: f"{path[-1]}.{name}" for name in own}
        try:
            return super().read(node, path, reading)
        finally:
            reading.inner = {}


CONTROLLER_KEYS: dict[str, Field[Any]] = {
    "period": Number("s", above=0.0),
    "hold": Named("held value", HELD, reserved=NOT_FREE, names=NAME, rule=NAME_RULE),
    "states": Named("state", NEXT, reserved=NOT_FREE, names=NAME, rule=NAME_RULE),
    "delay": Number("s", minimum=0.0),
    "start": Number("s", minimum=0.0),
}
CONTROLLER: Record[Controller] = ControllerRecord(
    "a controller", CONTROLLER_KEYS, _controller, ("period", "hold"), named=True
)
