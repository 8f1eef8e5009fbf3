"""Scene to System: names become indices, joints become lists of primitives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from mbproj.arrays import Array
from mbproj.joints import COORDINATE_UNITS, JOINTS
from mbproj.model.frames import Pose, local_frames, pose
from mbproj.model.primitive_set import Binding, bind
from mbproj.model.system import Names, System
from mbproj.scene.records import GROUND, Marker, Scene


def compile_system(scene: Scene) -> System:
    """The mechanism that the scene describes, as frozen arrays."""
    index = {body.name: number for number, body in enumerate(scene.bodies)} | {GROUND: len(scene.bodies)}
    poses = {body.name: pose(body.position, body.orientation) for body in scene.bodies}
    poses[GROUND] = (np.zeros(3), np.eye(3))
    frames = [local_frames(joint, JOINTS[joint.type].frame, poses) for joint in scene.joints]
    rows, alignment, coordinates, coordinate_names, units = [], [], [], [], []
    for owner, (joint, frame) in enumerate(zip(scene.joints, frames, strict=True)):
        sides = (index[joint.bodies[0]], index[joint.bodies[1]])
        for row in JOINTS[joint.type].rows:
            rows.append(Binding(row[0], owner, tuple(_slots(row[1:], frame, sides))))
        for pair in JOINTS[joint.type].aligned:
            alignment.append(Binding("perpendicular", owner, tuple(_slots(pair, frame, sides))))
        for name, row in JOINTS[joint.type].coordinates.items():
            coordinates.append(Binding(row[0], owner, tuple(_slots(row[1:], frame, sides))))
            coordinate_names.append(f"{joint.name}.{name}")
            units.append(COORDINATE_UNITS[row[0]])
    names = Names(
        bodies=tuple(body.name for body in scene.bodies),
        joints=tuple(joint.name for joint in scene.joints),
        markers=tuple(marker.name for marker in scene.markers),
        coordinates=tuple(coordinate_names),
        coordinate_units=tuple(units),
    )
    return System(
        names=names,
        mass=np.array([body.mass for body in scene.bodies]),
        inertia=np.array([body.inertia for body in scene.bodies]),
        gravity=np.array(scene.gravity),
        joints=bind(rows),
        coordinates=bind(coordinates),
        alignment=bind(alignment),
        marker_body=np.array([index[marker.body] for marker in scene.markers], dtype=np.intp),
        marker_local=np.array([_marker_local(marker, poses) for marker in scene.markers]).reshape(-1, 3),
        reaction_body=np.array([index[joint.bodies[1]] for joint in scene.joints], dtype=np.intp),
        reaction_local=np.array([frame["p2"] for frame in frames]).reshape(-1, 3),
        length=_length(scene, frames),
        joint_places=tuple(scene.place("joints", joint.name) for joint in scene.joints),
    )


def _slots(
    symbols: Iterable[str], frame: Mapping[str, Array], sides: tuple[int, int]
) -> Iterable[tuple[int, int, Array]]:
    for symbol in symbols:
        side = int(symbol[-1])
        sign = -1.0 if symbol.startswith("-") else 1.0
        yield sides[side - 1], side, sign * frame[symbol.lstrip("-")]


def _marker_local(marker: Marker, poses: Mapping[str, Pose]) -> Array:
    location = np.array(marker.location)
    position, rotation = poses[marker.body]
    return location if marker.local else rotation.T @ (location - position)


def _length(scene: Scene, frames: Iterable[Mapping[str, Array]]) -> float:
    """The largest distance of a joint's point from its body's centre of mass, or of a body from the origin; or 1 m."""
    lengths = [
        float(np.linalg.norm(frame[point]))
        for joint, frame in zip(scene.joints, frames, strict=True)
        for point, body in zip(("p1", "p2"), joint.bodies, strict=True)
        if body != GROUND
    ]
    return max(lengths, default=0.0) or max(float(np.linalg.norm(body.position)) for body in scene.bodies) or 1.0


