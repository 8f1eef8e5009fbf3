"""Reads an SDF as a mechanism: links and the graph of their joints, from which a tree is chosen to find poses by."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from math import pi
from pathlib import Path

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, choose_from
from mbproj.base.text import plain_number
from mbproj.formats.chains import Coordinates, without_rings
from mbproj.formats.geometry import IDENTITY, Frame, check_inertia
from mbproj.formats.mechanism import (
    ImportedBody,
    ImportedMechanism,
    ImportedNames,
    ImportOptions,
    Same,
    add_loops,
    said_of,
)
from mbproj.formats.sdf.joints import SdfJoint, add_gearboxes, add_joint, add_mimics, open_loop, read_joint
from mbproj.formats.sdf.scopes import (
    FRAMES,
    WORLD,
    Scope,
    SdfFrames,
    full_name,
    in_link,
    number,
    pose_in,
    scopes_of,
    text,
    vector,
)
from mbproj.formats.signals import add_motions
from mbproj.formats.visuals import Shapes, Visual, add_visuals, box, capsule, colour, cylinder, mesh_file, sphere
from mbproj.formats.xml import XmlElement
from mbproj.scene.records import GROUND

#: SDF's default gravity of a world, in m/s².
GRAVITY = "0 0 -9.8"
#: Two frames agree where they differ by less, in m and rad.
EXACT = 1e-9


def read_sdf(root: XmlElement, path: Path, options: ImportOptions) -> ImportedMechanism:
    """The mechanism of the first world, or of the first model outside a world, in a file with this root element."""
    scope, others = scopes_of(root, path)
    frames = SdfFrames()
    links = _links(scope, frames)
    joints = _joints(scope, frames, {name: pose for name, (pose, _, _) in links.items()} | {WORLD: IDENTITY}, options)
    still = _grounded(links, joints.values())
    tree = _tree(joints.values(), links, still)
    poses = _placed(links, joints, tree, still, options)
    title = scope.name or path.stem
    mechanism = ImportedMechanism(title, "SDF", str(path), vector(scope.element, "gravity", GRAVITY))
    bodies, names, coordinates = ImportedNames(frozenset({GROUND})), ImportedNames(), Coordinates()
    called, short = dict.fromkeys(still, GROUND), _short_names(links)
    for name in _order(links, joints, tree, still):
        called[name] = bodies.unused(short[name])
        _add_part(mechanism, frames, links[name], called[name], poses[name])
    apart = []
    for joint in joints.values():
        if called[joint.links[0]] == called[joint.links[1]]:
            if joint.type != "fixed":
                what = "left out: both its links are on one body"
                mechanism.say(f"joint '{joint.name}'", joint.place, what, Same.YES)
        elif joint.type == "gearbox":
            continue
        elif joint.name in tree or _meets(joint, poses):
            before = set(mechanism.tree)
            add_joint(mechanism, joint, poses, called, names, coordinates, options.pose)
            if joint.name not in tree:
                mechanism.tree &= before
        else:
            apart.append(open_loop(mechanism, joint))
    add_loops(mechanism, [loop for loop in apart if loop is not None], poses, called, names)
    add_gearboxes(mechanism, joints, poses, frames.link, names, coordinates)
    add_mimics(mechanism, joints, names, coordinates, options.pose)
    add_motions(mechanism, coordinates, options.motions, options.pose)
    without_rings(mechanism)
    folder = path.resolve().parent
    shown = (
        visual
        for name, (at, model, link) in links.items()
        for visual in visuals(link, called[name], poses[name], partial(in_link, frames, model, at), folder)
    )
    add_visuals(mechanism, shown, options.folder or folder)
    say_rest(mechanism, scope, others, frames, joints.values(), options.meet)
    for kind, changed in (("bodies", bodies), ("joints", names)):
        mechanism.said += said_of(mechanism, kind, changed)
    return mechanism


_Links = dict[str, tuple[Frame, Scope, XmlElement]]


def _links(scope: Scope, frames: SdfFrames) -> _Links:
    """The links by full name, with their poses in the world."""
    links: _Links = {}
    for model in scope.walk():
        for name, element in model.all("link"):
            links[full_name(model, name)] = (frames.pose(model, name, element.place), model, element)
    if not links:
        raise InputError(Problem("the model has no link", scope.element.place, "a model has links and joints"))
    return links


def _short_names(names: Iterable[str]) -> dict[str, str]:
    """By full name the last part of it where no other name has the same one, else the full name."""
    last = {name: name.rpartition("::")[2] for name in names}
    counted = Counter(last.values())
    return {name: last[name] if counted[last[name]] == 1 else name.replace("::", "_") for name in last}


def _joints(
    scope: Scope, frames: SdfFrames, links: Mapping[str, Frame], options: ImportOptions
) -> dict[tuple[int, str], SdfJoint]:
    """Joints by their scope and name. Raises InputError, all problems at once."""
    short = _short_names(full_name(model, name) for model in scope.walk() for name, _ in model.all("joint"))
    joints: dict[tuple[int, str], SdfJoint] = {}
    problems: list[Problem] = []
    for model in scope.walk():
        for name, element in model.all("joint"):
            try:
                called = short[full_name(model, name)]
                joints[id(model), name] = read_joint(model, frames, element, called, options.meet, links)
            except InputError as error:
                problems += error.problems
    if problems:
        raise InputError(problems)
    able = [joint.name for joint in joints.values() if joint.type in ("revolute", "continuous", "prismatic", "screw")]
    for name in options.pose:
        if name not in able:
            what = f"the pose names '{name}', which is no joint of the model with one coordinate"
            raise InputError(Problem(what, scope.element.place, choose_from(name, able)))
    return joints


def _grounded(links: _Links, joints: Iterable[SdfJoint]) -> set[str]:
    """The names of the world, of the links of static models, and of links that are fixed to these."""
    still = {WORLD} | {name for name, (_, scope, _) in links.items() if scope.static}
    more = True
    while more:
        more = False
        for joint in joints:
            if joint.type == "fixed" and len(still & set(joint.links)) == 1:
                still |= set(joint.links)
                more = True
    return still


def _tree(joints: Iterable[SdfJoint], links: _Links, still: set[str]) -> dict[str, SdfJoint]:
    """The joints that close no loop with earlier joints of the file, by name."""
    group = {name: "" if name in still else name for name in [*links, WORLD]}
    chosen = {}
    for joint in joints:
        first, second = (group[link] for link in joint.links)
        if first != second and joint.type != "gearbox":
            chosen[joint.name] = joint
            group = {name: first if each == second else each for name, each in group.items()}
    return chosen


def _order(
    links: _Links, joints: Mapping[tuple[int, str], SdfJoint], tree: Mapping[str, SdfJoint], still: set[str]
) -> Iterator[str]:
    """Yield the links that move: first along the tree from the ground on, then those that are not connected with it."""
    done = set(still)
    for start in [None, *links]:
        if start is not None and start in done:
            continue
        waiting = list(still) if start is None else [start]
        if start is not None:
            done.add(start)
            yield start
        while waiting:
            link = waiting.pop(0)
            for joint in tree.values():
                if link in joint.links:
                    other = joint.links[0] if joint.links[1] == link else joint.links[1]
                    if other not in done:
                        done.add(other)
                        waiting.append(other)
                        yield other


def _placed(
    links: _Links,
    joints: Mapping[tuple[int, str], SdfJoint],
    tree: Mapping[str, SdfJoint],
    still: set[str],
    options: ImportOptions,
) -> dict[str, Frame]:
    """The poses of the links in the world: those of the file, unless the user asks that frames of joints meet, or for
    other coordinates."""
    poses = {name: pose for name, (pose, _, _) in links.items()} | {WORLD: IDENTITY}
    if not options.meet and not options.pose:
        return poses
    lost = [name for name in options.pose if name not in tree]
    if lost:
        place = next(joint.place for joint in joints.values() if joint.name == lost[0])
        raise InputError(Problem(f"joint '{lost[0]}' closes a loop", place, "give the pose of joints before it"))
    done = set(still)
    for link in _order(links, joints, tree, still):
        done.add(link)
        for joint in tree.values():
            if link not in joint.links:
                continue
            (parent, child), (in_parent, in_child) = joint.links, joint.frames
            across = in_parent.then(joint.pose_at(options.pose.get(joint.name, 0.0))).then(in_child.inverse())
            if link == child and parent in done:
                poses[child] = poses[parent].then(across)
                break
            if link == parent and child in done:
                poses[parent] = poses[child].then(across.inverse())
                break
    return poses


def _meets(joint: SdfJoint, poses: Mapping[str, Frame]) -> bool:
    """Whether a joint's frames in its two links agree."""
    first, second = (poses[link].then(local) for link, local in zip(joint.links, joint.frames, strict=True))
    apart = np.abs(first.position - second.position).max()
    return bool(max(apart, np.abs(first.rotation - second.rotation).max()) < EXACT)


