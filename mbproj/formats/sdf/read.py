"""Reads an SDF as a mechanism: links and the graph of their joints, from which a tree is chosen to find poses by."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem, choose_from
from mbproj.formats.chains import Coordinates
from mbproj.formats.geometry import IDENTITY, Frame
from mbproj.formats.loops import add_loops
from mbproj.formats.mechanism import ImportedBody, ImportedMechanism, ImportedNames, ImportOptions, Same, said_of
from mbproj.formats.merged import without_rings
from mbproj.formats.sdf.frames import WORLD, SdfFrames, full_name, in_link
from mbproj.formats.sdf.inertias import inertia_of
from mbproj.formats.sdf.joints import SdfJoint, add_gearboxes, add_joint, add_mimics, open_loop, read_joint
from mbproj.formats.sdf.rest import say_rest
from mbproj.formats.sdf.scopes import Scope, number, scopes_of, text, vector
from mbproj.formats.signals import add_motions
from mbproj.formats.visuals import Shapes, Visual, add_visuals, box, capsule, colour, cylinder, mesh_file, sphere
from mbproj.formats.xml import XmlElement
from mbproj.plain_number import plain_number
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
    called = dict.fromkeys(still, GROUND)
    for name in _order(links, joints, tree, still):
        called[name] = bodies.unused(_short(name, links))
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


def _short(name: str, names: Iterable[str]) -> str:
    """The last part of a full name where no other name has the same one, else the full name."""
    last = name.rpartition("::")[2]
    alone = Counter(each.rpartition("::")[2] for each in names)[last] == 1
    return last if alone else name.replace("::", "_")


def _joints(
    scope: Scope, frames: SdfFrames, links: Mapping[str, Frame], options: ImportOptions
) -> dict[tuple[int, str], SdfJoint]:
    """Joints by their scope and name. Raises InputError, all problems at once."""
    every = [full_name(model, name) for model in scope.walk() for name, _ in model.all("joint")]
    joints: dict[tuple[int, str], SdfJoint] = {}
    problems: list[Problem] = []
    for model in scope.walk():
        for name, element in model.all("joint"):
            short = _short(full_name(model, name), every)
            try:
                joint = read_joint(model, frames, element, short, options.meet, links)
                joints[id(model), name] = joint
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
            (parent, child), (held, own) = joint.links, joint.frames
            across = held.then(joint.pose_at(options.pose.get(joint.name, 0.0))).then(own.inverse())
            if link == child and parent in done:
                poses[child] = poses[parent].then(across)
                break
            if link == parent and child in done:
                poses[parent] = poses[child].then(across.inverse())
                break
    return poses


def _meets(joint: SdfJoint, poses: Mapping[str, Frame]) -> bool:
    """Whether a joint's frames in its two links agree."""
    first, second = (poses[link].then(own) for link, own in zip(joint.links, joint.frames, strict=True))
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
    given = text(material, "diffuse") if material is not None else ""
    try:
        parts = [plain_number(part) for part in given.split()]
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
