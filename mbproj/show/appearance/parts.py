"""The few kinds of solids that everything is drawn with, each with its place on a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.functions.plane_curve import points_along
from mbproj.functions.space_curve import Track
from mbproj.joints.primitives.basic import Line
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.joints.table import JOINTS
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.scene.records import Joint

#: The Euler parameters of no rotation.
UPRIGHT = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles (m, 3) over vertices (k, 3) in m; their corners run counter-clockwise, seen from outside."""

    vertices: Array
    triangles: Integers
    convex: bool = True


@dataclass(frozen=True, eq=False)
class Solid:
    """A solid with its middle at `position` (3,), turned by `orientation` (4,), in the axes of its carrier, m.

    kind       size
    box        edges along x, y, z
    cylinder   radius, length along z
    tube       outer radius, inner radius, length along z
    sphere     radius
    mesh       nothing: `mesh` says it
    """

    kind: str
    size: tuple[float, ...]
    position: Array
    orientation: Array
    mesh: Mesh | None = None

    @property
    def rotation(self) -> Array:
        """The rotation matrix (3, 3) to the axes of the carrier."""
        return rotation_matrix(self.orientation)

    def moved(self, position: Array, orientation: Array) -> Solid:
        """The solid on a larger whole, which is itself at this position and orientation."""
        at = position + rotation_matrix(orientation) @ self.position
        return replace(self, position=at, orientation=product(orientation, self.orientation))

    def outline(self) -> Array:
        """Points (k, 3), in the axes of the carrier, whose convex hull is that of the solid."""
        if self.mesh is not None:
            points = self.mesh.vertices
        elif self.kind == "box":
            points = 0.5 * np.array(self.size) * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        elif self.kind == "sphere":
            points = self.size[0] * SPHERE
        else:
            radius, length = self.size[0], self.size[-1]
            ends = [np.column_stack([radius * CIRCLE, np.full(len(CIRCLE), end)]) for end in (-length / 2, length / 2)]
            points = np.concatenate(ends)
        return self.position + points @ self.rotation.T


_TURN = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)])
_LATITUDE = np.linspace(-np.pi / 2, np.pi / 2, 13)
SPHERE = np.concatenate([np.column_stack([np.cos(at) * CIRCLE, np.full(24, np.sin(at))]) for at in _LATITUDE])


def box(edges: Sequence[float], position: Array, orientation: Sequence[float] | Array = UPRIGHT) -> Solid:
    """A box with these edges."""
    return Solid("box", tuple(edges), np.asarray(position, dtype=float), np.asarray(orientation, dtype=float))


def sphere(radius: float, position: Array) -> Solid:
    """A ball of this radius."""
    return Solid("sphere", (radius,), np.asarray(position, dtype=float), np.array(UPRIGHT))


def ellipsoid(semi_axes: Sequence[float], position: Array, orientation: Array) -> Solid:
    """An ellipsoid with these semi-axes along x, y and z."""
    rings, around = len(_LATITUDE), len(CIRCLE)
    first = (np.arange(rings - 1)[:, None] * around + np.arange(around)).ravel()
    after = first - first % around + (first + 1) % around
    lower = np.column_stack([first, after, after + around])[around:]
    upper = np.column_stack([first, after + around, first + around])[:-around]
    triangles = np.concatenate([lower, upper])
    return Solid("mesh", (), np.asarray(position), orientation, Mesh(SPHERE * np.asarray(semi_axes), triangles))


def cylinder(radius: float, length: float, position: Array, axis: Array) -> Solid:
    """A cylinder along `axis`, with its middle at `position`."""
    return Solid("cylinder", (radius, length), np.asarray(position, dtype=float), turn_to(axis))


def bar(start: Array, end: Array, radius: float) -> tuple[Solid, ...]:
    """A round bar between two points, with round ends; a ball where the points coincide."""
    length = float(np.linalg.norm(end - start))
    ends = (sphere(radius, start), sphere(radius, end))
    return ends[:1] if length < 1e-9 * radius else (cylinder(radius, length, 0.5 * (start + end), end - start), *ends)


def turn_to(axis: Array) -> Array:
    """The shortest rotation (4,) that takes z to the direction of `axis`."""
    x, y, z = axis / np.linalg.norm(axis)
    if z < -1.0 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    half = np.array([1.0 + z, -y, x, 0.0])
    return half / np.linalg.norm(half)


def triad(z: Array, x: Array) -> Array:
    """The rotation (4,) that takes z to `z` and x to the part of `x` normal to it."""
    from mbproj.scene.fields.rotations import from_matrix

    z = z / np.linalg.norm(z)
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    return np.array(from_matrix(np.column_stack([x, np.cross(z, x), z]).tolist()))


