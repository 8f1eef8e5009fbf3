"""What is drawn of a mechanism, from its scene and its motion (`Look`), and from where it is seen (`View`).

Pictures and the animated page draw from these records alone. Bodies are numbered as in the scene, -1 is the ground. The
points (3,) of a look are in m, in the axes of the body that carries them; those of a view are in global axes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from itertools import pairwise

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.joints.table import JOINTS
from mbproj.model.compile.frames import poses_of
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.scene.meshes import TriangleMesh
from mbproj.scene.records import Appearance, Body, Joint, PointForce
from mbproj.scene.scene import Scene
from mbproj.show.appearance.bodies import parts_of
from mbproj.show.appearance.forces import LoadLook, force_parts, loads, slides
from mbproj.show.appearance.joints import DrawnPart, joint_parts, up_of
from mbproj.show.appearance.layout import PartNumbers, RollingContact, touching
from mbproj.show.appearance.motion import PoseHistory

# --- What is drawn ----------------------------------------------------------------------------------------------------

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
        """The two end points at the first sample, in global axes. Those of a rope are where the common tangent of its
        two circles touches them: its direction e in the plane is the line of centres, turned so that e · n × flat = w.
        """
        start, end = (motion.point(body, point)[0] for body, point in zip(self.carriers, self.points, strict=True))
        if self.normal is None:
            return start, end
        n, line = motion.vector(self.frame, self.normal)[0], end - start
        flat = line - (line @ n) * n
        across, w = np.cross(n, flat), self.radii[0] - self.radii[1]
        square = flat @ flat
        e = (np.sqrt(max(square - w * w, 0.0)) * flat + w * across) / max(square, 1e-300)
        to_the_left = np.cross(n, e)
        return start - self.radii[0] * to_the_left, end - self.radii[1] * to_the_left


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
    """The look of a scene in this motion, with the `meshes` of its bodies, by body."""
    layout = PartNumbers.of(scene, motion)
    markers_of: dict[str, list[Array]] = {}
    for marker in scene.markers:
        markers_of.setdefault(marker.body, []).append(layout.markers[marker.name])
    bodies = [
        tuple(
            parts_of(
                body,
                layout.held.get(number, ()),
                layout.axes.get(number, ()),
                markers_of.get(body.name, ()),
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
    appearance = body.appearance or Appearance()
    return BodyLook(body.name, appearance.colour or COLOURS[number % len(COLOURS)], appearance.opacity)


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
    """The lines of ropes, rods, springs along joints, and springs and dampers between points."""
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


# --- From where it is seen: along the normal of the plane in which it moves, or otherwise from above and one side -----

#: The tolerances for parallel axes and for a motion in one plane.
PARALLEL, IN_PLANE = 1e-6, 1e-6
#: A mechanism is flat where its depth is less than this part of its size.
FLAT = 0.12
#: The view of a mechanism that is not flat: its front, turned and raised by these angles in degrees.
TURNED, RAISED = 32.0, 22.0
#: The samples from which the view is computed, and the directions in which outermost points are searched.
SAMPLES, DIRECTIONS = 60, 150


@dataclass(frozen=True, eq=False)
class View:
    """The direction `eye` (3,) from the `middle` (3,) to the viewer, and the direction `up` (3,). All that moves is
    within `radius` of the middle; `points` (k, 3) are its outermost points, m. `flat`: the view is along the normal of
    the motion's plane, without perspective."""

    middle: Array
    eye: Array
    up: Array
    radius: float
    points: Array
    flat: bool


def view_of(scene: Scene, motion: PoseHistory, look: Look) -> View:
    """The view that shows the whole motion: along the normal where the mechanism is flat, else turned and raised from
    it; of two normals the one for which the axis that points right is positive, as on paper."""
    finite = motion.finite
    sampled = motion.at(finite[np.unique(np.linspace(0, len(finite) - 1, SAMPLES).astype(int))])
    cloud = _cloud(look, sampled, {joint.name for joint in scene.joints if JOINTS[joint.type].sketch == "wire"})
    low, high = cloud.min(axis=(0, 1)), cloud.max(axis=(0, 1))
    middle, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    points = outermost(cloud.reshape(-1, 3), 2.0 * look.thickness)
    normal = _normal(look, sampled)
    up = up_of(scene)
    if normal is None:
        return View(middle, _raised(np.array([0.0, -1.0, 0.0]), up), up, radius, points, False)
    if abs(normal @ up) > 0.9:  # it moves in a horizontal plane: y is up, as on paper
        up = np.eye(3)[1] if abs(normal[2]) > 0.7 else np.eye(3)[2]
    up = up - (up @ normal) * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    eye = normal if right[np.argmax(np.abs(right))] > 0.0 else -normal
    depth = float(np.ptp(cloud @ normal))
    flat = depth <= FLAT * 2.0 * radius
    return View(middle, eye if flat else _raised(eye, up), up, radius, points, flat)


