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

from mbproj.base.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.joints.table import JOINTS
from mbproj.scene.blocks.coordinates import COORDINATES, coordinates_in, lacks, none_or_several, with_coordinates
from mbproj.scene.fields.fields import Complaint, Field, OneOf, Record, Rule, Schema, T_co
from mbproj.scene.fields.functions import Varying
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Reading, either, label
from mbproj.scene.records import Bearing, DryFriction, Force, Joint, JointForce, KeyPath, PlaneStop
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


def _has_arm(coefficient: Any, *values: Any) -> Iterator[Complaint]:
    """A check that friction on an angle has an arm, which makes a torque of a force, or a constant torque."""
    if not any(isinstance(value, float | Program) for value in values):
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
        mapping = as_mapping(node)
        key = next((key for key in SLIDING if mapping is not None and key in mapping.values), "")
        return Record.read(replace(self, keys={**self.keys, "static": STATIC[key]}), node, path, reading)


def _record(unit: str, any_coordinate: bool) -> DryRecord[DryFriction]:
    """The record of dry friction on a coordinate in this unit. With `any_coordinate` the scene does not name the
    coordinate: then the record knows the keys of both units, so that messages can explain wrong ones."""
    foreign = () if any_coordinate else FOREIGN[unit]
    keys = {key: field for key, field in KEYS.items() if key not in foreign} | dict.fromkeys(SPEEDS, SPEED[unit])
    choices = tuple(
        OneOf(known, group.needed, group.hint)
        for group in CHOICES
        if len(known := tuple(key for key in group.keys if key in keys)) > 1
    )
    checks = tuple(check for check in CHECKS if check.keys[0] in keys)
    if unit == "rad":
        checks = (*checks, *OF_ANGLES, ARM)

    def make(static: float | Program | None = None, **values: Any) -> DryFriction:
        (sliding,) = (values[key] for key in SLIDING if key in values)
        speeds = {key: values.get(key) for key in SPEEDS}
        bearing = None
        if "coefficient" in values:
            radius, axial = (values.get(key) for key in ARMS)
            bearing = Bearing(radius, axial, values.get("bearing_length", math.inf), values.get("preload", 0.0))
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


# --- Rules on dry friction in joints ----------------------------------------------------------------------------------
# The joint has its coordinate, or exactly one that fits where none is named.


#: The types of joints that may have dry friction.
DRY_JOINTS = tuple(name for name, kind in JOINTS.items() if kind.dry)


def slides_in_joints(joints: Mapping[str, Joint], forces: Mapping[str, Force]) -> Iterator[Complaint]:
    """A check that the joint of each dry friction has the coordinate that the friction acts on."""
    for force in forces.values():
        if not isinstance(force, JointForce) or not force.coulomb:
            continue
        joint = joints[force.joint]
        if joint.type not in DRY_JOINTS:
            said = f"joint '{joint.name}' is {joint.type} and has no dry friction"
            yield Complaint(("forces", force.name, "joint"), said, f"joints that have some: {', '.join(DRY_JOINTS)}")
            continue
        for coordinate, dry in force.coulomb.items():
            path: KeyPath = ("forces", force.name, "coulomb", *([coordinate] if coordinate else []))
            coordinates = coordinates_in(joint, None)
            if coordinate and coordinate not in coordinates:
                yield lacks(joint, coordinate, coordinates, path)
                continue
            if dry.bearing is not None and not JOINTS[joint.type].rows:
                said = f"joint '{joint.name}' is {joint.type}, which holds nothing: no load presses on its friction"
                yield Complaint((*path, "coefficient"), said, "give a constant 'force'")
                continue
            if JOINTS[joint.type].slip:
                yield from _slips(joint, coordinate, dry, path)
                continue
            if not coordinate:
                yield from _undecided(joint, dry, path)
            yield from _thread(joint, dry, path)


def _slips(joint: Joint, coordinate: str, dry: DryFriction, path: KeyPath) -> Iterator[Complaint]:
    """The complaint about friction that does not exist where two profiles slide on each other."""
    if coordinate or dry.unit != "m":
        said = f"friction in joint '{joint.name}' is where its profiles slide on each other, on no coordinate"
        yield Complaint(path, said, "give a 'force', or a 'coefficient' without arms")


def _undecided(joint: Joint, dry: DryFriction, path: KeyPath) -> Iterator[Complaint]:
    """The complaint where no coordinate is named, and the joint has none that fits, or several."""
    pressed, coordinates = dry.bearing, coordinates_in(joint, None)
    if pressed is not None and not pressed.has_arm:
        if coordinates == ["angle"]:
            yield armless((*path, "coefficient"))
        elif len(coordinates) > 1:
            yield none_or_several(joint, None, coordinates, path, "coulomb")
    elif not coordinates_in(joint, dry.unit):
        constant = CONSTANT[dry.unit][0]
        key = constant if pressed is None else ARMS[0] if pressed.radius is not None else ARMS[1]
        yield none_or_several(joint, dry.unit, [], (*path, key), "coulomb", DRY_JOINTS)


def _thread(joint: Joint, dry: DryFriction, path: KeyPath) -> Iterator[Complaint]:
    """The complaint about a `bearing_length` that has no effect: the axial force alone presses a thread."""
    pressed = dry.bearing
    alone = pressed is not None and pressed.axial_radius is None and not math.isinf(pressed.length)
    if JOINTS[joint.type].is_threaded and dry.unit == "rad" and alone:
        said = f"'bearing_length' does nothing: 'radius' alone is that of the thread of joint '{joint.name}'"
        yield Complaint((*path, "bearing_length"), said, "'axial_radius' makes 'radius' the arm of the radial force")


def friction_units(joints: Mapping[str, Joint], forces: Mapping[str, Force]) -> dict[str, str]:
    """The units of the coordinates along which dry friction may stick, by the friction's name in results: in joints, of
    ropes on sheaves, at stops."""
    named = [with_coordinates(force, joints) for force in forces.values() if isinstance(force, JointForce)]
    in_joints = {
        force.called(coordinate): dry.unit
        for force in named
        for coordinate, dry in force.coulomb.items()
        if dry.regularised is None
    }
    on_ropes = {
        f"{joint.name}.slip_{number}": "m"
        for joint in joints.values()
        if "path" in joint.parameters
        for number, _ in enumerate(joint.parameters["path"].rubbing, 1)
    }
    return (
        in_joints
        | on_ropes
        | {name: "m" for force in forces.values() if isinstance(force, PlaneStop) for name in force.frictions}
    )