# --- Solids of constant thickness -------------------------------------------------------------------------------------
# The plate of a link with three joints or more, the disc of a cam, the rail of a slot. A bar along a space curve is
# here too.


#: Points count as in one plane, or on one line, where they leave it by less than this many thicknesses.
FLAT = 1.0
#: The number of points of a rounded corner.
ROUND = 12
#: The thickness of a rail across its curve, and the width of a disc and a rail along the axis, in radii of a link.
THICK, WIDE = 0.6, 1.6
#: Successive points of a curve count as one where they are closer than this part of the largest step between two.
DISTINCT = 1e-6


def plate(points: Sequence[Array], thickness: float) -> tuple[Solid, ...]:
    """The plate with round corners about points (3,) in a plane; empty where the points are in no plane, or on a
    line."""
    cloud = np.array(points)
    middle = cloud.mean(axis=0)
    _, sizes, axes = np.linalg.svd(cloud - middle)
    if len(points) < 3 or sizes[2] > FLAT * thickness or sizes[1] < 2.0 * FLAT * thickness:
        return ()
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    round_corner = 1.3 * thickness * np.column_stack([np.cos(turn), np.sin(turn)])
    spread = ((cloud - middle) @ axes[:2].T)[:, None, :] + round_corner
    outline = hull(spread.reshape(-1, 2))
    return (Solid("mesh", (), middle, np.array(UPRIGHT), _prism(outline, axes, thickness)),)


