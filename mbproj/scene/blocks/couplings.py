"""Couplings of joint coordinates: the weights of a coupler, the coordinates that its names mean, and rules on them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, TypeVar

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import choose_from
from mbproj.functions.program import COORDINATE, Program, variable
from mbproj.functions.standard import tabulated
from mbproj.joints.table import COORDINATE_UNITS, JOINTS, PRIMITIVE_TYPES, Parameter
from mbproj.scene.blocks.coordinates import WORDS, coordinates_in
from mbproj.scene.fields.fields import (
    Alternatives,
    Complaint,
    Converted,
    Field,
    List,
    NameChoice,
    NameReference,
    Record,
    Schema,
)
from mbproj.scene.fields.functions import Function, table
from mbproj.scene.fields.quantities import Number, different, nonzero, slot_count, tooth_count
from mbproj.scene.fields.reading import Reading, Unfit, label
from mbproj.scene.records import FUNCTION, Coupled, Joint, KeyPath, Pair
from mbproj.scene.text.nodes import MappingNode, Node

# --- The fields that read the parameters of joints --------------------------------------------------------------------


#: The bound of pressure angles, in deg.
STEEPEST = 60.0
#: The sides of a closed curve, and of an open one as seen in its direction.
SIDES = ("outside", "inside", "left", "right")


def _pressure_angle(angle: float) -> float:
    """The angle in rad, or Unfit where teeth cannot have it as their pressure angle."""
    if not 0.0 <= angle < math.radians(STEEPEST):
        raise Unfit("is no pressure angle", f"give one from 0 deg to below {STEEPEST:g} deg; 20 deg is usual")
    return angle


#: The rules on parameters of joints, by the word `may_be` in the joint table.
RULES: Mapping[str, Callable[[float], float]] = {
    "pressure": _pressure_angle,
    "nonzero": nonzero,
    "teeth": tooth_count,
    "slots": slot_count,
}


def parameter(entry: Parameter) -> Field[Any]:
    """The field that reads a parameter of the joint table."""
    if entry.may_be in ("curve", "space_curve", "convex"):
        return _several(entry, NameReference("curve", "curves"))
    if entry.may_be == "side":
        return _several(entry, NameChoice("side", lambda: SIDES))
    number: Field[float] = Number(entry.unit, above=0.0 if entry.may_be == "positive" else None)
    if entry.may_be in RULES:
        number = Converted(number, RULES[entry.may_be])
    return _several(entry, number)


def _several(entry: Parameter, one: Field[Any]) -> Field[Any]:
    return one if entry.many is None else List(one, entry.many, entry.words)


# --- Couplings of joints ----------------------------------------------------------------------------------------------


Value = TypeVar("Value")


@dataclass(frozen=True)
class WithUnit(Field[tuple[Value, str]]):
    """A value in any unit, with the unit that it is written with."""

    value: Field[Value]

    @property
    def expects(self) -> str:
        return self.value.expects

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[Value, str] | None:
        value = self.value.read(node, path, reading)
        return None if value is None else (value, reading.units.get(path, ""))

    def schema(self) -> Schema:
        return self.value.schema()


@dataclass(frozen=True)
class Weights(Field[dict[str, tuple[float, str]]]):
    """Weights of joint coordinates by name, each with the unit in which the scene gives it."""

    node_type: ClassVar[type] = MappingNode

    @property
    def expects(self) -> str:
        return "weights of coordinates, as in {A.angle: 2, B: -1}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> dict[str, tuple[float, str]] | None:
        if not isinstance(node, MappingNode):
            self.reject(node, path, reading)
            return None
        if not node.values:
            reading.report(f"{label(path)} names no coordinate", node.place, f"give {self.expects}")
            return None
        weights = {}
        for name, item in node.values.items():
            at = (*path, name)
            reading.places[at] = node.keys[name]
            weight = WithUnit(Number(None)).read(item, at, reading)
            if weight is not None:
                weights[name] = weight
        return weights if len(weights) == len(node.values) else None

    def schema(self) -> Schema:
        number = Number(None).schema()
        return {"description": self.expects, "type": "object", "additionalProperties": number, "minProperties": 1}


#: The points of a coupling, which has no place in space.
NOWHERE = Pair((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
#: The keys of a coupler in place of the names of joints.
COUPLER: Mapping[str, Field[Any]] = {
    "of": Weights(),
    "function": WithUnit(
        Alternatives(
            (
                Function(None, ("s",), (COORDINATE,), units=()),
                Converted(
                    table(None, None, ("natural", "clamped", "periodic")),
                    lambda rows: Program(tabulated(rows, variable(COORDINATE))),
                ),
            )
        )
    ),
    "constant": WithUnit(Number(None)),
    "pressure_angle": parameter(Parameter("rad", "pressure")),
}


def coupling_record(type_name: str, joint_type: NameChoice) -> Record[Joint]:
    """The record of a coupler, or of a joint of another type that couples coordinates of joints."""
    kind = JOINTS[type_name]
    if not kind.couples:
        return Record(f"a {type_name} joint", {"type": joint_type, **COUPLER}, _coupler, ("type", "of"), named=True)
    parameters = {name: parameter(each) for name, each in kind.parameters.items()}
    names = List(NameReference("joint", "joints"), len(kind.couples), "names of joints")
    coupling = {"type": joint_type, "joints": Converted(names, different), **parameters}
    both = tuple(key for key in coupling if key not in parameters or key in kind.required_parameters)
    return Record(f"a {type_name} joint", coupling, _coupling, both, named=True)


def _coupling(name: str, type: str, joints: tuple[str, ...], **parameters: Any) -> Joint:
    """The joint of a coupling. `read` fills in its bodies, which are those of the joints it couples, and the names of
    the coordinates."""
    coupling = JOINTS[type].coupling
    assert coupling is not None
    ratio = coupling(**parameters)
    coupled = Coupled(dict(zip(joints, ratio.weights, strict=True)), ratio.function, period=ratio.period)
    return Joint(name, type, ("", ""), NOWHERE, parameters=parameters, couples=coupled)


def _coupler(
    name: str,
    type: str,
    of: Mapping[str, tuple[float, str]],
    function: tuple[Program, str] | None = None,
    constant: tuple[float, str] | None = None,
    pressure_angle: float | None = None,
) -> Joint:
    """The joint of a coupler. With a pressure angle its weights are the teeth of two wheels."""
    weights = {each: weight for each, (weight, _) in of.items()}
    units = {each: unit for each, (_, unit) in of.items()}
    teeth: dict[str, Any] = {}
    if pressure_angle is not None:
        teeth = {"teeth": tuple(weights.values()), "pressure_angle": pressure_angle}
    value, units[""] = (None, "") if constant is None else constant
    program, units[FUNCTION] = (None, "") if function is None else function
    coupled = Coupled(weights, program, value, units=units)
    return Joint(name, type, ("", ""), NOWHERE, parameters=teeth, couples=coupled)


def coupled_units(type_name: str) -> tuple[str, ...]:
    """The units of the coordinates that a joint of this type couples; () for a coupler, which couples any."""
    return tuple(COORDINATE_UNITS[each] for each in JOINTS[type_name].couples)


def with_coupled(joint: Joint, joints: Mapping[str, Joint]) -> Joint:
    """The coupling with full names of the coordinates that it couples; its bodies become the second bodies of the first
    and of the last of these joints."""
    coupled = joint.couples
    assert coupled is not None
    candidates = [_coordinates_meant(joint, at, name, joints) for at, name in enumerate(coupled.of)]
    of = {able[0]: weight for able, weight in zip(candidates, coupled.of.values(), strict=True)}
    first, last = (joints[coupled.joints[at]].bodies[1] for at in (0, -1))
    is_length = any(joints[owner].units[coordinate] == "m" for owner, coordinate in (name.split(".") for name in of))
    unit = "m" if is_length else "rad"
    return replace(joint, bodies=(first, last), couples=replace(coupled, of=of, unit=unit, units={}))


def couple_coordinates(joints: Mapping[str, Joint]) -> Iterator[Complaint]:
    """A check that the coordinates of couplings exist, and that their weights have the unit that the sum needs."""
    for joint in joints.values():
        coupled = joint.couples
        if coupled is None:
            continue
        wrong = [each for at, name in enumerate(coupled.of) for each in _name_faults(joint, at, name, joints)]
        yield from wrong or (() if JOINTS[joint.type].couples else _weight_faults(joint, coupled, joints))


def _unit(joint: Joint, at: int) -> str | None:
    """The unit that the coordinate number `at` of a coupling must have; None for any."""
    return dict(enumerate(coupled_units(joint.type))).get(at)


def _coordinates_meant(joint: Joint, at: int, name: str, joints: Mapping[str, Joint]) -> list[str]:
    """The full names, as "A.angle", of the coordinates that the name number `at` of a coupling, "A" or "A.angle", may
    mean."""
    unit = _unit(joint, at)
    owner, _, coordinate = name.partition(".")
    able, rows = coordinates_in(joints[owner], unit), JOINTS[joints[owner].type].coordinates
    return [
        f"{owner}.{each}" for each in able if coordinate in ("", each) and not PRIMITIVE_TYPES[rows[each][0]].uncoupled
    ]


def _name_faults(joint: Joint, at: int, name: str, joints: Mapping[str, Joint]) -> Iterator[Complaint]:
    """The complaint about a name that means no coordinate, or several, or one that cannot be coupled."""
    owner, _, coordinate = name.partition(".")
    short = bool(JOINTS[joint.type].couples)
    path: KeyPath = ("joints", joint.name, "joints", at) if short else ("joints", joint.name, "of", name)
    if owner not in joints:
        if not short:
            yield Complaint(path, f"unknown joint '{owner}'", choose_from(owner, list(joints)))
        return
    kind, able = joints[owner].type, _coordinates_meant(joint, at, name, joints)
    if len(able) == 1:
        return
    row = JOINTS[kind].coordinates.get(coordinate)
    if row is not None and (what := PRIMITIVE_TYPES[row[0]].uncoupled):
        yield Complaint(path, f"{what}, as '{name}', cannot be coupled", "couple other coordinates")
        return
    if coordinate:
        has = ", ".join(JOINTS[kind].coordinates)
        yield Complaint(path, f"joint '{owner}' is {kind} and has no {coordinate} to couple", has and f"it has {has}")
        return
    unit = _unit(joint, at)
    word = WORDS[unit]
    if able:
        hint = "write " + " or ".join(able) if not short else "couple them by a coupler, which names coordinates"
        yield Complaint(path, f"joint '{owner}' is {kind} and has {len(able)} {word}s", hint)
        return
    takes = [
        each
        for each, entry in JOINTS.items()
        if entry.coordinates and (unit is None or _has_one_in(unit, entry.coordinates))
    ]
    which = f" as its {_ORDINAL[at]} joint" if _couples_different_units(joint.type) else ""
    hint = f"a {joint.type} takes {', '.join(takes)}{which}"
    yield Complaint(path, f"joint '{owner}' is {kind} and has no {word} to couple", hint)


_ORDINAL = ("first", "second")


def _couples_different_units(type_name: str) -> bool:
    """Whether a coupling couples coordinates in different units."""
    return len({*coupled_units(type_name)}) > 1


def _has_one_in(unit: str, coordinates: Mapping[str, Sequence[str]]) -> bool:
    """Whether exactly one of these coordinates can be coupled and is in the unit."""
    kinds = [PRIMITIVE_TYPES[row[0]] for row in coordinates.values()]
    return [kind.unit for kind in kinds if not kind.uncoupled].count(unit) == 1


def _weight_faults(joint: Joint, coupled: Coupled, joints: Mapping[str, Joint]) -> Iterator[Complaint]:
    """Complaints about a coupler's weights: a coordinate stands twice, all weights are 0, or a unit is wrong. In a sum
    in m the weight of an angle may be a length; all other weights are numbers without unit."""
    path: KeyPath = ("joints", joint.name, "of")
    units, known = {}, dict[str, str]()
    for place, name in enumerate(coupled.of):
        (whole,) = _coordinates_meant(joint, place, name, joints)
        if known.setdefault(whole, name) != name:
            yield Complaint((*path, name), f"'{known[whole]}' and '{name}' are one coordinate", "add their weights")
        owner, _, coordinate = whole.partition(".")
        units[name] = joints[owner].units[coordinate]
    mesh = len(units) == 2 and {*units.values()} == {"rad"} and coupled.function is None and all(coupled.of.values())
    if "teeth" in joint.parameters and not mesh:
        hint = "give each mesh its own coupler of two angles, or leave it out"
        at: KeyPath = ("joints", joint.name, "pressure_angle")
        yield Complaint(at, "teeth mesh between two wheels, and this is not a sum of two angles", hint)
    if not any(coupled.of.values()) and coupled.function is None:
        yield Complaint(path, "all weights are 0: nothing is coupled", "give a weight other than 0")
    row = "m" if "m" in units.values() else "rad"
    constant = coupled.units.get("", "")
    if constant not in ("", row):
        message = f"the constant has the unit {row}, or none, this is in {constant}"
        yield Complaint(("joints", joint.name, "constant"), message, f"the sum is in {row}")
    written = coupled.units.get(FUNCTION, "")
    if written not in ("", row):
        message = f"the function has the unit {row}, or none, this is in {written}"
        yield Complaint(("joints", joint.name, "function"), message, f"the sum is in {row}")
    for name in coupled.of:
        written = coupled.units.get(name, "")
        able = ("", "m", "m/rad") if (row, units[name]) == ("m", "rad") else ("", "1")
        if written not in able:
            wants = f"has the unit {able[1]}, or none" if able[1] == "m" else "has no unit"
            message = f"the weight of '{name}' {wants}, this is in {written}"
            yield Complaint((*path, name), message, f"the sum is in {row}")