def _add_part(
    mechanism: ImportedMechanism, frames: SdfFrames, link: tuple[Frame, Scope, XmlElement], name: str, pose: Frame
) -> None:
    at, scope, element = link
    inertia = inertia_of(element, partial(in_link, frames, scope, at))
    centre = pose.position + pose.rotation @ inertia.centre
    mechanism.parts[name] = ImportedBody(name, inertia.mass, inertia.inertia, centre, pose.rotation, element.place)
    if text(element, "gravity") in ("false", "0"):
        lift: Array = -inertia.mass * mechanism.gravity
        mechanism.forces[f"{name}_compensation"] = {"type": "force", "body": name, "force": lift}
    if element.first("inertial") is None:
        what = "has no <inertial>: 1 kg, and 1 kg m² about each axis, as SDF says"
        mechanism.say(f"link '{name}'", element.place, what, Same.YES)


def visuals(
    link: XmlElement, body: str, frame: Frame, place: Callable[[XmlElement], Frame], folder: Path
) -> Iterator[Visual]:
    """Yield the visuals of a link whose global pose is `frame`; `place` gives the pose of a shape in the link. Raises
    InputError at a text that is no number."""
    for element in link.all("visual"):
        geometry = element.first("geometry")
        kind = geometry.children[0] if geometry is not None and geometry.children else None
        if kind is None:
            continue
        pose, look = frame.then(place(element)), _colour(element)
        if kind.tag != "mesh":
            yield Visual(body, pose, _shapes(kind), colour=look)
            continue
        scale = vector(kind, "scale", "1 1 1")
        file = mesh_file(text(kind, "uri"), folder) if np.ptp(scale) == 0.0 else None
        yield Visual(body, pose, (), file, float(scale[0]), look, "meshes")