def hull(points: Array) -> Array:
    """The corners (k, 2) of the convex hull of points in a plane, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(map(tuple, points.tolist()))

    def half(sequence: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
        chain: list[tuple[float, ...]] = []
        for x, y in sequence:
            while len(chain) > 1 and _turns_right(chain[-2], chain[-1], (x, y)):
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return np.array(half(ordered) + half(ordered[::-1]))


def _turns_right(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 0.0


def _prism(outline: Array, axes: Array, thickness: float) -> Mesh:
    """A prism: the outline in the plane of axes[0] and axes[1], with this thickness."""
    count, normal = len(outline), np.cross(axes[0], axes[1])
    flat = outline @ axes[:2]
    vertices = np.concatenate([flat + 0.5 * thickness * normal, flat - 0.5 * thickness * normal])
    fan = [(0, i, i + 1) for i in range(1, count - 1)]
    back = [(count, count + i + 1, count + i) for i in range(1, count - 1)]
    after = [(i + 1) % count for i in range(count)]
    sides = [(i, count + i, after[i]) for i in range(count)] + [
        (after[i], count + i, count + after[i]) for i in range(count)
    ]
    return Mesh(vertices, np.array(fan + back + sides, dtype=np.intp))


class Outline(NamedTuple):
    """A profile: its points (k, 2) in its own axes, in m. `closed` tells whether it ends where it begins, `solid`
    whether it is drawn as a disc. `roller` is the radius of the roller on it, 0 for a point. `face` is the largest
    offset of the contact from the axis of a flat face, 0 where there is none."""

    points: Array
    closed: bool
    solid: bool
    roller: float
    face: float


def outline_of(joint: Joint) -> Outline | None:
    """The outline of a joint that follows a plane curve; None for other joints."""
    track = joint.parameters.get("curve")
    if not isinstance(track, Track) or wires_of(joint):
        return None
    is_flat = JOINTS[joint.type].frame == "face"
    is_cam = is_flat or "roller" in JOINTS[joint.type].parameters
    angle = track.line.places.angle
    beside = (track.line.places.point * np.column_stack([np.cos(angle), np.sin(angle)])).sum(axis=1)
    outline = _outline(track, track.roller if is_cam else 0.0, joint.parameters.get("side") if is_cam else "inside")
    roller = joint.parameters.get("roller", track.roller) if is_cam else 0.0
    return outline._replace(roller=roller, face=float(np.abs(beside).max()) if is_flat else 0.0)


def both_outlines(joint: Joint) -> tuple[Outline, ...]:
    """The outlines of both bodies for a joint whose curves touch. For another joint, that of body 1, where it has
    one."""
    if "curves" not in joint.parameters:
        outline = outline_of(joint)
        return () if outline is None else (outline,)
    sides = joint.parameters.get("sides", (None, None))
    return tuple(
        _outline(track, track.roller, side) for track, side in zip(joint.parameters["curves"], sides, strict=True)
    )


def _outline(track: Track, left: float, side: str | None) -> Outline:
    """The outline at a distance `left` of a curve. `side` is the side from which it is touched."""
    points = np.array(points_along(track.line, left))
    apart = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.append(True, apart > DISTINCT * apart.max())]
    closed = track.line.closed
    solid = closed and (side or "outside") == "outside" and _is_star(points)
    return Outline(points[:-1] if closed else points, closed, solid, 0.0, 0.0)


def _is_star(points: Array) -> bool:
    """Whether all points of a closed outline are visible from the origin."""
    x, y = points.T
    turn = x[:-1] * y[1:] - x[1:] * y[:-1]
    return bool((turn > 0.0).all() or (turn < 0.0).all())


def track(outline: Outline, point: Array, turn: Array, r: float) -> Solid:
    """The solid of an outline, as a disc or a rail. It is in the plane of a frame at `point` (3,), turned by `turn`
    (4,); `r` is the radius of a link."""
    mesh = _disc(outline, WIDE * r) if outline.solid else _rail(outline, THICK * r, WIDE * r)
    return Solid("mesh", (), point, turn, mesh)


def _disc(outline: Outline, wide: float) -> Mesh:
    """A disc: two faces, each a fan about the origin, and the wall between them."""
    points = outline.points if _runs_left(outline.points) else outline.points[::-1]
    count = len(points)
    rim = [np.column_stack([points, np.full(count, side * 0.5 * wide)]) for side in (-1.0, 1.0)]
    middle = np.array([[0.0, 0.0, -0.5 * wide], [0.0, 0.0, 0.5 * wide]])
    here, after = np.arange(count), np.roll(np.arange(count), -1)
    low, high = np.full(count, 2 * count), np.full(count, 2 * count + 1)
    faces = [
        np.column_stack([after, here, low]),
        np.column_stack([count + here, count + after, high]),
        np.column_stack([here, after, count + after]),
        np.column_stack([here, count + after, count + here]),
    ]
    return Mesh(np.concatenate([*rim, middle]), np.concatenate(faces).astype(np.intp), convex=False)


def _rail(outline: Outline, thick: float, wide: float) -> Mesh:
    """A rail: a rectangle swept along the curve."""
    points = outline.points
    along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    if not outline.closed:
        along[0], along[-1] = points[1] - points[0], points[-1] - points[-2]
    across = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    corners = [(0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)]
    count = len(points)
    vertices = np.concatenate(
        [np.column_stack([points + a * thick * across, np.full(count, b * wide)]) for a, b in corners]
    )
    return _tube(vertices, count, outline.closed)


def wires_of(joint: Joint) -> tuple[Line, ...]:
    """The lines by which the primitives of a joint show the curve that they follow, in the frame of body 1."""
    track = joint.parameters.get("curve")
    if track is None:
        return ()
    kinds = (PRIMITIVES[row[0]] for row in JOINTS[joint.type].coordinates.values())
    lines = []
    for points, closed in next((found for kind in kinds if (found := kind.lines(track.line))), ()):
        apart = np.linalg.norm(np.diff(points, axis=0), axis=1)
        distinct = points[np.append(True, apart > DISTINCT * apart.max())]
        lines.append(Line(distinct[:-1] if closed else distinct, closed))
    return tuple(lines)


def wire(curve: Line, point: Array, turn: Array, r: float) -> Solid:
    """A thin bar along a space curve, in a frame with its origin at `point` (3,), turned by `turn` (4,)."""
    points, count = curve.points, len(curve.points)
    along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    if not curve.closed:
        along[0], along[-1] = points[1] - points[0], points[-1] - points[-2]
    along /= np.linalg.norm(along, axis=1)[:, None]
    beside = np.empty_like(points)
    last = np.eye(3)[int(np.argmin(np.abs(along[0])))]
    for at, tangent in enumerate(along):  # carry the last normal along, made normal to the new tangent
        last = last - (last @ tangent) * tangent
        last = last / np.linalg.norm(last)
        beside[at] = last
    other, half = np.cross(along, beside), 0.5 * THICK * r
    corners = [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
    vertices = np.concatenate([points + half * (a * beside + b * other) for a, b in corners])
    return Solid("mesh", (), point, turn, _tube(vertices, count, curve.closed))


def _tube(vertices: Array, count: int, closed: bool) -> Mesh:
    """The solid between four rows of `count` vertices each."""
    here = np.arange(count if closed else count - 1)
    after = (here + 1) % count
    faces = []
    for k in range(4):
        one, other = k * count, (k + 1) % 4 * count
        faces += [np.column_stack([one + here, other + here, other + after])]
        faces += [np.column_stack([one + here, other + after, one + after])]
    if not closed:
        starts, ends = np.arange(4) * count, np.arange(4) * count + count - 1
        faces += [starts[[[0, 2, 1], [0, 3, 2]]], ends[[[0, 1, 2], [0, 2, 3]]]]
    return Mesh(vertices, np.concatenate(faces).astype(np.intp), convex=False)


def _runs_left(points: Array) -> bool:
    """Whether a closed outline runs counter-clockwise."""
    x, y = points.T
    return bool(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0.0)
