"""A URDF file as links and joints: their numbers, and the place of each in the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.formats.geometry import IDENTITY, Frame, check_inertia, from_rpy, numbers, unit
from mbproj.formats.xml import XmlElement

#: The number of coordinates of each type of joint.
TYPES = {"fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 1, "planar": 3, "floating": 6}


@dataclass(frozen=True, eq=False)
class UrdfLink:
    """A link: its mass, its inertia (3, 3) about the centre of mass, and that centre (3,), both in the link's frame."""

    name: str
    mass: float
    inertia: Array
    centre: Array
    element: XmlElement

    @property
    def place(self) -> Place:
        return self.element.place

    @property
    def massless(self) -> bool:
        """Whether the link has neither mass nor inertia, so that it is only a frame."""
        return not self.mass and not self.inertia.any()


@dataclass(frozen=True, eq=False)
class UrdfJoint:
    """A joint between two links. `origin` is its frame in the parent's frame, and also the frame of the child; `axis`
    is in that frame."""

    name: str
    type: str
    parent: str
    child: str
    origin: Frame
    axis: Array
    element: XmlElement

    @property
    def place(self) -> Place:
        return self.element.place


@dataclass(frozen=True, eq=False)
class Urdf:
    """The links and joints by name, in the order of the file; `frames` are those of links at the zero pose, in the
    root's."""

    root: str
    links: dict[str, UrdfLink]
    joints: dict[str, UrdfJoint]
    frames: dict[str, Frame] = field(default_factory=dict)

    def down(self) -> Iterator[UrdfJoint]:
        """Yield the joints from the root on."""
        children: dict[str, list[UrdfJoint]] = {}
        for joint in self.joints.values():
            children.setdefault(joint.parent, []).append(joint)
        waiting = [self.root]
        while waiting:
            for joint in children.get(waiting.pop(0), []):
                yield joint
                waiting.append(joint.child)


def origin_of(element: XmlElement | None) -> Frame:
    """The pose in an <origin>, or in an element with the same attributes."""
    if element is None:
        return IDENTITY
    xyz = numbers(element.get("xyz", "0 0 0"), 3, element.place, "'xyz'")
    rpy = numbers(element.get("rpy", "0 0 0"), 3, element.place, "'rpy'")
    return Frame(xyz, from_rpy(*rpy))


def number(element: XmlElement, name: str, default: str | None = None) -> float:
    """A number in an attribute. Raises InputError where it is missing or none."""
    text = element.get(name, default or "")
    return float(numbers(text, 1, element.place, f"'{name}' of <{element.tag}>")[0])


def axis_of(element: XmlElement) -> Array:
    """The unit axis of a joint, x where none is given."""
    axis = element.first("axis")
    if axis is None:
        return np.array([1.0, 0.0, 0.0])
    given = numbers(axis.get("xyz", "1 0 0"), 3, axis.place, "'xyz' of <axis>")
    if not given.any():
        raise InputError(Problem("the axis has no direction", axis.place, "give one of its numbers"))
    return unit(given)


def read_urdf_model(root: XmlElement) -> Urdf:
    """Read the links and joints. Raises InputError, all problems at once, where they make no tree."""
    problems: list[Problem] = []
    links: dict[str, UrdfLink] = {}
    joints: dict[str, UrdfJoint] = {}
    for element in root.all("link", "joint"):
        known: dict[str, UrdfLink] | dict[str, UrdfJoint] = links if element.tag == "link" else joints
        name = element.get("name")
        if not name or name in known:
            what = f"a second {element.tag} '{name}'" if name else f"a {element.tag} without a name"
            problems.append(Problem(what, element.place, "give each a name of its own"))
            continue
        try:
            if element.tag == "link":
                links[name] = _link(element)
            else:
                joints[name] = _joint(element)
        except InputError as error:
            problems += error.problems
    for joint in joints.values():
        for end in (joint.parent, joint.child):
            if end not in links and not any(each.get("name") == end for each in root.all("link")):
                problems.append(Problem(f"unknown link '{end}'", joint.place, choose_from(end, list(links))))
    if not links and not problems:
        problems.append(Problem("the model has no link", root.place, "a robot has links and joints"))
    if problems:
        raise InputError(problems)
    model = Urdf(_root(links, joints, root), links, joints)
    model.frames[model.root] = IDENTITY
    for joint in model.down():
        model.frames[joint.child] = model.frames[joint.parent].then(joint.origin)
    lost = [name for name in links if name not in model.frames]
    if lost:
        raise InputError(
            Problem(f"the joints of link '{lost[0]}' go in a circle", links[lost[0]].place, "write it as a loop")
        )
    return model


def _root(links: dict[str, UrdfLink], joints: dict[str, UrdfJoint], element: XmlElement) -> str:
    """The one link that is no child."""
    parents: dict[str, UrdfJoint] = {}
    for joint in joints.values():
        if joint.child in parents:
            what = f"link '{joint.child}' is the child of '{parents[joint.child].name}' already"
            raise InputError(Problem(what, joint.place, "URDF is a tree: write the second one as a <loop_joint>"))
        parents[joint.child] = joint
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        what = f"the model has {len(roots)} links without a parent" if roots else "the joints go in a circle"
        where = links[roots[1]].place if len(roots) > 1 else element.place
        raise InputError(Problem(what, where, "connect them by joints, or write a loop as a <loop_joint>"))
    return roots[0]


def _link(element: XmlElement) -> UrdfLink:
    inertial = element.first("inertial")
    if inertial is None:
        return UrdfLink(element.get("name"), 0.0, np.zeros((3, 3)), np.zeros(3), element)
    pose = origin_of(inertial.first("origin"))
    mass_of, given = inertial.first("mass"), inertial.first("inertia")
    mass = number(mass_of, "value") if mass_of is not None else 0.0
    inertia = np.zeros((3, 3))
    if given is not None:
        xx, yy, zz = (number(given, name, "0") for name in ("ixx", "iyy", "izz"))
        xy, xz, yz = (number(given, name, "0") for name in ("ixy", "ixz", "iyz"))
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    check_inertia(mass, inertia, (mass_of or inertial).place, (given or inertial).place)
    turned = pose.rotation @ inertia @ pose.rotation.T
    return UrdfLink(element.get("name"), mass, 0.5 * (turned + turned.T), pose.position, element)


def _joint(element: XmlElement) -> UrdfJoint:
    kind = element.get("type")
    if kind not in TYPES:
        raise InputError(Problem(f"unknown joint type '{kind}'", element.place, choose_from(kind, list(TYPES))))
    ends = []
    for tag in ("parent", "child"):
        end = element.first(tag)
        if end is None:
            raise InputError(Problem(f"joint '{element.get('name')}' has no <{tag}>", element.place, "name a link"))
        ends.append(end.get("link"))
    axis = np.zeros(3) if kind in ("fixed", "floating") else axis_of(element)  # files write 0 0 0 there
    return UrdfJoint(element.get("name"), kind, ends[0], ends[1], origin_of(element.first("origin")), axis, element)
