"""Reads a URDF as a mechanism: bodies and joints of the tree, forces on these, then the loops."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from mbproj.errors import InputError, Problem, choose_from
from mbproj.formats.chains import Coordinates, Single, connect, follow, span
from mbproj.formats.geometry import Frame, numbers, turn
from mbproj.formats.loops import add_loops
from mbproj.formats.mechanism import ImportedBody, ImportedMechanism, ImportedNames, ImportOptions, Same, said_of
from mbproj.formats.merged import with_hinges, without_rings
from mbproj.formats.signals import add_motions
from mbproj.formats.urdf.loops import loops_beside, loops_in
from mbproj.formats.urdf.model import Urdf, UrdfJoint, number, origin_of, read_urdf_model
from mbproj.formats.visuals import Shapes, Visual, add_visuals, box, capsule, colour, cylinder, mesh_file, sphere
from mbproj.formats.xml import XmlElement
from mbproj.plain_number import plain_number
from mbproj.scene.records import GROUND

GRAVITY = np.array([0.0, 0.0, -9.81])
#: The tags that are read, and those of elements that would affect the motion: a coupling of URDF+; loops, springs and
#: plug-ins of Gazebo, and bodies without gravity there.
READ = ("link", "joint", "material", "loop_joint", "loop")
MOVING = (
    *("coupling", "joint", "gearbox", "plugin", "springReference", "springStiffness"),
    *("gravity", "turnGravityOff", "kinematic", "stopKp", "stopKd", "stopCfm", "stopErp"),
)


def read_urdf(root: XmlElement, path: Path, options: ImportOptions) -> ImportedMechanism:
    """The mechanism of the model in the file at `path`, whose root element is `root`; its root link is the ground."""
    model = read_urdf_model(root)
    loops = [*loops_in(root, model), *loops_beside(path, options.loops, model)]
    frames = _frames(model, options.pose, root)
    mechanism = ImportedMechanism(root.get("name") or path.stem, "URDF", str(path), GRAVITY)
    bodies, joints, coordinates = ImportedNames(frozenset({GROUND})), ImportedNames(), Coordinates()
    called = {model.root: GROUND}
    for joint in model.down():
        still = called[joint.parent] == GROUND and joint.type == "fixed"
        if not still and joint.type == "fixed" and model.links[joint.child].massless:
            called[joint.child] = called[joint.parent]
            mechanism.mark(joint.child, called[joint.parent], frames[joint.child].position)
            continue
        called[joint.child] = GROUND if still else bodies.unused(joint.child)
        if not still:
            _add_part(mechanism, model, called[joint.child], joint.child, frames[joint.child])
            _add_joint(mechanism, joint, frames, called, joints, coordinates, options.pose)
    _add_mimics(mechanism, model, joints, coordinates, options.pose)
    add_loops(mechanism, loops, frames, called, joints)
    with_hinges(mechanism)
    add_motions(mechanism, coordinates, options.motions, options.pose)
    without_rings(mechanism)
    folder = path.resolve().parent
    add_visuals(mechanism, visuals(root, model, frames, called, folder), options.folder or folder)
    _say_rest(mechanism, root, model)
    for kind, names in (("bodies", bodies), ("joints", joints)):
        mechanism.said += said_of(mechanism, kind, names)
    return mechanism


def _frames(model: Urdf, pose: Mapping[str, float], root: XmlElement) -> dict[str, Frame]:
    """The global frames of the links at these joint coordinates; others are zero."""
    able = [name for name, joint in model.joints.items() if joint.type in ("revolute", "continuous", "prismatic")]
    for name in pose:
        if name not in able:
            what = f"the pose names '{name}', which is no joint of the model with a coordinate"
            raise InputError(Problem(what, root.place, choose_from(name, able)))
    frames = {model.root: model.frames[model.root]}
    for joint in model.down():
        value = pose.get(joint.name, 0.0)
        moved = (
            Frame(value * joint.axis, np.eye(3))
            if joint.type == "prismatic"
            else Frame(np.zeros(3), turn(joint.axis, value) if value else np.eye(3))
        )
        frames[joint.child] = frames[joint.parent].then(joint.origin).then(moved)
    return frames


def _add_part(mechanism: ImportedMechanism, model: Urdf, name: str, link: str, frame: Frame) -> None:
    given = model.links[link]
    centre = frame.position + frame.rotation @ given.centre
    mechanism.parts[name] = ImportedBody(name, given.mass, given.inertia, centre, frame.rotation, given.place)
    if given.massless:
        mechanism.say(f"link '{link}'", given.place, "has neither mass nor inertia, and none in the scene", Same.YES)


def _add_joint(
    mechanism: ImportedMechanism,
    joint: UrdfJoint,
    frames: Mapping[str, Frame],
    called: Mapping[str, str],
    names: ImportedNames,
    coordinates: Coordinates,
    pose: Mapping[str, float],
) -> None:
    ends, frame = (called[joint.parent], called[joint.child]), frames[joint.child]
    axis = frame.rotation @ joint.axis
    if joint.type == "fixed":
        mechanism.join(names.unused(joint.name), "fixed", ends, frame.position, place=joint.place)
    elif joint.type == "planar":
        mechanism.join(names.unused(joint.name), "planar", ends, frame.position, axis, place=joint.place)
    elif joint.type != "floating":
        single = Single(joint.name, joint.type != "prismatic", frame.position, axis, place=joint.place)
        connect(mechanism, ends, [_acted_on(mechanism, joint, single, pose)], names.unused, coordinates)


def _acted_on(mechanism: ImportedMechanism, joint: UrdfJoint, single: Single, pose: Mapping[str, float]) -> Single:
    """The turn or slide with the limits and losses of its joint."""
    at, shown = pose.get(joint.name, 0.0), f"joint '{joint.name}'"
    limit, dynamics = joint.element.first("limit"), joint.element.first("dynamics")
    limited = single
    if (
        limit is not None
        and joint.type != "continuous"
        and ("lower" in limit.attributes or "upper" in limit.attributes)
    ):
        low, high = number(limit, "lower", "0") - at, number(limit, "upper", "0") - at
        limited = replace(limited, range=span(mechanism, joint.name, limit.place, low, high))
    if limit is not None and ("effort" in limit.attributes or "velocity" in limit.attributes):
        mechanism.say(f"effort and velocity of {shown}", limit.place, "left out: they are limits of a motor", Same.YES)
    if dynamics is not None:
        damping, friction = number(dynamics, "damping", "0"), number(dynamics, "friction", "0")
        stiffness = number(dynamics, "spring_stiffness", "0")
        rest = number(dynamics, "spring_reference", "0") - at if stiffness else 0.0  # attributes that SDF has, too
        limited = replace(limited, damping=damping, dry=friction, stiffness=stiffness, rest=rest)
        _say_unread(mechanism, shown, dynamics)
    for tag in ("safety_controller", "calibration"):
        element = joint.element.first(tag)
        if element is not None:
            mechanism.say(f"<{tag}> of {shown}", element.place, "left out: it is a controller's", Same.YES)
    return limited


def _say_unread(mechanism: ImportedMechanism, shown: str, dynamics: XmlElement) -> None:
    """Add a row on attributes of <dynamics> that are not read and not zero."""
    for name, text in dynamics.attributes.items():
        if name in ("damping", "friction", "spring_stiffness", "spring_reference"):
            continue
        try:
            nothing = plain_number(text) == 0.0
        except ValueError:
            nothing = False
        if not nothing:
            what = "left out: it is not read, and may act on the motion"
            mechanism.say(f"'{name}' of {shown}", dynamics.place, what, Same.NO)


def _add_mimics(
    mechanism: ImportedMechanism, model: Urdf, names: ImportedNames, coordinates: Coordinates, pose: Mapping[str, float]
) -> None:
    """Add a coupler for each mimic: s = multiplier s' + offset, with both coordinates counted from the pose."""
    for joint in model.joints.values():
        mimic = joint.element.first("mimic")
        if mimic is None:
            continue
        leader = mimic.get("joint")
        if leader not in model.joints:
            hint = choose_from(leader, list(model.joints))
            raise InputError(Problem(f"unknown joint '{leader}'", mimic.place, hint))
        if joint.name not in coordinates or leader not in coordinates:
            mechanism.say(f"mimic of joint '{joint.name}'", mimic.place, "left out: a joint has no coordinate", Same.NO)
            continue
        multiplier, offset = number(mimic, "multiplier", "1"), number(mimic, "offset", "0")
        constant = offset + multiplier * pose.get(leader, 0.0) - pose.get(joint.name, 0.0)
        ends = (".".join(coordinates[joint.name]), ".".join(coordinates[leader]))
        follow(mechanism, names, ends, multiplier, constant, mimic.place)


