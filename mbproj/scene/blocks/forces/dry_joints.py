"""Rules on dry friction in joints: the joint has its coordinate, or exactly one that fits where none is named."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from mbproj.joints import JOINTS
from mbproj.scene.blocks.coordinates import coordinates_in, lacks, none_or_several, with_coordinates
from mbproj.scene.blocks.forces.coulomb import ARMS, CONSTANT, armless
from mbproj.scene.fields.containers import Complaint
from mbproj.scene.friction import DryFriction
from mbproj.scene.records import Force, Joint, JointForce, KeyPath
from mbproj.scene.stops import PlaneStop

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
            own = coordinates_in(joint, None)
            if coordinate and coordinate not in own:
                yield lacks(joint, coordinate, own, path)
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
    pressed, own = dry.bearing, coordinates_in(joint, None)
    if pressed is not None and not pressed.has_arm:
        if own == ["angle"]:
            yield armless((*path, "coefficient"))
        elif len(own) > 1:
            yield none_or_several(joint, None, own, path, "coulomb")
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
