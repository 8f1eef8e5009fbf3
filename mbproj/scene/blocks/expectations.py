"""The `expect` block: results that a run has to give: their object, time, value, tolerance and source.

`fits` checks that an expectation fits its quantity: the component, the number of values, their units.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import choose_from
from mbproj.scene.blocks.observables import (
    COMPONENTS,
    EXTREMES,
    MOMENTS,
    OBSERVABLES,
    OF_BUSHINGS,
    GivenPassage,
    Observable,
    passage_of,
)
from mbproj.scene.expressions.dimensions import describe
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.fields.choices import Alternatives, NameChoice, NameReference
from mbproj.scene.fields.containers import NAME, Complaint, OneOf, Record
from mbproj.scene.fields.fields import Converted, Field, List, Schema, Text
from mbproj.scene.fields.quantities import Number, agrees
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


def _not_empty(text: str) -> str:
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
        "source": Converted(Text(), _not_empty),
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


def fits(name: str, given: Given, observable: Observable, unit: str | None) -> Iterator[Complaint]:
    """Complaints about an expectation that does not fit the observable, whose unit here is `unit` (None: any)."""
    path: KeyPath = ("expect", name)
    what = subject(given)[2]
    for check in (_component_fits, _count_fits):
        complaint = check(given, observable, what)
        if complaint is not None:
            yield complaint._replace(path=(*path, *complaint.path))
            return
    numbers = [(("value", index), part) for index, part in enumerate(given.get("value", ()))]
    for where, value in [*numbers, *(((key,), given[key]) for key in ("absolute", *BOUNDS) if key in given)]:
        if unit is not None and not agrees(unit, value.dimension):
            mine = f"is in {unit}" if unit else "has no unit"
            yield Complaint(
                _place(given, path, where), f"'{what}' {mine}, this is {describe(value.dimension, with_unit=True)}"
            )
    if "relative" in given and not any(part.number for part in given["value"]):
        yield Complaint((*path, "relative"), "a relative tolerance of the value 0 is 0", "give an 'absolute' tolerance")


def _place(given: Given, path: KeyPath, where: KeyPath) -> KeyPath:
    """The path of a number of the expectation. A single value is no list in the scene: its path has no index."""
    return (*path, where[0]) if where[0] != "value" or len(given["value"]) == 1 else (*path, *where)


def _component_fits(given: Given, observable: Observable, what: str) -> Complaint | None:
    component, of_one = given.get("component"), given["at"] not in EXTREMES and "value" in given
    if component and observable.components == 1:
        return Complaint(("component",), f"'{what}' is one number and has no components", "leave it out")
    if component and observable.components == 4:
        return Complaint(("component",), "the sign of an orientation means nothing", "give all four as 'value'")
    if observable.components > 1 and not component and not of_one:
        key = "at" if "value" in given else next((bound for bound in BOUNDS if bound in given), "quantity")
        otherwise = "measure another quantity" if key == "quantity" else "expect it at a time"
        hint = "add component: x, y, z or norm" if observable.components == 3 else otherwise
        return Complaint((key,), f"'{what}' has {observable.components} components, and this is about one number", hint)
    return None


def _count_fits(given: Given, observable: Observable, what: str) -> Complaint | None:
    needed = 1 if "component" in given else observable.components
    count = len(given.get("value", [None] * needed))
    if count == needed:
        return None
    also = ", or a component: x, y, z or norm" if needed == 3 else ""
    numbers = f"{needed} numbers" if needed > 1 else "one number"
    return Complaint(("value",), f"'{what}' needs {numbers} here, found {count}", f"give {numbers}{also}")
