"""The `expect` block: results that a run has to give: of what, when, how closely, and where the number comes from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import choose_from
from mbproj.scene.blocks.observables import COMPONENTS, MOMENTS, OBSERVABLES, OF_BUSHINGS
from mbproj.scene.blocks.passages import GivenPassage, passage_of
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.fields.choices import Alternatives, NameChoice, NameReference
from mbproj.scene.fields.containers import NAME, OneOf, Record
from mbproj.scene.fields.fields import Converted, Field, List, Schema, Text
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Reading, Unfit, either, label
from mbproj.scene.records import Expectation, KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode

#: An expectation as read: values by key. Numbers whose unit depends on the quantity are `Value`s with a dimension.
Given = Mapping[str, Any]
#: The kinds of items that an expectation may be about, with the block that has them; "" where no one block does.
SUBJECTS: Mapping[str, str] = {
    "marker": "markers",
    "body": "bodies",
    "joint": "joints",
    "force": "forces",
    "motion": "motions",
    "stop": "",
    "friction": "",
    "state": "",
    "signal": "",
    "diagnostic": "",
}
BOUNDS = ("below", "above")


@dataclass(frozen=True)
class Measure(Field[Value]):
    """A number in the unit of a quantity that another key names, so that its unit is checked later. It must be greater
    than `above`."""

    above: float | None = None

    @property
    def expects(self) -> str:
        return "a number in the unit of the quantity"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Value | None:
        if not isinstance(node, ScalarNode) or not node.text.strip():
            self.reject(node, path, reading)
            return None
        value = reading.value(node, reading.parse(node))
        if value is not None and self.above is not None and not value.number > self.above:
            reading.report(f"{label(path)} must be greater than {self.above:g}, found {value.number:.6g}", node.place)
            return None
        return value

    def schema(self) -> Schema:
        limits = {} if self.above is None else {"exclusiveMinimum": self.above}
        return {"description": self.expects, "type": ["number", "string"], "pattern": r"\S", **limits}


MEASURE = Measure()


@dataclass(frozen=True)
class Moment(Field["float | str | GivenPassage"]):
    """A time in s, one of `MOMENTS`, or the passage of a joint coordinate through a value: {crank.angle: 90 deg}."""

    @property
    def expects(self) -> str:
        return either(["a time in s", *MOMENTS, "a place {A.angle: 90 deg}"])

    def read(self, node: Node, path: KeyPath, reading: Reading) -> float | str | GivenPassage | None:
        if isinstance(node, MappingNode):
            if len(node.values) != 1:
                self.reject(node, path, reading)
                return None
            ((coordinate, where),) = node.values.items()
            value = MEASURE.read(where, (*path, coordinate), reading)
            return None if value is None else GivenPassage(coordinate, value)
        if isinstance(node, ScalarNode):
            if node.text in MOMENTS:
                return node.text
            if NAME.fullmatch(node.text) and node.text not in reading.names:
                hint = choose_from(node.text, MOMENTS)
                reading.report(f"unknown moment '{node.text}'", node.place, hint)
                return None
        return Number("s", minimum=0.0).read(node, path, reading)

    def schema(self) -> Schema:
        return {
            "description": self.expects,
            "type": ["number", "string", "object"],
            "pattern": r"\S",
            "minimum": 0.0,
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": MEASURE.schema(),
        }


def _said(text: str) -> str:
    if not text.strip():
        raise Unfit("is empty", "say who computed or measured the number, or from which formula it follows")
    return text


VALUE: Field[Any] = Alternatives((Converted(MEASURE, lambda value: (value,)), List(MEASURE, None, "numbers")))
QUANTITIES = tuple(
    dict.fromkeys([*(name for of, names in OBSERVABLES.items() if of != "diagnostic" for name in names), *OF_BUSHINGS])
)

EXPECTATION: Record[Given] = Record(
    "an expectation",
    {
        **{of: NameReference(of, block) for of, block in SUBJECTS.items() if block},
        **{of: Text() for of in ("stop", "friction", "state", "signal")},
        "diagnostic": NameChoice("diagnostic", lambda: OBSERVABLES["diagnostic"]),
        "quantity": NameChoice("quantity", lambda: QUANTITIES),
        "component": NameChoice("component", lambda: COMPONENTS),
        "over": Text(),
        "between": List(Text(), 2, "markers"),
        "at": Moment(),
        "value": VALUE,
        "absolute": Measure(above=0.0),
        "relative": Number(above=0.0),
        "below": MEASURE,
        "above": MEASURE,
        "source": Converted(Text(), _said),
    },
    dict,
    required=("at", "source"),
    choices=(
        OneOf(tuple(SUBJECTS), needed=True, hint="an expectation is of one thing; write another for the other"),
        OneOf(("quantity", "diagnostic"), needed=True, hint="a diagnostic is a quantity itself"),
        OneOf(("value", *BOUNDS), needed=True, hint="a bound stands without a value"),
        OneOf(("absolute", "relative", *BOUNDS), needed=True, hint="keep one of them"),
    ),
)


def subject(given: Given) -> tuple[str, str, str]:
    """The kind of item that an expectation is about, the name of the item, and the quantity."""
    of = next(key for key in SUBJECTS if key in given)
    return of, given[of], given.get("quantity", given.get("diagnostic"))


def expectation(name: str, given: Given, unit: str) -> Expectation:
    """The record of an expectation whose quantity is in `unit`."""
    of, item, quantity = subject(given)
    value = tuple(part.number for part in given["value"]) if "value" in given else None
    bounds = {key: given[key].number for key in BOUNDS if key in given}
    if value is not None:
        relative = given.get("relative", 0.0) * max(map(abs, value))
        bounds["tolerance"] = given["absolute"].number if "absolute" in given else relative
    at = passage_of(given["at"]) if isinstance(given["at"], GivenPassage) else given["at"]
    further = {key: given[key] for key in ("over", "between") if key in given}
    return Expectation(
        name, of, item, quantity, unit, given.get("component", ""), at, given["source"], value, **bounds, **further
    )
