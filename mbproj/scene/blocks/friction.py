"""The fields of dry friction on coordinates of a joint:

{torque: 4 N*m, static: 5 N*m, stribeck_speed: 0.05 rad/s}                     # constant, on an angle
{force: 3 N, regularised: 1e-3 m/s}                                            # constant, on a displacement
{coefficient: 0.2, static: 0.3, radius: 10 mm, axial_radius: 8 mm}             # from the reaction, on an angle
{coefficient: 0.1, bearing_length: 60 mm, preload: 20 N}                       # from the reaction, on a displacement
{angle: {torque: 4 N*m}, displacement: {force: 3 N}}                           # by coordinate
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.fields.containers import Complaint, OneOf, Record, Rule
from mbproj.scene.fields.fields import Field, Schema, T_co
from mbproj.scene.fields.functions import Varying
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Reading, either, label
from mbproj.scene.friction import Bearing, DryFriction
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, as_mapping

#: The key of constant friction and its unit, by the unit of the coordinate.
CONSTANT = {"rad": ("torque", "N*m"), "m": ("force", "N")}
#: The keys of the sliding friction; each but the last is for coordinates in one unit.
SLIDING = ("torque", "force", "coefficient")
ARMS = ("radius", "axial_radius")
SPEEDS = ("stribeck_speed", "regularised")
STATIC: Mapping[str, Varying] = {
    **{key: Varying(Number(unit, minimum=0.0)) for key, unit in CONSTANT.values()},
    "coefficient": Varying(Number(minimum=0.0)),
    "": Varying(Number(None, minimum=0.0)),
}
SPEED: Mapping[str, Number] = {unit: Number(f"{unit}/s", above=0.0) for unit in CONSTANT}
LENGTH = Number("m", above=0.0)
KEYS: Mapping[str, Field[Any]] = {
    **{key: STATIC[key] for key in SLIDING},
    "static": STATIC[""],
    **dict.fromkeys(ARMS, LENGTH),
    "bearing_length": LENGTH,
    "preload": Number("N", minimum=0.0),
    **dict.fromkeys(SPEEDS, Number(None, above=0.0)),
}
#: The keys that friction on a coordinate in this unit does not have.
FOREIGN = {"rad": ("force",), "m": ("torque", *ARMS)}
#: The keys that describe the bearing: how the reaction of the joint presses.
PRESSES = (*ARMS, "bearing_length", "preload")

CHOICES = (
    OneOf(SLIDING, needed=True, hint="friction is constant, or a 'coefficient' times what the joint bears"),
    *(
        OneOf((constant, key), hint=f"a '{constant}' is constant; '{key}' goes with 'coefficient'")
        for constant in SLIDING[:2]
        for key in PRESSES
    ),
)


def not_less(key: str) -> Callable[..., Iterator[Complaint]]:
    """A check that the static value is not less than the sliding one. It refuses keys that have no effect: a Stribeck
    speed where both are equal, a static value with `regularised` alone."""

    def find(sliding: Any, static: Any, stribeck_speed: Any, regularised: Any) -> Iterator[Complaint]:
        unit = f" {KEYS[key].unit}" if KEYS[key].unit else ""  # type: ignore[attr-defined]
        if isinstance(sliding, Program) or isinstance(static, Program):
            return
        holds = static if isinstance(static, float) else sliding
        if holds < sliding:
            said = f"'static' must be at least the '{key}', {sliding:.6g}{unit}, found {holds:.6g}"
            yield Complaint(("static",), said, f"without 'static' it is the '{key}'")
        elif holds == sliding and isinstance(stribeck_speed, float):
            said = f"'stribeck_speed' does nothing where 'static' is not greater than '{key}'"
            yield Complaint(("stribeck_speed",), said, "give a greater 'static', from which friction falls")
        elif holds > sliding and isinstance(regularised, float) and not isinstance(stribeck_speed, float):
            said = "'static' does nothing with 'regularised' alone, which never holds"
            yield Complaint(("static",), said, "give 'stribeck_speed' as well, or leave one of them out")

    return find


def _has_arm(coefficient: Any, *given: Any) -> Iterator[Complaint]:
    """A check that friction on an angle has an arm, which makes a torque of a force, or a constant torque."""
    if not any(isinstance(value, float | Program) for value in given):
        yield armless(("coefficient",))


def armless(path: KeyPath) -> Complaint:
    """The complaint that the friction by a coefficient on an angle has no arm."""
    said = "the 'coefficient' of friction on an angle needs 'radius' or 'axial_radius'"
    return Complaint(path, said, "add radius: the arm of the radial force; axial_radius: that of the axial one")


def _needs_radius(key: str) -> Callable[..., Iterator[Complaint]]:
    """A check that `radius` is given where `key` is, which describes the radial force."""

    def find(value: float, coefficient: Any, radius: Any) -> Iterator[Complaint]:
        if isinstance(coefficient, float | Program) and not isinstance(radius, float):
            said = f"'{key}' does nothing without 'radius'"
            yield Complaint((key,), said, "it describes the radial force, whose arm is 'radius'")

    return find


CHECKS = tuple(Rule((key,), not_less(key), ("static", *SPEEDS)) for key in SLIDING)
OF_ANGLES = tuple(Rule((key,), _needs_radius(key), ("coefficient", "radius")) for key in ("bearing_length", "preload"))
ARM = Rule(("coefficient",), _has_arm, ("torque", *ARMS))


class DryRecord(Record[T_co]):
    """A record of dry friction, in which `static` is in the unit of the sliding friction."""

    def read(self, node: Node, path: KeyPath, reading: Reading) -> T_co | None:
        given = as_mapping(node)
        key = next((key for key in SLIDING if given is not None and key in given.values), "")
        return Record.read(replace(self, keys={**self.keys, "static": STATIC[key]}), node, path, reading)


def _record(unit: str, any_coordinate: bool) -> DryRecord[DryFriction]:
    """The record of dry friction on a coordinate in this unit. With `any_coordinate` the scene does not name the
    coordinate: then the record knows the keys of both units, so that messages can explain wrong ones."""
    foreign = () if any_coordinate else FOREIGN[unit]
    keys = {key: field for key, field in KEYS.items() if key not in foreign} | dict.fromkeys(SPEEDS, SPEED[unit])
    choices = tuple(
        OneOf(own, group.needed, group.hint)
        for group in CHOICES
        if len(own := tuple(key for key in group.keys if key in keys)) > 1
    )
    checks = tuple(check for check in CHECKS if check.keys[0] in keys)
    if unit == "rad":
        checks = (*checks, *OF_ANGLES, ARM)

    def make(static: float | Program | None = None, **given: Any) -> DryFriction:
        (sliding,) = (given[key] for key in SLIDING if key in given)
        speeds = {key: given.get(key) for key in SPEEDS}
        bearing = None
        if "coefficient" in given:
            radius, axial = (given.get(key) for key in ARMS)
            bearing = Bearing(radius, axial, given.get("bearing_length", math.inf), given.get("preload", 0.0))
        return DryFriction(unit, sliding, sliding if static is None else static, bearing=bearing, **speeds)

    what = "dry friction" if any_coordinate else f"dry friction on {'an angle' if unit == 'rad' else 'a displacement'}"
    return DryRecord(what, keys, make, (), checks, choices, elsewhere=frozenset(foreign))


ANY: Mapping[str, DryRecord[DryFriction]] = {unit: _record(unit, any_coordinate=True) for unit in CONSTANT}
BY_COORDINATE: Record[dict[str, DryFriction]] = Record(
    "dry friction by coordinate",
    {"angle": _record("rad", any_coordinate=False), "displacement": _record("m", any_coordinate=False)},
    dict,
    elsewhere=frozenset((*COORDINATES, *KEYS)) - {"angle", "displacement"},
)


@dataclass(frozen=True)
class Coulomb(Field[Mapping[str, DryFriction]]):
    """Dry friction by coordinate. The name "" stands for the only coordinate of the joint in the unit that follows from
    the keys."""

    node_type: ClassVar[type] = MappingNode

    @property
    def expects(self) -> str:
        return f"{{{either(SLIDING)}, ...}} or {BY_COORDINATE.expects}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Mapping[str, DryFriction] | None:
        mapping = as_mapping(node)
        if mapping is None:
            self.reject(node, path, reading)
            return None
        if not mapping.values:
            hint = f"give {either(map(repr, SLIDING))}"
            reading.report(f"{label(path)} is empty", mapping.place, hint)
            return None
        named = not mapping.values.keys().isdisjoint(COORDINATES)
        if named or any(isinstance(value, MappingNode) for value in mapping.values.values()):
            return BY_COORDINATE.read(mapping, path, reading)
        dry = ANY[_unit_of(mapping, reading)].read(mapping, path, reading)
        return None if dry is None else {"": dry}

    def schema(self) -> Schema:
        by_coordinate = {**BY_COORDINATE.schema(), "type": "object", "minProperties": 1}
        return {"description": self.expects, "anyOf": [ANY["rad"].schema(), by_coordinate]}


COULOMB = Coulomb()


def _unit_of(mapping: MappingNode, reading: Reading) -> str:
    """The unit of the coordinate that friction with these keys acts on. A coefficient without an arm acts on a
    displacement, unless a speed in rad/s shows that the arm is missing."""
    if not mapping.values.keys().isdisjoint(FOREIGN["m"]):
        return "rad"
    alone = Reading(names=reading.names)
    turns = (_is_turning(mapping.values[key], alone) for key in SPEEDS if key in mapping.values)
    return "rad" if "force" not in mapping.values and any(turns) else "m"


def _is_turning(node: Node, alone: Reading) -> bool:
    """Whether the node can be read as a speed in rad/s, but not as one in m/s."""
    return SPEED["m"].read(node, (), alone) is None and SPEED["rad"].read(node, (), alone) is not None
