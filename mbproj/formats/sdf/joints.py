"""Joints of an SDF as joints of a scene, with all that acts on their coordinates, and couplers for mimics and gears."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field, replace
from math import pi
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.formats.chains import Coordinates, Single, add_one, connect, follow, span
from mbproj.formats.geometry import IDENTITY, Frame, direction, limit, turn
from mbproj.formats.mechanism import Connection, ImportedMechanism, ImportedNames, Loop, Quantity, Same
from mbproj.formats.sdf.scopes import Scope, SdfFrames, number, text, vector
from mbproj.formats.xml import XmlElement

#: The joint of a scene for each type; that of a universal joint, and of two turns in a row, depends on the axes.
TYPES = {
    "fixed": "fixed",
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "ball": "spherical",
    "universal": "",
    "revolute2": "",
    "screw": "screw",
    "gearbox": "",
}


@dataclass(frozen=True, eq=False)
class SdfJoint:
    """A joint: its name in the scene, its links by full name, its frame in each of them, its unit axes in these."""

    name: str
    type: str
    links: tuple[str, str]
    frames: tuple[Frame, Frame]
    axes: tuple[Array, ...]
    scope: Scope
    element: XmlElement
    elements: tuple[XmlElement, ...] = field(default=())

    @property
    def place(self) -> Place:
        return self.element.place

    def coordinate(self, axis: str = "axis") -> str:
        """The name of its coordinate about an axis."""
        return self.name if axis == "axis" else f"{self.name}_{axis}"

    def pose_at(self, value: float) -> Frame:
        """The pose of its frame in the child, in its frame in the parent, at a value of the coordinate in rad or m."""
        if not value:  # a ball has no axis
            return IDENTITY
        if self.type == "prismatic":
            return Frame(value * self.axes[0], np.eye(3))
        along = value / (2 * pi) * pitch_of(self.element) if self.type == "screw" else 0.0
        return Frame(along * self.axes[0], turn(self.axes[0], value))


def read_joint(
    scope: Scope, frames: SdfFrames, element: XmlElement, name: str, meet: bool, links: Mapping[str, Frame]
) -> SdfJoint:
    """Read a joint. Its frame is at the child, where the file puts it, or with `meet` where the named frames of both
    links coincide. `links` are poses in the world. Raises InputError where something is missing."""
    kind = element.get("type")
    if kind not in TYPES:
        raise InputError(Problem(f"unknown joint type '{kind}'", element.place, choose_from(kind, list(TYPES))))
    ends = [text(element, tag) for tag in ("parent", "child")]
    for tag, end in zip(("parent", "child"), ends, strict=True):
        if not end:
            raise InputError(Problem(f"joint '{element.get('name')}' has no <{tag}>", element.place, "name a link"))
    parent, child = (frames.link(scope, end, element.place) for end in ends)
    stands = frames.pose(scope, element.get("name"), element.place)
    in_child = links[child].inverse().then(stands)
    in_parent = links[parent].inverse().then(stands)
    if meet:
        held, other = (frames.pose(scope, end, element.place) for end in ends)
        in_parent = links[parent].inverse().then(held).then(other.inverse().then(stands))
    elements = tuple(each for each in (element.first("axis"), element.first("axis2")) if each is not None)
    axes = tuple(_axis(scope, frames, each, stands) for each in elements)
    needed = {"fixed": 0, "ball": 0, "universal": 2, "revolute2": 2, "gearbox": 2}.get(kind, 1)
    if len(axes) < needed:
        tag = "axis" if not axes else "axis2"
        raise InputError(Problem(f"joint '{element.get('name')}' has no <{tag}>", element.place, "give its <xyz>"))
    return SdfJoint(name, kind, (parent, child), (in_parent, in_child), axes, scope, element, elements)


def _axis(scope: Scope, frames: SdfFrames, element: XmlElement, stands: Frame) -> Array:
    """The unit axis in the joint's frame; the file may give it in another frame that it names."""
    xyz = element.first("xyz")
    axis = vector(element, "xyz", "0 0 1")
    within = "" if xyz is None else xyz.get("expressed_in")
    if text(element, "use_parent_model_frame") in ("true", "1"):
        within = "__model__"
    if within:
        axis = stands.rotation.T @ frames.pose(scope, within, element.place).rotation @ axis
    return direction(axis, element.place, "the axis")


