"""The parts that forces are drawn as: bushings as rubber rings, torsion springs as spirals, planes of stops as plates.
Given forces become arrows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.model.compile.frames import pose, poses_of
from mbproj.scene.records import BodyForce, Bushing, JointForce, OfBody, PlaneStop
from mbproj.scene.scene import Scene
from mbproj.show.appearance.joints import DrawnPart
from mbproj.show.appearance.layout import PartNumbers
from mbproj.show.appearance.parts import Mesh, Solid, cylinder, triad

#: The turns of a spiral, the points of each turn, and the inner and outer radius in thicknesses.
TURNS, ROUND, INNER, OUTER = 2.5, 20, 1.5, 3.6
#: The margin of a plate around the points above it, in sizes of the mechanism.
PLATE = 0.6
#: Planes that differ by less than this, in sizes of the mechanism and rad, count as one.
ONE_PLANE = 1e-6


@dataclass(frozen=True, eq=False)
class LoadLook:
    """A given force, or `torque`, on the body with this number, at a point (3,) in its axes."""

    name: str
    body: int
    point: Array
    torque: bool


def force_parts(scene: Scene, layout: PartNumbers) -> Iterator[DrawnPart]:
    """The parts of bushings, torsion springs and planes of stops. `item` is the number of the force in the scene, or of
    the first stop on a plane."""
    for item, force in enumerate(scene.forces):
        if isinstance(force, Bushing):
            yield from _bushing(scene, force, item, layout)
        elif isinstance(force, JointForce) and force.joint in layout.frames and _springs(force, "angle", "rad"):
            frame, carrier = layout.frames[force.joint], layout.bodies[force.joint][0]
            yield DrawnPart(spiral(frame["p1"], frame["z1"], frame["x1"], layout.thickness), carrier, "springs", item)
    yield from _plates(scene, layout)


def slides(scene: Scene) -> Iterator[JointForce]:
    """The springs along displacements of joints, which are drawn between the two bodies."""
    for force in scene.forces:
        if isinstance(force, JointForce) and _springs(force, "displacement", "m"):
            yield force


def loads(scene: Scene, layout: PartNumbers) -> Iterator[LoadLook]:
    """The given forces and torques, with the points where they act."""
    for force in scene.forces:
        if isinstance(force, BodyForce):
            yield LoadLook(force.name, layout.number[force.body], _acts_at(scene, force), force.torque)


def _springs(force: JointForce, coordinate: str, unit: str) -> bool:
    """Whether the force is elastic, or an element, on a coordinate whose name or unit is of this kind."""
    return any(
        (name.startswith(coordinate) or (not name and force.unit == unit))
        and (force.element is not None or law.stiffness > 0.0 or law.function is not None)
        for name, law in force.laws.items()
    )


def _acts_at(scene: Scene, force: BodyForce) -> Array:
    if force.location is None:
        return np.zeros(3)
    position, rotation = poses_of(scene)[force.body]
    location = np.array(force.location)
    return location if force.local else rotation.T @ (location - position)


def _bushing(scene: Scene, force: Bushing, item: int, layout: PartNumbers) -> Iterator[DrawnPart]:
    """A ring on the first body about a pin on the second, both along the z axes of their frames."""
    r, poses = layout.thickness, poses_of(scene)
    points, frames = (force.points.first, force.points.second), (force.axes.first, force.axes.second)
    for side, (body, location, axes) in enumerate(zip(force.bodies, points, frames, strict=True)):
        position, rotation = poses[body]
        point = np.array(location) if force.points.local else rotation.T @ (np.array(location) - position)
        turned = pose((0.0, 0.0, 0.0), axes)[1]
        z, x = (turned if force.axes.local else rotation.T @ turned)[:, [2, 0]].T
        ring = Solid("tube", (3.2 * r, 1.4 * r, 4.4 * r), point, triad(z, x))
        yield DrawnPart(cylinder(1.2 * r, 8.0 * r, point, z) if side else ring, layout.number[body], "springs", item)


@dataclass(frozen=True, eq=False)
class _StopPlane:
    """The plane of a stop: its `normal` (3,) in the axes of its body, and the `foot` (3,) of the stopped point on
    it."""

    item: int
    normal: Array
    foot: Array

    def is_in(self, other: _StopPlane, size: float) -> bool:
        """Whether both planes are the same."""
        beside = abs(float(other.normal @ (self.foot - other.foot)))
        return bool(np.abs(self.normal - other.normal).max() < ONE_PLANE and beside < ONE_PLANE * size)


def _plates(scene: Scene, layout: PartNumbers) -> Iterator[DrawnPart]:
    """One plate for all stops on the same plane, with its upper face in the plane."""
    planes: list[tuple[str, list[_StopPlane]]] = []
    for item, stop in enumerate(scene.forces):
        if not isinstance(stop, PlaneStop):
            continue
        under, body = _stop_plane(scene, stop, item), stop.location.body
        for owner, faces in planes:
            if owner == body and under.is_in(faces[0], layout.size):
                faces.append(under)
                break
        else:
            planes.append((body, [under]))
    for body, faces in planes:
        yield DrawnPart(_plate(faces, layout), layout.number[body], "springs", faces[0].item)


def _plate(under: list[_StopPlane], layout: PartNumbers) -> Solid:
    normal, thick = under[0].normal, 2.0 * layout.thickness
    across = np.eye(3)[int(np.argmin(np.abs(normal)))]
    x = across - normal * float(normal @ across)
    x = x / np.linalg.norm(x)
    axes, feet = np.column_stack([x, np.cross(normal, x), normal]), np.array([each.foot for each in under])
    low, high = (feet @ axes).min(axis=0), (feet @ axes).max(axis=0)
    across_it, along_it = (high - low)[:2] + PLATE * layout.size
    middle = axes @ (0.5 * (low + high)) - 0.5 * thick * normal
    return Solid("box", (float(across_it), float(along_it), thick), middle, triad(normal, x))


def _stop_plane(scene: Scene, stop: PlaneStop, item: int) -> _StopPlane:
    poses = poses_of(scene)
    place, turn = poses[stop.location.body]

    def on_plane(placed: OfBody) -> Array:
        position, rotation = poses[placed.body]
        vector = np.array(placed.vector)
        return np.asarray(turn.T @ ((position + rotation @ vector if placed.local else vector) - place))

    direction = np.array(stop.normal.vector)
    normal = direction if stop.normal.local else turn.T @ direction
    point, location = on_plane(stop.point), on_plane(stop.location)
    return _StopPlane(item, normal, point - normal * float(normal @ (point - location)))


def spiral(point: Array, axis: Array, normal: Array, r: float) -> Solid:
    """A flat ribbon wound about the axis."""
    stations = round(TURNS * ROUND) + 1
    turn = np.linspace(0.0, 2.0 * np.pi * TURNS, stations)
    radius = r * np.linspace(INNER, OUTER, stations)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(stations)])
    corners = [(-0.12, -0.5), (0.12, -0.5), (0.12, 0.5), (-0.12, 0.5)]  # radial and axial offsets, in thicknesses
    rings = [(radius + a * r)[:, None] * out + [0.0, 0.0, b * r] for a, b in corners]
    vertices = np.stack(rings, axis=1).reshape(-1, 3)
    first = 4 * np.arange(stations - 1)[:, None]
    faces = [[i, 4 + i, (i + 1) % 4] for i in range(4)] + [[(i + 1) % 4, 4 + i, 4 + (i + 1) % 4] for i in range(4)]
    sides = (first[:, :, None] + np.array(faces)[None]).reshape(-1, 3)
    last = 4 * (stations - 1)
    ends = [[0, 1, 2], [0, 2, 3], [last, last + 2, last + 1], [last, last + 3, last + 2]]
    triangles = np.concatenate([sides, np.array(ends)]).astype(np.intp)
    return Solid("mesh", (), point, triad(axis, normal), Mesh(vertices, triangles, convex=False))