def _say_rest(mechanism: ImportedMechanism, root: XmlElement, model: Urdf) -> None:
    """Add rows on parts without effect on the motion, or without a counterpart in a scene."""
    touching = sum(len(link.element.all("collision")) for link in model.links.values())
    if touching:
        mechanism.say(f"{touching} collision shapes", None, "left out: shapes pass through each other", Same.UNTIL)
    for element in root.children:
        if element.tag in READ:
            continue
        inertia = any(each.tag == "motorInertia" for each in element.walk())
        if element.tag == "transmission" and not inertia:
            mechanism.say("<transmission>", element.place, "left out: it is a motor's", Same.YES)
        elif inertia or any(each.tag in MOVING for each in element.walk()):
            what = "left out: it is not read, and may act on the motion"
            mechanism.say(f"<{element.tag}>", element.place, what, Same.NO)
        else:
            mechanism.say(f"<{element.tag}>", element.place, "left out: it does not act on the motion", Same.YES)


def visuals(
    root: XmlElement, model: Urdf, frames: Mapping[str, Frame], called: Mapping[str, str], folder: Path
) -> Iterator[Visual]:
    """Yield the visuals of all links. Raises InputError at numbers that are wrong."""
    materials = {each.get("name"): _colour(each) for each in root.walk() if each.tag == "material" and each.children}
    for link in model.links.values():
        for element in link.element.all("visual"):
            pose = frames[link.name].then(origin_of(element.first("origin")))
            geometry, material = element.first("geometry"), element.first("material")
            look = materials.get(material.get("name")) if material is not None else None
            kind = geometry.children[0] if geometry is not None and geometry.children else None
            if kind is None:
                continue
            body = called[link.name]
            if kind.tag != "mesh":
                yield Visual(body, pose, _shapes(kind), colour=look)
                continue
            scale = numbers(kind.get("scale", "1 1 1"), 3, kind.place, "'scale'")
            file = mesh_file(kind.get("filename"), folder) if np.ptp(scale) == 0.0 else None
            yield Visual(body, pose, (), file, float(scale[0]), look, "meshes")


def _colour(material: XmlElement) -> str | None:
    given = material.first("color")
    return None if given is None else colour(numbers(given.get("rgba", "0 0 0 1"), 4, given.place, "'rgba'").tolist())


def _shapes(kind: XmlElement) -> Shapes:
    if kind.tag == "box":
        return box(numbers(kind.get("size"), 3, kind.place, "'size'"))
    if kind.tag == "sphere":
        return sphere(number(kind, "radius"))
    if kind.tag in ("cylinder", "capsule"):
        return (cylinder if kind.tag == "cylinder" else capsule)(number(kind, "radius"), number(kind, "length"))
    return ()