def _colour(visual: XmlElement) -> str | None:
    material = visual.first("material")
    diffuse = text(material, "diffuse") if material is not None else ""
    try:
        parts = [plain_number(part) for part in diffuse.split()]
    except ValueError:
        return None
    return colour(parts) if len(parts) >= 3 and np.isfinite(parts).all() else None


def _shapes(kind: XmlElement) -> Shapes:
    if kind.tag == "box":
        return box(vector(kind, "size", "1 1 1"))
    if kind.tag == "sphere":
        return sphere(number(kind, "radius", 1.0))
    if kind.tag in ("cylinder", "capsule"):
        default = (1.0, 1.0) if kind.tag == "cylinder" else (0.5, 1.0)
        make = cylinder if kind.tag == "cylinder" else capsule
        return make(number(kind, "radius", default[0]), number(kind, "length", default[1]))
    return ()


# --- The mass and the inertia of a link of an SDF ---------------------------------------------------------------------
# As given, or from its collision shapes with their densities.


#: The density of a shape that gives none, in kg/m³: that of water.
DENSITY = 1000.0


@dataclass(frozen=True, eq=False)
class Inertia:
    """A mass, its centre (3,) in the frame of the link, and its inertia (3, 3) about that in the link's axes."""

    mass: float
    centre: Array
    inertia: Array


def inertia_of(link: XmlElement, shape_pose: Callable[[XmlElement], Frame]) -> Inertia:
    """The inertia of a link; `shape_pose` gives the pose of a collision in it. Raises InputError where no body can have
    it."""
    inertial = link.first("inertial")
    if inertial is None:
        return Inertia(1.0, np.zeros(3), np.eye(3))
    if inertial.get("auto") in ("true", "1"):
        return _of_shapes(link, number(inertial, "density", DENSITY), shape_pose)
    moments, pose = inertial.first("inertia"), pose_in(inertial)
    mass = number(inertial, "mass", 1.0)
    inertia = np.eye(3)
    if moments is not None:
        xx, yy, zz = (number(moments, tag, 1.0) for tag in ("ixx", "iyy", "izz"))
        xy, xz, yz = (number(moments, tag) for tag in ("ixy", "ixz", "iyz"))
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    check_inertia(mass, inertia, (inertial.first("mass") or inertial).place, (moments or inertial).place)
    turned = pose.rotation @ inertia @ pose.rotation.T
    return Inertia(mass, pose.position, 0.5 * (turned + turned.T))