def pitch_of(element: XmlElement) -> float:
    """The advance of a screw in m a turn. Files before version 1.10 give -2π divided by it."""
    if element.first("screw_thread_pitch") is None and element.first("thread_pitch") is not None:
        old = number(element, "thread_pitch", 1.0)
        return -2.0 * pi / old if old else 0.0
    return number(element, "screw_thread_pitch", 1.0)


def add_joint(
    mechanism: ImportedMechanism,
    joint: SdfJoint,
    links: Mapping[str, Frame],
    called: Mapping[str, str],
    names: ImportedNames,
    coordinates: Coordinates,
    pose: Mapping[str, float],
) -> None:
    """Add a joint whose frames in both links agree."""
    bodies = (called[joint.links[0]], called[joint.links[1]])
    stands = links[joint.links[1]].then(joint.frames[1])
    kind = TYPES[joint.type]
    if kind in ("fixed", "spherical"):
        mechanism.join(names.unused(joint.name), kind, bodies, stands.position, place=joint.place)
        return
    first = links[joint.links[0]].then(joint.frames[0])  # the joint does not turn its first axis in the parent
    singles = []
    for at, (axis, element) in enumerate(zip(joint.axes, joint.elements, strict=True)):
        frame = first if at == 0 else stands
        name = joint.coordinate(element.tag)
        turns = joint.type != "prismatic"
        alone = Single(name, turns, stands.position, frame.rotation @ axis, place=joint.place)
        singles.append(acted_on(mechanism, joint, element, alone, pose.get(name, 0.0)))
    if kind == "screw":
        name, (single,) = names.unused(joint.name), singles[:1]
        pitch = {"pitch": Quantity(pitch_of(joint.element), "m")}
        add_one(mechanism, name, kind, bodies, single.point, single.axis, [(single, "angle")], pitch)
        coordinates[single.name] = (name, "angle")
    else:
        connect(mechanism, bodies, singles if not kind else singles[:1], names.unused, coordinates)


def acted_on(mechanism: ImportedMechanism, joint: SdfJoint, element: XmlElement, single: Single, at: float) -> Single:
    """The turn or slide with its limits, losses, spring and rotor; `at` is the value of its coordinate at the pose."""
    limits, dynamics = element.first("limit"), element.first("dynamics")
    limited = single
    if limits is not None and joint.type != "continuous":
        low = limit(text(limits, "lower", "-inf"), limits.place, "<lower>")
        high = limit(text(limits, "upper", "inf"), limits.place, "<upper>")
        if low <= high:
            limited = replace(limited, range=span(mechanism, single.name, limits.place, low - at, high - at))
        if limits.first("stiffness") or limits.first("dissipation"):
            what = "a stiff spring in the model, a rigid stop in the scene"
            mechanism.say(f"limit of joint '{single.name}'", limits.place, what, Same.UNTIL)
    if limits is not None and (limits.first("effort") or limits.first("velocity")):
        shown = f"effort and velocity of joint '{single.name}'"
        mechanism.say(shown, limits.place, "left out: they are limits of a motor", Same.YES)
    if dynamics is not None:
        stiffness = number(dynamics, "spring_stiffness")
        limited = replace(
            limited,
            damping=number(dynamics, "damping"),
            dry=number(dynamics, "friction"),
            stiffness=stiffness,
            rest=number(dynamics, "spring_reference") - at if stiffness else 0.0,
        )
    rotor = joint.element.first("drake:rotor_inertia")
    if rotor is not None and element.tag == "axis":
        ratio = number(joint.element, "drake:gear_ratio", 1.0)
        limited = replace(limited, armature=number(joint.element, "drake:rotor_inertia") * ratio**2)
    return limited


def open_loop(mechanism: ImportedMechanism, joint: SdfJoint) -> Loop | None:
    """The loop of a joint whose frames are apart at the pose; None where its type cannot be closed from a distance. All
    that acts on its coordinate is left out, since its zero is not known."""
    kind = TYPES[joint.type]
    if kind not in ("fixed", "spherical", "revolute", "prismatic"):
        what = f"left out: a {joint.type} joint is not closed from a distance"
        mechanism.say(f"joint '{joint.name}'", joint.place, what, Same.NO)
        return None
    if any(each.first("limit") or each.first("dynamics") for each in joint.elements):
        what = "left out: it closes a loop that is open at the pose"
        mechanism.say(f"what acts on joint '{joint.name}'", joint.place, what, Same.NO)
    axis = joint.axes[0] if joint.axes else np.array([0.0, 0.0, 1.0])
    return Loop(joint.name, kind, joint.links, joint.frames, axis, joint.place)


