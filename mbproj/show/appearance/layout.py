"""The places of a scene's joints, markers and springs on its bodies, and the thickness of links."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.joints.table import JOINTS
from mbproj.model.compile.contacts import place_of_contact
from mbproj.model.compile.forces import local_ends
from mbproj.model.compile.frames import SYMBOLS, Pose, local_frames, poses_of
from mbproj.scene.records import GROUND, Bushing, DistanceStop, Joint, PlaneStop, PointForce
from mbproj.scene.scene import Scene
from mbproj.show.appearance.motion import PoseHistory
from mbproj.show.appearance.parts import both_outlines, wires_of

#: The radius of a link: this part of the median link, but within this range of parts of the mechanism's size.
OF_LINK, OF_SIZE = 0.026, (0.002, 0.013)
#: In a long chain no link is thicker than this part of its length, even where that is below the range.
STOUTEST = 0.1


@dataclass(frozen=True, eq=False)
class PartNumbers:
    """The places of joints, markers and springs on bodies, and their numbers.

    `number` is that of each body by name (-1 for the ground), `bodies` the two bodies of each joint. `frames` are the
    symbols p1, x1, y1, z1, p2, .. of each joint in the axes of its bodies. `markers` and `springs` are points of
    bodies, m. `held` are the points at which joints and bushings hold each body, joints to the ground first. `axes` are
    the axes of hinges there, None elsewhere. `loose` are the bodies without a joint; springs and stops may hold them.

    `size` is the largest extent of the mechanism at the start in m, `thickness` the radius of a link."""

    number: Mapping[str, int]
    bodies: Mapping[str, tuple[int, int]]
    frames: Mapping[str, Mapping[str, Array]]
    held: Mapping[int, tuple[Array, ...]]
    axes: Mapping[int, tuple[Array | None, ...]]
    loose: frozenset[int]
    markers: Mapping[str, Array]
    springs: Mapping[str, tuple[Array, Array]]
    size: float
    thickness: float

    @classmethod
    def of(cls, scene: Scene, motion: PoseHistory) -> PartNumbers:
        """The places in a scene whose bodies start as in `motion`."""
        number = {GROUND: -1} | {body.name: at for at, body in enumerate(scene.bodies)}
        poses = poses_of(scene)
        joints = [joint for joint in scene.joints if joint.couples is None]
        bodies = {joint.name: (number[joint.bodies[0]], number[joint.bodies[1]]) for joint in joints}
        local = zip(joints, local_frames(joints, poses), strict=True)
        frames = {joint.name: dict(zip(SYMBOLS, frame, strict=True)) for joint, frame in local}
        markers = {
            marker.name: _local(np.array(marker.location), poses[marker.body], marker.local) for marker in scene.markers
        }
        springs = {force.name: _ends(force, poses) for force in scene.forces if isinstance(force, PointForce)}
        start = motion.at([0])
        cloud = [start.position[0]]
        for name, frame in frames.items():
            cloud += [start.point(body, frame[f"p{side}"]) for side, body in enumerate(bodies[name], 1)]
        cloud += [start.point(number[marker.body], markers[marker.name]) for marker in scene.markers]
        cloud += [start.point(body, point) for joint in joints for body, point in _curves(joint, bodies, frames)]
        held, axes = _held_points(scene, bodies, frames)
        loose = frozenset(range(len(scene.bodies))) - held.keys()
        for owner, point in _soft_points(scene, number, poses, springs, held):
            held[owner], axes[owner] = (*held.get(owner, ()), point), (*axes.get(owner, ()), None)
            cloud.append(start.point(owner, point))
        size = float(np.linalg.norm(np.ptp(np.concatenate(cloud), axis=0))) or _gyration(scene)
        spans = [_span(points) for body, points in held.items() if body >= 0]
        links = [span for span in spans if span > 0.01 * max(spans)]
        low, high = (part * size for part in OF_SIZE)
        link = float(np.median(links)) if links else np.inf
        thickness = float(np.clip(OF_LINK * link, min(low, STOUTEST * link), high))
        return cls(number, bodies, frames, held, axes, loose, markers, springs, size, thickness)


def _curves(
    joint: Joint, bodies: Mapping[str, tuple[int, int]], frames: Mapping[str, Mapping[str, Array]]
) -> Iterator[tuple[int, Array]]:
    """The points of a joint's curves in the axes of the body that has the curve, each with that body's number."""
    frame = frames[joint.name]
    for side, outline in enumerate(both_outlines(joint), 1):
        x, z = frame[f"x{side}"], frame[f"z{side}"]
        points = frame[f"p{side}"] + outline.points @ np.array([x, np.cross(z, x)])
        yield from ((bodies[joint.name][side - 1], point) for point in points)
    for wire in wires_of(joint):
        x, z = frame["x1"], frame["z1"]
        points = frame["p1"] + wire.points @ np.array([x, np.cross(z, x), z])
        yield from ((bodies[joint.name][0], point) for point in points)


def _held_points(
    scene: Scene, bodies: Mapping[str, tuple[int, int]], frames: Mapping[str, Mapping[str, Array]]
) -> tuple[dict[int, tuple[Array, ...]], dict[int, tuple[Array | None, ...]]]:
    held: dict[int, tuple[Array, ...]] = {}
    axes: dict[int, tuple[Array | None, ...]] = {}
    for joint in sorted(scene.joints, key=lambda joint: GROUND not in joint.bodies):
        if joint.name in bodies:
            for side, owner in enumerate(bodies[joint.name], 1):
                symbols = frames[joint.name]
                axis = symbols[f"z{side}"] if JOINTS[joint.type].turns else None
                held[owner] = (*held.get(owner, ()), symbols[f"p{side}"])
                axes[owner] = (*axes.get(owner, ()), axis)
    return held, axes


def _soft_points(
    scene: Scene,
    number: Mapping[str, int],
    poses: Mapping[str, Pose],
    springs: Mapping[str, tuple[Array, Array]],
    held: Mapping[int, object],
) -> list[tuple[int, Array]]:
    """The points at which bushings hold bodies. For bodies that no joint holds, also the points of springs and
    stops."""
    bushings, others = [], []
    for force in scene.forces:
        if isinstance(force, Bushing):
            for body, location in zip(force.bodies, (force.points.first, force.points.second), strict=True):
                bushings.append((number[body], _local(np.array(location), poses[body], force.points.local)))
        elif isinstance(force, PointForce):
            others += list(zip((number[body] for body in force.bodies), springs[force.name], strict=True))
        elif isinstance(force, DistanceStop | PlaneStop):
            ends = (force.first, force.second) if isinstance(force, DistanceStop) else (force.point,)
            others += [(number[end.body], _local(np.array(end.vector), poses[end.body], end.local)) for end in ends]
    return [*bushings, *((owner, point) for owner, point in others if owner >= 0 and owner not in held)]


def _span(points: Sequence[Array]) -> float:
    """The largest distance between two of the points (among the first twelve). For a single point, twice its distance
    from the centre of mass."""
    some = points[:12]
    apart = max(float(np.linalg.norm(one - other)) for one in some for other in some)
    return apart or 2.0 * float(np.linalg.norm(points[0]))


def _local(location: Array, at: Pose, local: bool) -> Array:
    position, rotation = at
    return location if local else rotation.T @ (location - position)


def _ends(force: PointForce, poses: Mapping[str, Pose]) -> tuple[Array, Array]:
    first, second = local_ends(force, poses)
    return first, second


def _gyration(scene: Scene) -> float:
    """Twice the largest radius of gyration, as the size of a single body in free flight; 1 m where there is none."""
    radii = [np.sqrt(np.trace(body.inertia) / body.mass) for body in scene.bodies if body.mass > 0.0]
    return 2.0 * float(max(radii, default=0.0)) or 1.0


@dataclass(frozen=True, eq=False)
class RollingContact:
    """The contact of a joint that rolls or slides on an edge. `place` computes its point from the joint's symbols;
    `symbols` (8, 3) are in the axes of `bodies`."""

    name: str
    place: Callable[[Array], Array]
    bodies: tuple[int, int]
    symbols: Array

    def path(self, motion: PoseHistory) -> Array:
        """The contact points (T, 3) in a motion, m."""
        seen = []
        for at, (symbol, local) in enumerate(zip(SYMBOLS, self.symbols, strict=True)):
            body = self.bodies[at >= len(SYMBOLS) // 2]
            seen.append(motion.point(body, local) if symbol.startswith("p") else motion.vector(body, local))
        return self.place(np.stack(seen, axis=1))


def touching(scene: Scene, layout: PartNumbers) -> Iterator[RollingContact]:
    """The contacts of all joints that roll or slide on an edge."""
    for joint in scene.joints:
        place = place_of_contact(joint)
        if place is not None:
            frame = layout.frames[joint.name]
            yield RollingContact(
                joint.name, place, layout.bodies[joint.name], np.array([frame[each] for each in SYMBOLS])
            )