def _of_shapes(link: XmlElement, density: float, shape_pose: Callable[[XmlElement], Frame]) -> Inertia:
    """The inertia of all shapes about their common centre of mass, by Steiner's theorem."""
    parts: list[Inertia] = []
    for collision in link.all("collision"):
        of_shape = _shape(collision, number(collision, "density", density))
        if of_shape is None:
            continue
        pose = shape_pose(collision)
        centre = pose.position + pose.rotation @ of_shape.centre
        parts.append(Inertia(of_shape.mass, centre, pose.rotation @ of_shape.inertia @ pose.rotation.T))
    if not parts:
        what = f"link '{link.get('name')}' has its inertia from its collision shapes, and has none"
        raise InputError(Problem(what, link.place, "give it a <mass> and an <inertia>"))
    mass = sum(part.mass for part in parts)
    middle = sum((part.mass * part.centre for part in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = part.centre - middle
        inertia += part.inertia + part.mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    check_inertia(mass, inertia, link.place, link.place)
    return Inertia(mass, middle, 0.5 * (inertia + inertia.T))


def _shape(collision: XmlElement, density: float) -> Inertia | None:
    """The inertia of a shape in its own frame; None for a plane, which has no volume."""
    geometry = collision.first("geometry")
    shape = geometry.children[0] if geometry is not None and geometry.children else None
    if shape is None or shape.tag in ("plane", "empty"):
        return None
    if shape.tag not in SHAPES:
        what = f"the inertia of a <{shape.tag}> is not computed"
        raise InputError(Problem(what, shape.place, "give the link a <mass> and an <inertia>"))
    volume, centre, per_mass = SHAPES[shape.tag](shape)
    if not volume > 0.0:
        raise InputError(Problem(f"the <{shape.tag}> has no volume", shape.place, "give it a size"))
    mass = density * volume
    return Inertia(mass, np.array([0.0, 0.0, centre]), mass * np.diag(per_mass))


_Solid = tuple[float, float, tuple[float, float, float]]


def _box(shape: XmlElement) -> _Solid:
    x, y, z = vector(shape, "size", "1 1 1")
    return x * y * z, 0.0, ((y * y + z * z) / 12, (x * x + z * z) / 12, (x * x + y * y) / 12)


def _sphere(shape: XmlElement) -> _Solid:
    r = number(shape, "radius", 1.0)
    return 4 / 3 * pi * r**3, 0.0, (0.4 * r * r, 0.4 * r * r, 0.4 * r * r)


def _ellipsoid(shape: XmlElement) -> _Solid:
    x, y, z = vector(shape, "radii", "1 1 1")
    return 4 / 3 * pi * x * y * z, 0.0, ((y * y + z * z) / 5, (x * x + z * z) / 5, (x * x + y * y) / 5)


def _cylinder(shape: XmlElement) -> _Solid:
    r, h = number(shape, "radius", 1.0), number(shape, "length", 1.0)
    across = r * r / 4 + h * h / 12
    return pi * r * r * h, 0.0, (across, across, r * r / 2)


def _cone(shape: XmlElement) -> _Solid:
    """The solid of a cone. Its frame is at half its height, with the tip along z; its centre of mass is at a quarter of
    its height above the base."""
    r, h = number(shape, "radius", 0.5), number(shape, "length", 1.0)
    across = 3 / 20 * r * r + 3 / 80 * h * h
    return pi * r * r * h / 3, -h / 4, (across, across, 0.3 * r * r)


def _capsule(shape: XmlElement) -> _Solid:
    r, h = number(shape, "radius", 0.5), number(shape, "length", 1.0)
    tube, ends = pi * r * r * h, 4 / 3 * pi * r**3
    across = tube * (h * h / 12 + r * r / 4) + ends * (0.4 * r * r + h * h / 4 + 3 * h * r / 8)
    along = tube * r * r / 2 + ends * 0.4 * r * r
    volume = tube + ends
    return volume, 0.0, (across / volume, across / volume, along / volume)


SHAPES: dict[str, Callable[[XmlElement], _Solid]] = {
    "box": _box,
    "sphere": _sphere,
    "ellipsoid": _ellipsoid,
    "cylinder": _cylinder,
    "cone": _cone,
    "capsule": _capsule,
}


# --- Rows on the other parts of an SDF --------------------------------------------------------------------------------
# Further worlds and models, shapes, sensors, plug-ins, data of physics engines.


#: Tags in a world, a model, a link or a joint: those read, those without effect on the motion, those of joints only.
READ = (
    *("pose", "static", "gravity", "inertial", "visual", "collision"),
    *("parent", "child", "axis", "axis2", "name", "uri"),
)
ONLY_SHOWN = (
    *("light", "scene", "gui", "audio", "road", "spherical_coordinates", "physics", "self_collide", "sensor"),
    *("allow_auto_disable", "must_be_base_link", "enable_wind", "projector", "audio_source", "audio_sink", "material"),
    *("battery", "particle_emitter", "magnetic_field", "placement_frame", "gripper", "license", "wind", "atmosphere"),
)
OF_JOINTS = ("screw_thread_pitch", "thread_pitch", "gearbox_ratio", "gearbox_reference_body", "reference_body")
OF_ROTORS = ("drake:rotor_inertia", "drake:gear_ratio")
#: Tags in <inertial> and in <axis>.
OF_PARTS = (
    "mass",
    "density",
    "auto_inertia_params",
    "inertia",
    "xyz",
    "use_parent_model_frame",
    "mimic",
    "dynamics",
    "limit",
)
#: Words in the names of plug-ins that only draw, measure, or act on request.
HARMLESS = (
    *("apply-link-wrench", "joint-state-publisher", "pose-publisher", "scene-broadcaster", "user-commands"),
    *("physics", "sensors", "imu"),
)


def say_rest(
    mechanism: ImportedMechanism,
    scope: Scope,
    others: list[XmlElement],
    frames: SdfFrames,
    joints: Iterable[SdfJoint],
    meet: bool,
) -> None:
    """Add rows on all parts except links, joints and frames."""
    for other in others:
        what = f"left out: the scene is that of '{scope.name}'"
        mechanism.say(f"{other.tag} '{other.get('name')}'", other.place, what, Same.NO)
    models = list(scope.walk())
    links = [(name, element) for model in models for name, element in model.all("link")]
    touching = sum(len(link.all("collision")) for _, link in links)
    if touching:
        mechanism.say(f"{touching} collision shapes", None, "left out: shapes pass through each other", Same.UNTIL)
    for model in models:
        _say_elements(mechanism, model.rest)
    for _, link in links:
        _say_elements(mechanism, link.children)
    for part in [each for _, link in links for each in link.all("inertial")] + [
        each for joint in joints for each in joint.elements
    ]:
        _say_elements(mechanism, [each for each in part.children if each.tag not in OF_PARTS])
    for joint in joints:
        _say_elements(mechanism, [each for each in joint.element.children if each.tag not in (*OF_JOINTS, *OF_ROTORS)])
        if not meet:
            _say_apart(mechanism, frames, joint)


def _say_elements(mechanism: ImportedMechanism, elements: Iterable[XmlElement]) -> None:
    for element in elements:
        if element.tag in READ or element.tag in (*FRAMES, *ONLY_SHOWN) or element.tag == "model":
            continue
        if element.tag == "kinematic" and text_of(element) in ("false", "0"):
            continue
        shown, file = f"<{element.tag}>", element.get("filename")
        what, same = "left out: it is not read, and may act on the motion", Same.NO
        if element.tag == "plugin":
            shown = f"plug-in '{file}'"
            if any(word in file.lower() for word in HARMLESS):
                what, same = "left out: it shows, or acts on request", Same.YES
        mechanism.say(shown, element.place, what, same)


def text_of(element: XmlElement) -> str:
    """The text of an element in small letters."""
    return element.text.strip().lower()


def _say_apart(mechanism: ImportedMechanism, frames: SdfFrames, joint: SdfJoint) -> None:
    """Add a row on a joint whose named frame of the parent is elsewhere: SDF puts the joint at its child."""
    named = text(joint.element, "parent")
    if named in ("world", "__root__") or joint.scope.frames.get(named) is None:
        return
    if joint.scope.frames[named].tag != "frame" or joint.element.first("pose") is not None:
        return
    parent = frames.pose(joint.scope, named, joint.place)
    child = frames.pose(joint.scope, joint.element.get("name"), joint.place)
    apart = float(np.linalg.norm(parent.position - child.position))
    if apart > 1e-9:
        what = f"stands at its child, as SDF says; its parent's '{named}' is {apart:.4g} m away: --meet joins both"
        mechanism.say(f"joint '{joint.name}'", joint.place, what, Same.YES)