def outermost(cloud: Array, margin: float) -> Array:
    """The points of `cloud` (.., 3) that reach farthest in many directions, moved outward by `margin`."""
    count = np.arange(DIRECTIONS)
    height, turn = 1.0 - (2.0 * count + 1.0) / DIRECTIONS, count * np.pi * (3.0 - np.sqrt(5.0))  # a Fibonacci sphere
    flat = np.sqrt(1.0 - height**2)
    directions = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])
    points: Array = cloud[np.argmax(cloud @ directions.T, axis=0)] + margin * directions
    return points


def _cloud(look: Look, motion: PoseHistory, wires: Set[str]) -> Array:
    """Points (T, k, 3) over which the mechanism extends: corners of its bodies, joints, markers, ends of springs,
    wheels, the curves of joints that are `wires`, and contacts."""
    shown = wires | {contact.name for contact in look.touching}
    points = [(joint.bodies[1], joint.point) for joint in look.joints]
    points += [(marker.body, marker.point) for marker in look.markers]
    points += [end for span in look.spans for end in zip(span.carriers, span.points, strict=True)]
    for drawn in look.drawn:
        is_plate = drawn.layer == "springs" and drawn.part.kind == "box"  # the plane of a stop
        is_shown = drawn.layer in ("joints", "ground") and look.joints[drawn.item].name in shown
        if drawn.layer == "bodies" or is_plate or is_shown:
            corners = drawn.part.outline()
            points += [(drawn.carrier, corner) for corner in _corners(corners.min(axis=0), corners.max(axis=0))]
    moved = [motion.point(body, local) for body, local in points]
    return np.stack(moved + [contact.path(motion) for contact in look.touching], axis=1)


def _corners(low: Array, high: Array) -> Array:
    """The corners (8, 3) of a box."""
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def _normal(look: Look, motion: PoseHistory) -> Array | None:
    """The normal (3,) of the plane of the motion, from the common direction of the axes or from the paths. None where
    there is none: bodies leave the plane, or tilt out of it."""
    axes = [motion.vector(joint.bodies[1], joint.axis)[0] for joint in look.joints if joint.axis is not None]
    moved = (motion.position - motion.position[:1]).reshape(-1, 3)
    _, sizes, directions = np.linalg.svd(moved, full_matrices=False)
    if axes:
        normal = axes[0] / np.linalg.norm(axes[0])
        if any(np.linalg.norm(np.cross(axis, normal)) > PARALLEL for axis in axes):
            return None
    elif len(sizes) == 3 and sizes[1] > IN_PLANE * sizes[0]:
        normal = directions[2]
    else:
        return None
    leaves = float(np.abs(moved @ normal).max(initial=0.0))
    rotation = rotation_matrix(motion.orientation)
    normal_in_bodies = np.swapaxes(rotation[0], -1, -2) @ normal  # at the first sample: a body that stays keeps it
    tilts = float(np.abs(rotation @ normal_in_bodies[:, :, None] - normal[:, None]).max(initial=0.0))
    travel = float(np.abs(moved).max(initial=0.0))
    return normal if leaves <= IN_PLANE * max(travel, look.thickness) and tilts <= IN_PLANE else None


def _raised(front: Array, up: Array) -> Array:
    """The direction `front` (3,), turned about `up` and raised towards it."""
    level = front - (front @ up) * up
    if np.linalg.norm(level) < 0.1:
        level = np.eye(3)[0] - up[0] * up
    level /= np.linalg.norm(level)
    right = np.cross(up, level)
    turn, raised = np.radians(TURNED), np.radians(RAISED)
    direction: Array = np.cos(raised) * (np.cos(turn) * level + np.sin(turn) * right) + np.sin(raised) * up
    return direction
