"""Checks that an expectation fits its quantity: the component, the number of values, their units."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.scene.blocks.expectations import BOUNDS, Given, subject
from mbproj.scene.blocks.observables import EXTREMES, Observable
from mbproj.scene.expressions.units import describe
from mbproj.scene.fields.containers import Complaint
from mbproj.scene.fields.quantities import agrees
from mbproj.scene.records import KeyPath


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
            yield Complaint(_place(given, path, where), f"'{what}' {mine}, this is {describe(value.dimension)}")
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
    found = len(given.get("value", [None] * needed))
    if found == needed:
        return None
    also = ", or a component: x, y, z or norm" if needed == 3 else ""
    numbers = f"{needed} numbers" if needed > 1 else "one number"
    return Complaint(("value",), f"'{what}' needs {numbers} here, found {found}", f"give {numbers}{also}")
