"""The quantities that a run records and an expectation may be about, by name. Vectors are in the frames that
`mbproj.results.layout` gives.

Some are over a joint coordinate in place of time: where it passes a value, ratios to an input, transmission angles.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from mbproj.base.errors import choose_from
from mbproj.scene.blocks.coordinates import COORDINATES, coordinates_in
from mbproj.scene.expressions.dimensions import describe
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.fields.fields import Complaint
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
    return [f"{name}.{coordinate}" for name, joint in joints.items() for coordinate in coordinates_in(joint, None)]


def of_coordinates(joints: Mapping[str, Joint], expected: Mapping[str, Mapping[str, Any]]) -> Iterator[Complaint]:
    """A check that the coordinates exist that expectations name in a passage, or as the input of a ratio."""
    known = coordinates_of(joints)
    for name, keys in expected.items():
        path: KeyPath = ("expect", name)
        quantity, at = keys.get("quantity", ""), keys["at"]
        over, is_ratio = keys.get("over"), bool(output_of(quantity))
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
                message = f"'{at.coordinate}' is in {unit}, this is {describe(at.value.dimension, with_unit=True)}"
                yield Complaint((*path, "at"), message)


def of_corners(expected: Mapping[str, Mapping[str, Any]], markers: Mapping[str, Any]) -> Iterator[Complaint]:
    """A check that the two markers exist between which a transmission angle is measured."""
    for name, keys in expected.items():
        path, between = ("expect", name), keys.get("between")
        if keys.get("quantity") == TRANSMISSION_ANGLE and "marker" in keys:
            if between is None:
                hint = "add  between: [FIRST, SECOND]"
                yield Complaint((*path, "quantity"), "a transmission angle is between two other markers", hint)
                continue
            for place, marker in enumerate(between):
                if marker not in markers:
                    hint = choose_from(marker, markers)
                    yield Complaint((*path, "between", place), f"unknown marker '{marker}'", hint)
                elif marker == keys["marker"]:
                    yield Complaint((*path, "between", place), f"'{marker}' is the corner itself", "name another")
        elif between is not None:
            hint = f"leave it out, or ask for {TRANSMISSION_ANGLE}"
            yield Complaint((*path, "between"), "only a transmission angle is between markers", hint)


def passage_of(at: GivenPassage) -> Passage:
    """The record of a passage, with the unit of its coordinate."""
    return Passage(at.coordinate, at.value.number, COORDINATES[at.coordinate.rpartition(".")[2]])


class Observable(NamedTuple):
    """The SI unit of a quantity and the number of its components. "A or B" is the unit A on an angle, and B on a
    length."""

    unit: str
    components: int = 1

    def unit_with(self, coordinate: str) -> str:
        """The unit of the quantity on a coordinate in "rad" or "m"."""
        angle, _, length = self.unit.partition(" or ")
        return length if length and coordinate == "m" else angle


#: The most wheels that a rope may turn: the room in the kernel's arrays.
MOST_WHEELS = 5
#: The tension of a portion of a rope; the number of the portion, from 1, follows.
TENSION = "tension_"
#: The point where a joint touches its curve.
CONTACT = "contact"
_OF_JOINT_COORDINATES = {
    **{name: Observable(unit) for name, unit in COORDINATES.items()},
    **{f"{name}_speed": Observable(f"{unit}/s") for name, unit in COORDINATES.items()},
    **{f"{name}{ratio}": Observable("") for ratio in RATIOS for name in COORDINATES},
}
#: The quantities by the kind of item. A joint has those of its own coordinates only.
OBSERVABLES: Mapping[str, Mapping[str, Observable]] = MappingProxyType(
    {
        "marker": {
            "position": Observable("m", 3),
            "velocity": Observable("m/s", 3),
            "acceleration": Observable("m/s^2", 3),
            TRANSMISSION_ANGLE: Observable("rad"),
        },
        "body": {
            "position": Observable("m", 3),
            "orientation": Observable("", 4),
            "velocity": Observable("m/s", 3),
            "angular_velocity": Observable("rad/s", 3),
            "acceleration": Observable("m/s^2", 3),
            "angular_acceleration": Observable("rad/s^2", 3),
        },
        "joint": {
            **_OF_JOINT_COORDINATES,
            **{f"{TENSION}{number}": Observable("N") for number in range(1, MOST_WHEELS + 2)},
            CONTACT: Observable("m", 3),
            "reaction_force": Observable("N", 3),
            "reaction_torque": Observable("N*m", 3),
            "violation": Observable(""),
            "violation_length": Observable("m"),
            "violation_angle": Observable("rad"),
        },
        "force": {
            "coordinate": Observable("rad or m"),
            "rate": Observable("rad/s or m/s"),
            "force": Observable("N*m or N"),
        },
        "motion": {
            "value": Observable("rad or m"),
            "rate": Observable("rad/s or m/s"),
            "force": Observable("N*m or N"),
        },
        "stop": {
            "gap": Observable("rad or m"),
            "rate": Observable("rad/s or m/s"),
            "force": Observable("N*m or N"),
        },
        "friction": {
            "rate": Observable("rad/s or m/s"),
            "force": Observable("N*m or N"),
            "state": Observable(""),
            "dissipation": Observable("J"),
        },
        "state": {"value": Observable("")},
        "signal": {"value": Observable("")},
        "diagnostic": {
            "position_violation": Observable(""),
            "velocity_violation": Observable(""),
            "acceleration_violation": Observable(""),
            "kinetic_energy": Observable("J"),
            "potential_energy": Observable("J"),
            "total_energy": Observable("J"),
            "work": Observable("J"),
            "dissipation": Observable("J"),
            "energy_balance": Observable("J"),
            "energy_drift": Observable("J"),
            "energy_drift_relative": Observable(""),
            "step_size": Observable("s"),
            "steps": Observable(""),
            "rejected_steps": Observable(""),
            "evaluations": Observable(""),
            "projections": Observable(""),
            "projection_iterations": Observable(""),
            "velocity_iterations": Observable(""),
            "projection_failures": Observable(""),
            "projection_fallbacks": Observable(""),
            "factorisations": Observable(""),
        },
    }
)
#: The quantities of bushings, in the axes of the frame midway between their two frames.
OF_BUSHINGS: Mapping[str, Observable] = MappingProxyType(
    {
        "translation": Observable("m", 3),
        "rotation": Observable("rad", 3),
        "translation_rate": Observable("m/s", 3),
        "rotation_rate": Observable("rad/s", 3),
        "force": Observable("N", 3),
        "torque": Observable("N*m", 3),
    }
)
#: The ways to make one number of a vector of three.
COMPONENTS = ("x", "y", "z", "norm")
#: Moments that are no time: where the quantity is largest, smallest, largest in magnitude; the last sample.
EXTREMES = ("maximum", "minimum", "largest", "range")
MOMENTS = ("end", *EXTREMES)
