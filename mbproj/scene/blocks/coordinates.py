"""Rules on forces and motions: the bodies and the joint coordinates that they name exist."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from mbproj.base.errors import choose_from
from mbproj.joints.table import COORDINATE_UNITS, JOINTS
from mbproj.scene.fields.fields import Complaint
from mbproj.scene.records import GROUND, Body, Force, Joint, JointForce, KeyPath, Motion, PointForce

#: The coordinates of joints by name, with their units.
COORDINATES: Mapping[str, str] = MappingProxyType(
    {name: COORDINATE_UNITS[row[0]] for kind in JOINTS.values() for name, row in kind.coordinates.items()}
)
#: The name of the slip that dry friction resists in joints without a coordinate for it.
SLIP = "slip"
WORDS = {"rad": "angle", "m": "displacement", None: "coordinate"}


def coordinates_in(joint: Joint, unit: str | None) -> list[str]:
    """The coordinates of a joint that are in this unit (None: any)."""
    rows = JOINTS[joint.type].coordinates
    return [name for name, row in rows.items() if unit in (None, COORDINATE_UNITS[row[0]])]


def with_coordinates(force: JointForce, joints: Mapping[str, Joint]) -> JointForce:
    """The force with a name for each coordinate that the scene leaves out: the only coordinate of its joint in that
    unit, or the slip that dry friction resists there. Where there is none or several, the law is left out, which
    another rule reports."""
    joint = joints[force.joint]

    def names(name: str, unit: str | None) -> list[str]:
        able = [name] if name else coordinates_in(joint, unit)
        return able if len(able) == 1 else []

    laws = {each: law for name, law in force.laws.items() for each in names(name, force.unit)}
    slips = [SLIP] if JOINTS[joint.type].slip else None
    coulomb = {each: dry for name, dry in force.coulomb.items() for each in slips or names(name, dry.unit)}
    return replace(force, laws=laws, coulomb=coulomb)


def on_bodies(bodies: Mapping[str, Body], forces: Mapping[str, Force]) -> Iterator[Complaint]:
    """A check that the points of forces are on bodies of the scene."""
    from mbproj.scene.records import DistanceStop

    known = (GROUND, *bodies)
    for force in forces.values():
        points = force.bodies if isinstance(force, PointForce) else ()
        if isinstance(force, DistanceStop):
            points = force.first.body, force.second.body
        for name in points:
            if name not in known:
                hint = choose_from(name, known)
                yield Complaint(("forces", force.name, "points", name), f"unknown body '{name}'", hint)


def act_on_coordinates(joints: Mapping[str, Joint], forces: Mapping[str, Force]) -> Iterator[Complaint]:
    """A check that the joint of each force has the coordinates that the force acts on."""
    for force in forces.values():
        if isinstance(force, JointForce):
            joint, path = joints[force.joint], ("forces", force.name)
            for coordinate in force.laws:
                able = coordinates_in(joint, force.unit)
                if coordinate and coordinate not in able:
                    key = "coordinate" if force.unit else "coefficient"
                    yield lacks(joint, coordinate, able, (*path, key))
                elif not coordinate and len(able) != 1:
                    yield none_or_several(joint, force.unit, able, (*path, "joint"), "coefficient")


def drive_coordinates(joints: Mapping[str, Joint], motions: Mapping[str, Motion]) -> Iterator[Complaint]:
    """A check that the joint of each motion has the coordinate that it drives, and that each is driven once."""
    drivers: dict[tuple[str, str], str] = {}
    for motion in motions.values():
        joint, path = joints[motion.joint], ("motions", motion.name, motion.coordinate)
        able = coordinates_in(joint, None)
        first = drivers.setdefault((joint.name, motion.coordinate), motion.name)
        if motion.coordinate not in able:
            yield lacks(joint, motion.coordinate, able, path)
        elif first != motion.name:
            message = f"motion '{first}' drives the {motion.coordinate} of joint '{joint.name}' already"
            yield Complaint(path, message, "keep one of the two")


def lacks(joint: Joint, coordinate: str, able: Iterable[str], path: KeyPath) -> Complaint:
    """The complaint that a joint has no such coordinate; `able` are those that it has."""
    has = ", ".join(able)
    hint = f"it has {has}" if has else _takers(None)
    if coordinate == "length" and JOINTS[joint.type].is_rod:
        hint = "it keeps its length; a joint of type 'telescope' lets it change"
    return Complaint(path, f"joint '{joint.name}' is {joint.type} and has no {coordinate} to act on", hint)


def none_or_several(
    joint: Joint, unit: str | None, able: Sequence[str], path: KeyPath, key: str, kinds: Container[str] = JOINTS
) -> Complaint:
    """The complaint that a joint has no coordinate in this unit, or several, `able`, so that `key` must name them.
    `kinds` are the types of joints that may have one."""
    word = WORDS[unit]
    if not able:
        return Complaint(
            path, f"joint '{joint.name}' is {joint.type} and has no {word} to act on", _takers(unit, kinds)
        )
    several = " and ".join(able)
    hint = f"add coordinate: {able[0]}" if unit else f"write {key}: {{{able[0]}: ..., {able[1]}: ...}}"
    return Complaint(path, f"joint '{joint.name}' is {joint.type} and has {len(able)} {word}s, {several}", hint)


def _takers(unit: str | None, kinds: Container[str] = JOINTS) -> str:
    """A hint with the types of joints among `kinds` that have a coordinate in this unit (None: any)."""
    rows_of = {name: kind.coordinates.values() for name, kind in JOINTS.items() if name in kinds}
    able = [name for name, rows in rows_of.items() if any(unit in (None, COORDINATE_UNITS[row[0]]) for row in rows)]
    return f"joints that have one: {', '.join(able)}"
