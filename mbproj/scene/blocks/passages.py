"""Expectations over joint coordinates in place of time: where a coordinate passes a value, ratios to an input, and the
transmission angle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from mbproj.errors import choose_from
from mbproj.scene.blocks.coordinates import COORDINATES, coordinates_in
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.units import describe
from mbproj.scene.fields.containers import Complaint
from mbproj.scene.fields.quantities import agrees
from mbproj.scene.records import Joint, KeyPath, Passage

#: The endings of the names of ratios; the name of a coordinate stands before them.
VELOCITY_RATIO, MECHANICAL_ADVANTAGE = "_velocity_ratio", "_mechanical_advantage"
RATIOS = (VELOCITY_RATIO, MECHANICAL_ADVANTAGE)
TRANSMISSION_ANGLE = "transmission_angle"


class GivenPassage(NamedTuple):
    """`at: {crank.angle: 90 deg}` as read; its unit is checked later, when the joints are known."""

    coordinate: str
    value: Value


def output_of(quantity: str) -> str:
    """The output coordinate of a ratio; "" for a quantity that is no ratio."""
    ending = next((ending for ending in RATIOS if quantity.endswith(ending)), None)
    return quantity.removesuffix(ending) if ending else ""


def ratio_unit(quantity: str, over: str) -> str:
    """The unit of a ratio to the input `over` ("crank.angle"); rad counts as no unit."""
    units = COORDINATES[output_of(quantity)], COORDINATES[over.rpartition(".")[2]]
    above, below = units if quantity.endswith(VELOCITY_RATIO) else reversed(units)
    return "" if above == below else "m" if above == "m" else "1/m"


def coordinates_of(joints: Mapping[str, Joint]) -> list[str]:
    """The names of all joint coordinates, such as "crank.angle"."""
    return [f"{name}.{own}" for name, joint in joints.items() for own in coordinates_in(joint, None)]


def of_coordinates(joints: Mapping[str, Joint], expected: Mapping[str, Mapping[str, Any]]) -> Iterator[Complaint]:
    """A check that the coordinates exist that expectations name in a passage, or as the input of a ratio."""
    known = coordinates_of(joints)
    for name, given in expected.items():
        path: KeyPath = ("expect", name)
        quantity, at = given.get("quantity", ""), given["at"]
        over, is_ratio = given.get("over"), bool(output_of(quantity))
        if is_ratio and over is None:
            yield Complaint((*path, "quantity"), f"'{quantity}' is to an input", "add  over: JOINT.COORDINATE")
        elif over is not None and not is_ratio:
            yield Complaint(
                (*path, "over"), f"'{quantity}' has no input", "leave it out, or write  at: {A.angle: 90 deg}"
            )
        elif over is not None and over not in known:
            yield Complaint((*path, "over"), f"unknown joint coordinate '{over}'", choose_from(over, known))
        if isinstance(at, GivenPassage) and at.coordinate not in known:
            hint = choose_from(at.coordinate, known)
            yield Complaint((*path, "at"), f"unknown joint coordinate '{at.coordinate}'", hint)
        elif isinstance(at, GivenPassage):
            unit = COORDINATES[at.coordinate.rpartition(".")[2]]
            if at.value.dimension is not None and not agrees(unit, at.value.dimension):
                found = f"'{at.coordinate}' is in {unit}, this is {describe(at.value.dimension)}"
                yield Complaint((*path, "at"), found)


def of_corners(expected: Mapping[str, Mapping[str, Any]], markers: Mapping[str, Any]) -> Iterator[Complaint]:
    """A check that the two markers exist between which a transmission angle is measured."""
    for name, given in expected.items():
        path, between = ("expect", name), given.get("between")
        if given.get("quantity") == TRANSMISSION_ANGLE and "marker" in given:
            if between is None:
                hint = "add  between: [FIRST, SECOND]"
                yield Complaint((*path, "quantity"), "a transmission angle is between two other markers", hint)
                continue
            for place, marker in enumerate(between):
                if marker not in markers:
                    hint = choose_from(marker, markers)
                    yield Complaint((*path, "between", place), f"unknown marker '{marker}'", hint)
                elif marker == given["marker"]:
                    yield Complaint((*path, "between", place), f"'{marker}' is the corner itself", "name another")
        elif between is not None:
            hint = f"leave it out, or ask for {TRANSMISSION_ANGLE}"
            yield Complaint((*path, "between"), "only a transmission angle is between markers", hint)


def passage_of(at: GivenPassage) -> Passage:
    """The record of a passage, with the unit of its coordinate."""
    return Passage(at.coordinate, at.value.number, COORDINATES[at.coordinate.rpartition(".")[2]])