def add_mimics(
    mechanism: ImportedMechanism,
    joints: Mapping[tuple[int, str], SdfJoint],
    names: ImportedNames,
    coordinates: Coordinates,
    pose: Mapping[str, float],
) -> None:
    """Add a coupler for each mimic: s = multiplier (s' - reference) + offset, with s and s' counted from the pose.
    `joints` are by scope and name."""
    for joint in joints.values():
        for element in joint.elements:
            mimic = element.first("mimic")
            if mimic is None:
                continue
            follower = joint.coordinate(element.tag)
            leader = _leader(joints, joint, mimic).coordinate(mimic.get("axis") or "axis")
            if follower not in coordinates or leader not in coordinates:
                what = "left out: a joint has no coordinate"
                mechanism.say(f"mimic of joint '{joint.name}'", mimic.place, what, Same.NO)
                continue
            ratio, offset = number(mimic, "multiplier"), number(mimic, "offset")
            start = ratio * (pose.get(leader, 0.0) - number(mimic, "reference"))
            ends = (".".join(coordinates[follower]), ".".join(coordinates[leader]))
            follow(mechanism, names, ends, ratio, offset + start - pose.get(follower, 0.0), mimic.place)


def _leader(joints: Mapping[tuple[int, str], SdfJoint], joint: SdfJoint, mimic: XmlElement) -> SdfJoint:
    scope, name = joint.scope, mimic.get("joint")
    while "::" in name and name.partition("::")[0] in scope.models:
        outer, _, name = name.partition("::")
        scope = scope.models[outer]
    if (id(scope), name) not in joints:
        able = [each for at, each in joints if at == id(scope)]
        raise InputError(Problem(f"unknown joint '{name}'", mimic.place, choose_from(name, able)))
    return joints[id(scope), name]


def add_gearboxes(
    mechanism: ImportedMechanism,
    joints: Mapping[tuple[int, str], SdfJoint],
    links: Mapping[str, Frame],
    link_of: Callable[[Scope, str, Place], str],
    names: ImportedNames,
    coordinates: Coordinates,
) -> None:
    """Add a coupler for each gearbox: θ₂ = -ratio θ₁. These are the angles of the child and the parent against a
    reference body, about the axes of joints with it."""
    for joint in joints.values():
        if joint.type != "gearbox":
            continue
        ratio = number(joint.element, "gearbox_ratio", 1.0)
        reference = text(joint.element, "gearbox_reference_body") or text(joint.element, "reference_body")
        body = link_of(joint.scope, reference, joint.place) if reference else ""
        turns = [_turn_of(joint, side, body, joints, links, coordinates) for side in (0, 1)]
        if not reference or None in turns:
            what = "left out: no revolute joints about its axes connect both its links with its reference body"
            mechanism.say(f"gearbox '{joint.name}'", joint.place, what, Same.NO)
            continue
        (first, sign_1), (second, sign_2) = turns  # type: ignore[misc]
        of: dict[str, Any] = {second: sign_2, first: ratio * sign_1}
        name = names.unused(joint.name)
        mechanism.joints[name] = Connection(name, "coupler", keys={"of": of}, place=joint.place)


def _turn_of(
    gearbox: SdfJoint,
    side: int,
    reference: str,
    joints: Mapping[tuple[int, str], SdfJoint],
    links: Mapping[str, Frame],
    coordinates: Coordinates,
) -> tuple[str, float] | None:
    """The coordinate that is the angle of a link of a gearbox against its reference body, and its sign; None where no
    joint measures it."""
    link = gearbox.links[side]
    wanted = links[gearbox.links[1]].rotation @ gearbox.frames[1].rotation @ gearbox.axes[side]
    for joint in joints.values():
        if TYPES[joint.type] != "revolute" or set(joint.links) != {link, reference} or joint.name not in coordinates:
            continue
        axis = links[joint.links[1]].rotation @ joint.frames[1].rotation @ joint.axes[0]
        along = float(axis @ wanted)
        if abs(abs(along) - 1.0) < 1e-9:
            sign = np.sign(along) if joint.links[1] == link else -np.sign(along)
            return ".".join(coordinates[joint.name]), float(sign)
    return None
