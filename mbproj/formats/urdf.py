"""Reads a URDF as a mechanism: bodies and joints of the tree, forces on these, then the loops."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from pathlib import Path

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.base.text import plain_number
from mbproj.formats.chains import Coordinates, Single, connect, follow, span, with_hinges, without_rings
from mbproj.formats.geometry import (
    IDENTITY,
    Frame,
    check_inertia,
    direction,
    from_quaternion,
    from_rpy,
    limit,
    numbers,
    turn,
)
from mbproj.formats.mechanism import (
    ImportedBody,
    ImportedMechanism,
    ImportedNames,
    ImportOptions,
    Loop,
    Same,
    add_loops,
    said_of,
)
from mbproj.formats.signals import add_motions
from mbproj.formats.visuals import Shapes, Visual, add_visuals, box, capsule, colour, cylinder, mesh_file, sphere
from mbproj.formats.xml import XmlElement
from mbproj.scene.records import GROUND
from mbproj.scene.text.document import compose, read_text
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode

# --- A URDF file as links and joints ----------------------------------------------------------------------------------
# Their numbers, and the place of each in the file.


#: The number of coordinates of each type of joint.
JOINT_TYPES = {"fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 1, "planar": 3, "floating": 6}


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
    if "quat_xyzw" in element.attributes:
        if "rpy" in element.attributes:
            raise InputError(Problem("both 'rpy' and 'quat_xyzw' are given", element.place, "leave one of them out"))
        given = numbers(element.get("quat_xyzw"), 4, element.place, "'quat_xyzw'")
        turned = direction(given[[3, 0, 1, 2]], element.place, "the quaternion")
        return Frame(xyz, from_quaternion(turned))
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
    return direction(numbers(axis.get("xyz", "1 0 0"), 3, axis.place, "'xyz' of <axis>"), axis.place, "the axis")


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
    mass_of, moments = inertial.first("mass"), inertial.first("inertia")
    mass = number(mass_of, "value") if mass_of is not None else 0.0
    inertia = np.zeros((3, 3))
    if moments is not None:
        xx, yy, zz = (number(moments, name, "0") for name in ("ixx", "iyy", "izz"))
        xy, xz, yz = (number(moments, name, "0") for name in ("ixy", "ixz", "iyz"))
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    check_inertia(mass, inertia, (mass_of or inertial).place, (moments or inertial).place)
    turned = pose.rotation @ inertia @ pose.rotation.T
    return UrdfLink(element.get("name"), mass, 0.5 * (turned + turned.T), pose.position, element)


def _joint(element: XmlElement) -> UrdfJoint:
    kind = element.get("type")
    if kind not in JOINT_TYPES:
        raise InputError(Problem(f"unknown joint type '{kind}'", element.place, choose_from(kind, list(JOINT_TYPES))))
    ends = []
    for tag in ("parent", "child"):
        end = element.first(tag)
        if end is None:
            raise InputError(Problem(f"joint '{element.get('name')}' has no <{tag}>", element.place, "name a link"))
        ends.append(end.get("link"))
    axis = np.zeros(3) if kind in ("fixed", "floating") else axis_of(element)  # files write 0 0 0 there
    return UrdfJoint(element.get("name"), kind, ends[0], ends[1], origin_of(element.first("origin")), axis, element)


# --- Reads a URDF as a mechanism --------------------------------------------------------------------------------------


GRAVITY = np.array([0.0, 0.0, -9.81])
#: The tags that are read, and those of elements that would affect the motion: a coupling of URDF+; loops, springs and
#: plug-ins of Gazebo, and bodies without gravity there.
READ = (
    *("link", "joint", "material", "loop_joint", "loop"),
    *("inertial", "visual", "collision", "origin", "parent", "child"),
    *("axis", "dynamics", "limit", "mimic", "safety_controller", "calibration"),
)
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
    urdf = model.links[link]
    centre = frame.position + frame.rotation @ urdf.centre
    mechanism.parts[name] = ImportedBody(name, urdf.mass, urdf.inertia, centre, frame.rotation, urdf.place)
    if urdf.massless:
        mechanism.say(f"link '{link}'", urdf.place, "has neither mass nor inertia, and none in the scene", Same.YES)


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
    limits, dynamics = joint.element.first("limit"), joint.element.first("dynamics")
    limited = single
    if (
        limits is not None
        and joint.type != "continuous"
        and ("lower" in limits.attributes or "upper" in limits.attributes)
    ):
        low, high = (limit(limits.get(side, "0"), limits.place, f"'{side}'") - at for side in ("lower", "upper"))
        limited = replace(limited, range=span(mechanism, joint.name, limits.place, low, high))
    of_motor = [] if limits is None else [name for name in limits.attributes if name not in ("lower", "upper")]
    if limits is not None and of_motor:
        said = f"{' and '.join(of_motor)} of {shown}"
        mechanism.say(said, limits.place, "left out: they are limits of a motor", Same.YES)
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
    for element in root.all("loop_joint", "loop"):
        if element.get("type") in WITH_AXIS and element.first("axis") is None:
            what = "its axis is not given: x of its frames, as of joints"
            mechanism.say(f"loop '{element.get('name')}'", element.place, what, Same.YES)
    for element in [*root.children, *(each for part in root.all("link", "joint") for each in part.children)]:
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
    color = material.first("color")
    return None if color is None else colour(numbers(color.get("rgba", "0 0 0 1"), 4, color.place, "'rgba'").tolist())


def _shapes(kind: XmlElement) -> Shapes:
    if kind.tag == "box":
        return box(numbers(kind.get("size"), 3, kind.place, "'size'"))
    if kind.tag == "sphere":
        return sphere(number(kind, "radius"))
    if kind.tag in ("cylinder", "capsule"):
        return (cylinder if kind.tag == "cylinder" else capsule)(number(kind, "radius"), number(kind, "length"))
    return ()


# --- Loops of a URDF, in the dialects that are in use -----------------------------------------------------------------
# In the file:
#     <loop_joint name type><link1 link xyz rpy/><link2 link xyz rpy/><axis xyz/></loop_joint>    Isaac Sim, older Drake
#     <loop name type><predecessor link><origin/></predecessor><successor link><origin/></successor><axis/></loop> URDF+
#     links closing_NAME_1 and closing_NAME_2, frames that meet                                   onshape-to-robot
# Beside the file, in YAML:
#     closed_loop: [[A, B], ..] with type: [3d, 6d, ..], frames of joints or links     Extended URDF
#     ball_loops: [{name, parent, parent_xyz, child, child_xyz}, ..], points of links   loop_closures.yaml


#: The joint of the scene, by the word of a dialect.
LOOP_TYPES = {
    "spherical": "spherical",
    "ball": "spherical",
    "3d": "spherical",
    "fixed": "fixed",
    "6d": "fixed",
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "universal": "universal",
}
#: The words of loops about or along an axis.
WITH_AXIS = ("revolute", "continuous", "prismatic")
_CLOSING = re.compile(r"closing_(.+)_([12])")


def loops_in(root: XmlElement, model: Urdf) -> Iterator[Loop]:
    """Yield the loops in the file itself."""
    for element in root.all("loop_joint"):
        yield _loop(element, [element.first("link1"), element.first("link2")], model, of_origin=False)
    for element in root.all("loop"):
        yield _loop(element, [element.first("predecessor"), element.first("successor")], model, of_origin=True)
    yield from _closing(model)


def _loop(element: XmlElement, ends: list[XmlElement | None], model: Urdf, of_origin: bool) -> Loop:
    name, kind = element.get("name") or "loop", element.get("type", "spherical")
    if kind not in LOOP_TYPES or LOOP_TYPES[kind] == "universal":
        able = [word for word, joint in LOOP_TYPES.items() if joint != "universal"]
        raise InputError(Problem(f"a loop cannot be '{kind}'", element.place, choose_from(kind, able)))
    links, frames = [], []
    for end in ends:
        if end is None or end.get("link") not in model.links:
            link = "" if end is None else end.get("link")
            what = f"loop '{name}' names no link" if end is None else f"unknown link '{link}'"
            place = element.place if end is None else end.place
            raise InputError(Problem(what, place, choose_from(link, list(model.links))))
        links.append(end.get("link"))
        frames.append(origin_of(end.first("origin") if of_origin else end))
    axis = axis_of(element) if kind in WITH_AXIS else np.array([0.0, 0.0, 1.0])
    return Loop(name, LOOP_TYPES[kind], (links[0], links[1]), (frames[0], frames[1]), axis, element.place)


def _closing(model: Urdf) -> Iterator[Loop]:
    """Yield the loops of links closing_NAME_1 and closing_NAME_2, whose origins meet."""
    pairs: dict[str, dict[str, str]] = {}
    for name in model.links:
        match = _CLOSING.fullmatch(name)
        if match:
            pairs.setdefault(match[1], {})[match[2]] = name
    for name, ends in pairs.items():
        if len(ends) == 1:
            (alone,) = ends.values()
            what = f"the frame '{alone}' has no other that it meets"
            raise InputError(Problem(what, model.links[alone].place, f"add closing_{name}_1 and closing_{name}_2"))
        links = (ends["1"], ends["2"])
        place = model.links[links[0]].place
        yield Loop(f"closing_{name}", "spherical", links, (IDENTITY, IDENTITY), np.array([0.0, 0.0, 1.0]), place)


def loops_beside(path: Path, loop_file: Path | None, model: Urdf) -> Iterator[Loop]:
    """Yield the loops in the YAML file that the user names, or that is beside the model.

    Raises InputError where such a file has no loops in either dialect."""
    for file in [loop_file] if loop_file is not None else _beside(path):
        root, problems = compose(read_text(file), str(file))
        if problems:
            raise InputError(problems)
        values = root.values if isinstance(root, MappingNode) else {}
        any_loop = False
        for key, reader in (("closed_loop", _pairs), ("ball_loops", _balls)):
            listed = values.get(key)
            if isinstance(listed, SequenceNode):
                any_loop = True
                yield from reader(listed, values, model)
        if not any_loop:
            hint = "it lists pairs of frames: closed_loop: [[frame_1, frame_2]], and type: [3d]"
            raise InputError(Problem("the file has no list 'closed_loop' or 'ball_loops'", root.place, hint))


def _beside(path: Path) -> Iterator[Path]:
    """Yield the files beside a model that list loops."""
    for file in (path.with_suffix(".yaml"), path.with_name("loop_closures.yaml")):
        if file.is_file():
            head = file.read_text(encoding="utf-8", errors="replace")[:100_000]
            if "closed_loop:" in head or "ball_loops:" in head:
                yield file


def _pairs(listed: SequenceNode, values: Mapping[str, Node], model: Urdf) -> Iterator[Loop]:
    """Yield the loops of pairs of frames that meet in a point, 3d, or coincide, 6d."""
    kinds = values.get("type")
    words = [_text(each) for each in kinds.items] if isinstance(kinds, SequenceNode) else []
    for at, pair in enumerate(listed.items):
        ends = [_text(each) for each in pair.items] if isinstance(pair, SequenceNode) else []
        word = words[at].lower() if at < len(words) else "6d"
        if len(ends) != 2 or word not in ("3d", "6d"):
            raise InputError(Problem("a loop is a pair of frames, and 3d or 6d", pair.place, "as in [[a, b]], ['3d']"))
        links = (_link_of(ends[0], model, pair.place), _link_of(ends[1], model, pair.place))
        name = f"loop_{ends[0]}"
        yield Loop(name, LOOP_TYPES[word], links, (IDENTITY, IDENTITY), np.array([0.0, 0.0, 1.0]), pair.place)


def _balls(listed: SequenceNode, values: Mapping[str, Node], model: Urdf) -> Iterator[Loop]:
    """Yield the loops of points of two links that meet."""
    for at, entry in enumerate(listed.items):
        keys = entry.values if isinstance(entry, MappingNode) else {}
        links, frames = [], []
        for side in ("parent", "child"):
            name, xyz = keys.get(side), keys.get(f"{side}_xyz")
            if name is None:
                hint = "as in {name: a, parent: rod, parent_xyz: [0, 0, 0.1], child: foot, child_xyz: [0, 0, 0]}"
                raise InputError(Problem(f"a ball loop names no {side}", entry.place, hint))
            links.append(_link_of(_text(name), model, name.place))
            shown = " ".join(_text(each) for each in xyz.items) if isinstance(xyz, SequenceNode) else "0 0 0"
            point = numbers(shown, 3, (xyz or entry).place, f"'{side}_xyz'")
            frames.append(Frame(point, np.eye(3)))
        called = _text(keys["name"]) if "name" in keys else f"ball_loop_{at + 1}"
        axis = np.array([0.0, 0.0, 1.0])
        yield Loop(called, "spherical", (links[0], links[1]), (frames[0], frames[1]), axis, entry.place)


def _text(node: Node) -> str:
    return node.text if isinstance(node, ScalarNode) else ""


def _link_of(name: str, model: Urdf, place: Place) -> str:
    """The link whose frame has the name of a joint or a link. Raises InputError where there is none."""
    if name in model.joints:
        return model.joints[name].child
    if name in model.links:
        return name
    raise InputError(Problem(f"unknown frame '{name}'", place, choose_from(name, [*model.joints, *model.links])))
