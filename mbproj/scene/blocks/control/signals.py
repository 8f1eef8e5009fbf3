"""The `signals` and `states` blocks: expressions by name, and states that integrate a derivative.

signals:
  error: 1 rad - pin.angle
  U: {value: 20*error + 30*integral, unit: V}
  lead: {transfer_function: {of: error, num: [0.1, 1], den: [0.01, 1]}}
states: {integral: {derivative: error}, current: {derivative: (U - 0.8*current)/2e-3, initial: 0 A, scale: 1 A}}
"""

from __future__ import annotations

from typing import Any

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import ScalarState, Signal
from mbproj.functions.program import Program
from mbproj.scene.blocks.control.blocks import BLOCKS, ControlBlock, Expanded
from mbproj.scene.blocks.control.expression import NOT_FREE, VALUE, unit_name
from mbproj.scene.blocks.expectations import MEASURE, Measure
from mbproj.scene.blocks.parameters import NAME, NAME_RULE
from mbproj.scene.expressions.dimensions import Found, called, describe
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.units import BARE, TIME, Dimension, unit_at
from mbproj.scene.fields.choices import Alternatives
from mbproj.scene.fields.containers import Named, OneOf, Record
from mbproj.scene.fields.fields import Converted, Field, Schema, Text
from mbproj.scene.fields.reading import Reading, Unfit
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node


def _unit(text: str) -> Dimension:
    """The dimension of a unit of SI. Raises Unfit for a text that is none."""
    unit = unit_at(text, 0)
    if unit is None or text[unit[1] :].strip():
        raise Unfit(f"is '{text}', which is no unit", "write it as in kg*m^2/s, V, A or bar")
    if (unit[0].multiply, unit[0].divide) != (1.0, 1.0):
        raise Unfit(f"is '{text}', which is not of SI", f"signals are in SI: {called(unit[0].dimension)}")
    return unit[0].dimension


def _signal(
    name: str,
    value: tuple[Program, Found] | None = None,
    unit: Dimension | None = None,
    **block: ControlBlock,
) -> Signal | Expanded:
    """The signal of an expression `value`, or the items that replace the one given block. Raises Unfit where the
    expression is in another unit."""
    if value is None:
        (only,) = block.values()
        return only.expanded(name, None if unit is None else called(unit))
    program, found = value
    if unit is not None and found.dimension is not None and not found.agrees(unit):
        its = describe(found.dimension, with_unit=True)
        raise Unfit(f"is in {called(unit)}, and its expression is {its}", "check the units of both")
    return Signal(name, program, unit_name(found.certain if unit is None else unit))


@dataclass(frozen=True)
class _PlainSignal(Field["Signal | Expanded"]):
    """A signal that is written as its expression alone."""

    @property
    def expects(self) -> str:
        return VALUE.expects

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Signal | Expanded | None:
        value = VALUE.read(node, path, reading)
        return None if value is None else _signal(str(path[-1]), value)

    def schema(self) -> Schema:
        return VALUE.schema()


SIGNAL_KEYS: dict[str, Field[Any]] = {"value": VALUE, **BLOCKS, "unit": Converted(Text(), _unit)}
_SIGNAL: Field[Signal | Expanded] = Alternatives(
    (
        _PlainSignal(),
        Record("a signal", SIGNAL_KEYS, _signal, choices=(OneOf(("value", *BLOCKS), needed=True),), named=True),
    )
)


def _state(
    name: str,
    derivative: tuple[Program, Found],
    initial: Value | None = None,
    scale: Value | None = None,
) -> ScalarState:
    """The record of a state. Its unit is that of its numbers, else that of its derivative times a second. Raises Unfit
    where these differ."""
    rate, of_rate = derivative[0], derivative[1].certain
    given = [each.dimension for each in (initial, scale) if each is not None and each.dimension not in (None, BARE)]
    dimension = given[0] if given else None
    for other in given[1:]:
        if dimension is not None and other is not None and not dimension.agrees(other):
            raise Unfit(f"begins with {describe(dimension)} and has a scale that is {describe(other)}")
    if of_rate is not None and of_rate != BARE:
        integrated = of_rate * TIME
        if dimension is not None and not dimension.agrees(integrated):
            raise Unfit(
                f"is {describe(dimension)}, and its derivative is {describe(of_rate)}", "check the units of both"
            )
        dimension = dimension or integrated
    return ScalarState(
        name,
        rate,
        0.0 if initial is None else initial.number,
        1.0 if scale is None else scale.number,
        unit_name(dimension),
    )


STATE_KEYS: dict[str, Field[Any]] = {"derivative": VALUE, "initial": MEASURE, "scale": Measure(above=0.0)}
_STATE: Record[ScalarState] = Record("a state", STATE_KEYS, _state, ("derivative",), named=True)
#: The fields of the two blocks.
SIGNALS = Named("signal", _SIGNAL, reserved=NOT_FREE, names=NAME, rule=NAME_RULE)
STATES = Named("state", _STATE, reserved=NOT_FREE, names=NAME, rule=NAME_RULE)
