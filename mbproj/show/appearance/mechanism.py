"""`Look`: everything that is drawn of a mechanism, from its scene and its motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.joints import JOINTS
from mbproj.model.compile.frames import poses_of
from mbproj.pages.appearance.bodies import parts_of
from mbproj.pages.appearance.forces import LoadLook, force_parts, loads, slides
from mbproj.pages.appearance.joints import DrawnPart, joint_parts, up_of
from mbproj.pages.appearance.layout import PartNumbers, RollingContact, touching
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.scene.appearance import Appearance
from mbproj.scene.meshes import TriangleMesh
from mbproj.scene.read import Scene
from mbproj.scene.records import Body, Joint, PointForce

#: The colours of bodies, in turn. Colour-blind readers can tell them apart (Tol, Colour Schemes, 2021, "bright").
COLOURS = ("#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#8d99a6")


@dataclass(frozen=True)
class BodyLook:
    """The name, colour and opacity of a body."""

    name: str
    colour: str
    opacity: float


@dataclass(frozen=True, eq=False)
class JointLook:
    """A joint with the numbers of its bodies. `point` (3,) is in body 2, and so is the `axis` (3,) of a hinge; None for
    other joints."""

    name: str
    type: str
    bodies: tuple[int, int]
    point: Array
    axis: Array | None


@dataclass(frozen=True, eq=False)
class MarkerLook:
    """A marker with its body's number and its point (3,) there."""

    name: str
    body: int
    point: Array


@dataclass(frozen=True, eq=False)
class DrawnSpan:
    """A line between points of two bodies, drawn as a "rod", a "spring", a "damper" or both ("strut").

    A straight part of a rope is a rod that is tangent to circles about its points. Their `radii` are positive where the
    rope bends left, seen along the `normal` in the axes of the body `frame`."""

    kind: str
    name: str
    carriers: tuple[int, int]
    points: tuple[Array, Array]
    radius: float
    radii: tuple[float, float] = (0.0, 0.0)
    normal: Array | None = None
    frame: int = -1

    def ends(self, motion: PoseHistory) -> tuple[Array, Array]:
        """The two end points at the first sample."""
        start, end = (motion.point(body, point)[0] for body, point in zip(self.carriers, self.points, strict=True))
        if self.normal is None:
            return start, end
        n, line = motion.vector(self.frame, self.normal)[0], end - start
        flat = line - (line @ n) * n
        across, w = np.cross(n, flat), self.radii[0] - self.radii[1]
        square = flat @ flat
        e = (np.sqrt(max(square - w * w, 0.0)) * flat + w * across) / max(square, 1e-300)
        aside = np.cross(n, e)
        return start - self.radii[0] * aside, end - self.radii[1] * aside


@dataclass(frozen=True, eq=False)
class Look:
    """Everything that is drawn of a mechanism. `thickness` is the radius of a link and `size` the extent of the
    mechanism at the start, in m. Bodies, joints and forces are numbered as in the scene."""

    title: str
    bodies: tuple[BodyLook, ...]
    joints: tuple[JointLook, ...]
    markers: tuple[MarkerLook, ...]
    touching: tuple[RollingContact, ...]
    drawn: tuple[DrawnPart, ...]
    spans: tuple[DrawnSpan, ...]
    forces: tuple[str, ...]
    loads: tuple[LoadLook, ...]
    thickness: float
    size: float
    gravity: Array


def look_of(scene: Scene, motion: PoseHistory, meshes: Mapping[str, TriangleMesh]) -> Look:
    """The look of a scene in this motion, with the `meshes` of its bodies."""
    layout = PartNumbers.of(scene, motion)
    marked: dict[str, list[Array]] = {}
    for marker in scene.markers:
        marked.setdefault(marker.body, []).append(layout.markers[marker.name])
    bodies = [
        tuple(
            parts_of(
                body,
                layout.held.get(number, ()),
                layout.axes.get(number, ()),
                marked.get(body.name, ()),
                layout.thickness,
                meshes.get(body.name),
                loose=number in layout.loose,
            )
        )
        for number, body in enumerate(scene.bodies)
    ]
    return Look(
        title=scene.title,
        bodies=tuple(_body_look(body, number) for number, body in enumerate(scene.bodies)),
        joints=tuple(_joint_look(joint, layout) for joint in scene.joints),
        markers=tuple(
            MarkerLook(marker.name, layout.number[marker.body], layout.markers[marker.name]) for marker in scene.markers
        ),
        touching=tuple(touching(scene, layout)),
        drawn=(
            *(DrawnPart(part, number, "bodies", number) for number, parts in enumerate(bodies) for part in parts),
            *joint_parts(scene, layout, motion, bodies, up_of(scene)),
            *force_parts(scene, layout),
        ),
        spans=tuple(_spans(scene, layout)),
        forces=tuple(force.name for force in scene.forces),
        loads=tuple(loads(scene, layout)),
        thickness=layout.thickness,
        size=layout.size,
        gravity=np.array(scene.gravity),
    )


def _body_look(body: Body, number: int) -> BodyLook:
    given = body.appearance or Appearance()
    return BodyLook(body.name, given.colour or COLOURS[number % len(COLOURS)], given.opacity)


def _joint_look(joint: Joint, layout: PartNumbers) -> JointLook:
    """The look of a joint. A coupling has no point of its own: it uses that of its last joint."""
    at = joint.name if joint.couples is None else joint.couples.joints[-1]
    frame = layout.frames[at]
    return JointLook(
        joint.name, joint.type, layout.bodies[at], frame["p2"], frame["z2"] if JOINTS[joint.type].turns else None
    )


def _rope(scene: Scene, joint: Joint, layout: PartNumbers) -> Iterator[DrawnSpan]:
    """The straight parts of a rope."""
    path, poses = joint.parameters["path"], poses_of(scene)

    def local(body: str, vector: Array) -> Array:
        return np.asarray(poses[body][1].T @ vector)

    normal = local(path.frame, np.array(path.normal))
    for first, second in pairwise(path.nodes):
        places = [local(node.body, np.array(node.at.vector) - poses[node.body][0]) for node in (first, second)]
        carriers = (layout.number[first.body], layout.number[second.body])
        radii = (first.signed_radius, second.signed_radius)
        thin, frame = 0.35 * layout.thickness, layout.number[path.frame]
        yield DrawnSpan("rod", joint.name, carriers, (places[0], places[1]), thin, radii, normal, frame)


def _spans(scene: Scene, layout: PartNumbers) -> Iterator[DrawnSpan]:
    for joint in scene.joints:
        if "path" in joint.parameters:
            yield from _rope(scene, joint, layout)
        if JOINTS[joint.type].is_rod:
            frame = layout.frames[joint.name]
            ends = (frame["p1"], frame["p2"])
            yield DrawnSpan("rod", joint.name, layout.bodies[joint.name], ends, 0.8 * layout.thickness)
    for slide in slides(scene):
        frame = layout.frames[slide.joint]
        ends = (frame["p1"], frame["p2"])
        yield DrawnSpan("spring", slide.name, layout.bodies[slide.joint], ends, 2.6 * layout.thickness)
    for force in scene.forces:
        if isinstance(force, PointForce):
            first, second = force.bodies
            law = force.law
            elastic = force.element is not None or law.stiffness > 0.0 or law.function is not None
            kind = ("strut" if elastic else "damper") if law.damping > 0.0 else "spring"
            carriers = (layout.number[first], layout.number[second])
            yield DrawnSpan(kind, force.name, carriers, layout.springs[force.name], 2.0 * layout.thickness)
