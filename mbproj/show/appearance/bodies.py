"""The parts that a body is drawn as. These are its shapes, or the solid of equal inertia where its joints fit that, or
links. The solid of equal inertia is homogeneous and has the body's mass and moments of inertia.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mbproj.base.arrays import Array
from mbproj.model.euler_parameters import product
from mbproj.scene.meshes import TriangleMesh
from mbproj.scene.records import Body, PlacedShape
from mbproj.show.appearance.parts import UPRIGHT, Mesh, Solid, bar, box, plate, sphere, triad

#: The relative difference of two principal moments up to which they count as equal.
ROUND = 1e-6


def solid_of(mass: float, inertia: Array, thinnest: float) -> Solid | None:
    """A cylinder where two principal moments are equal, otherwise a box, in body axes about the centre of mass.

    No edge is thinner than `thinnest`. None for a body without mass or moments, because a point has no size."""
    if mass <= 0.0:
        return None
    moments, axes = np.linalg.eigh(np.asarray(inertia, dtype=float))
    if moments[2] <= 0.0:
        return None
    low, middle, high = moments / mass
    if high - middle <= ROUND * high:
        return _cylinder(low, high, axes[:, 0], axes[:, 2], thinnest)
    if middle - low <= ROUND * high:
        return _cylinder(high, low, axes[:, 2], axes[:, 0], thinnest)
    squares = 6.0 * (np.array([middle + high - low, low + high - middle, low + middle - high]))
    edges = np.maximum(np.sqrt(np.maximum(squares, 0.0)), thinnest)
    return box(edges.tolist(), np.zeros(3), triad(axes[:, 2], axes[:, 0]))


def _cylinder(axial: float, across: float, axis: Array, normal: Array, thinnest: float) -> Solid:
    """A cylinder of mass 1: C = R²/2 along its axis, A = (3R² + L²)/12 across."""
    radius = max(np.sqrt(2.0 * axial), 0.5 * thinnest)
    length = max(np.sqrt(max(12.0 * across - 6.0 * axial, 0.0)), thinnest)
    return Solid("cylinder", (float(radius), float(length)), np.zeros(3), triad(axis, normal))


_HALF = 0.5**0.5
#: The Euler parameters that turn z to the axis of a shape.
TO_AXIS: Mapping[str, tuple[float, ...]] = {
    "x": (_HALF, 0.0, _HALF, 0.0),
    "y": (_HALF, -_HALF, 0.0, 0.0),
    "z": (1.0, 0.0, 0.0, 0.0),
}


def part_of(shape: PlacedShape, thickness: float) -> tuple[Solid, ...]:
    """The solids that a shape is drawn as. A rod and a point have no thickness of their own and take this one."""
    sizes, position, turn = shape.sizes, np.array(shape.position), np.array(shape.orientation)
    along = product(turn, np.array(TO_AXIS[shape.axis]))
    if shape.kind == "box":
        return (Solid("box", (sizes["a"], sizes["b"], sizes["c"]), position, turn),)
    if shape.kind == "cylinder":
        return (Solid("cylinder", (sizes["radius"], sizes["length"]), position, along),)
    if shape.kind == "tube":
        return (Solid("tube", (sizes["outer_radius"], sizes["inner_radius"], sizes["length"]), position, along),)
    if shape.kind == "rod":
        half = np.array([0.0, 0.0, 0.5 * sizes["length"]])
        return tuple(part.moved(position, along) for part in bar(-half, half, 0.7 * thickness))
    radius = {"sphere": sizes.get("r"), "hollow_sphere": sizes.get("outer_radius")}.get(shape.kind)
    return (sphere(radius if radius is not None else 1.5 * thickness, position),)


#: A solid may miss a joint of its body by this part of its length, and may be this many times as long as the joints'
#: span.
MISSES, LONGER = 0.12, 1.35
#: A solid may be this part of the span thick.
SLENDER = 0.12
#: Axes are parallel where the sine of their angle is below this.
PARALLEL = 1e-6
#: Two points of a body count as one where they are closer than this many thicknesses.
SAME = 0.5
#: A strut leads to a marker, or to a joint of a body with shapes, that is farther than this many radii from all parts.
OFF = 2.0
#: A solid about a body's only joint may be this many times as long as the distance of the joint from the centre of
#: mass.
ABOUT = 2.5


def parts_of(
    body: Body,
    joints: Sequence[Array],
    axes: Sequence[Array | None],
    markers: Sequence[Array],
    thickness: float,
    mesh: TriangleMesh | None = None,
    *,
    loose: bool = False,
) -> tuple[Solid, ...]:
    """The parts of a body with `joints` and `markers` at these points, (3,) from its centre of mass, in its axes.

    `axes` are the axes about which its joints turn, or None for a joint without one. `thickness` is the radius of a
    link in m, `mesh` the triangles that replace all parts. A `loose` body has no joints: the points are those of the
    springs and stops that hold it."""
    if mesh is not None:
        return (Solid("mesh", (), np.zeros(3), np.array(UPRIGHT), Mesh(mesh.vertices, mesh.triangles, convex=False)),)
    look = body.appearance
    shapes = look.shapes if look is not None and look.shapes else body.shapes
    if shapes:
        drawn = tuple(part for shape in shapes for part in part_of(shape, thickness))
        return drawn + _struts(drawn, distinct(joints, SAME * thickness), thickness)
    drawn = _without_shapes(body, joints, axes, markers, thickness, loose=loose)
    return drawn + _struts(drawn, markers, 0.45 * thickness)


def distinct(points: Sequence[Array], apart: float) -> list[Array]:
    """The points without those that are closer than `apart` to an earlier one."""
    kept_points: list[Array] = []
    for point in points:
        if all(np.linalg.norm(point - other) > apart for other in kept_points):
            kept_points.append(point)
    return kept_points


def _without_shapes(
    body: Body,
    joints: Sequence[Array],
    axes: Sequence[Array | None],
    markers: Sequence[Array],
    thickness: float,
    *,
    loose: bool,
) -> tuple[Solid, ...]:
    points, centre = distinct(joints, SAME * thickness), np.zeros(3)
    solid = solid_of(body.mass, np.array(body.inertia), 0.8 * thickness)
    if solid is not None and _fits(solid, points, any_shape=loose):
        return (solid,)
    along = _shaft(joints, axes, thickness)
    if along:
        return along
    if len(points) > 2:
        flat = plate(points, 1.2 * thickness)
        return flat or tuple(part for point in points for part in bar(centre, point, thickness))
    if len(points) == 2:
        first, second = points
        away = np.linalg.norm(np.cross(second - first, first)) / np.linalg.norm(second - first)
        if away <= 2.0 * thickness or body.mass == 0.0:
            return bar(first, second, thickness)
        return plate([*points, centre], 1.2 * thickness) or bar(first, second, thickness)
    ends = distinct([*points, centre, *markers], SAME * thickness)
    links = tuple(part for end in ends[1:] for part in bar(ends[0], end, thickness))
    return (*links, *_weight(solid, ends)) or (sphere(2.0 * thickness, centre),)


def _weight(solid: Solid | None, ends: Sequence[Array]) -> tuple[Solid, ...]:
    """The solid at the end of a link, unless it is larger than the link is long."""
    longest = max((float(np.linalg.norm(end)) for end in ends), default=0.0)
    if solid is None or float(np.ptp(solid.outline(), axis=0).max()) > 1.2 * longest:
        return ()
    return (solid,)


def _shaft(joints: Sequence[Array], axes: Sequence[Array | None], thickness: float) -> tuple[Solid, ...]:
    """A shaft with cranks, for joints with parallel axes at different places along them. A bar runs along the axis of
    the first joint, and an arm leads to each other joint."""
    if len(joints) < 2 or any(axis is None for axis in axes):
        return ()
    axis, root = np.asarray(axes[0]), joints[0]
    if any(np.linalg.norm(np.cross(np.asarray(other), axis)) > PARALLEL for other in axes):
        return ()
    along = [float((joint - root) @ axis) for joint in joints]
    if max(along) - min(along) < 3.0 * thickness:
        return ()
    solids = list(bar(root + min(along) * axis, root + max(along) * axis, thickness))
    for joint, at in zip(joints, along, strict=True):
        if np.linalg.norm(joint - root - at * axis) > SAME * thickness:
            solids += bar(root + at * axis, joint, thickness)
    return tuple(solids)


def _fits(solid: Solid, points: Sequence[Array], *, any_shape: bool) -> bool:
    """Whether the solid resembles the body. It must reach the joints and not be much longer than their span. Between
    two joints it must be slender, among more it must be flat, unless it may have `any_shape`, as between springs."""
    corners = (solid.outline() - solid.position) @ solid.rotation
    thin, middle, length = np.sort(np.ptp(corners, axis=0)).tolist()
    if not points:
        return True
    if len(points) == 1:
        return length <= ABOUT * float(np.linalg.norm(points[0])) and _reaches(solid, points, length)
    span = max(float(np.linalg.norm(one - other)) for one in points for other in points)
    shaped = middle <= SLENDER * span if len(points) == 2 else thin <= SLENDER * span
    return (shaped or any_shape) and length <= LONGER * span and _reaches(solid, points, length)


def _reaches(solid: Solid, points: Sequence[Array], length: float) -> bool:
    """Whether all points are in the solid's box, enlarged by a part of its length."""
    half = (
        0.5 * np.array(solid.size)
        if solid.kind == "box"
        else np.array([solid.size[0], solid.size[0], 0.5 * solid.size[1]])
    )
    return all(bool((np.abs(solid.rotation.T @ point) <= half + MISSES * length).all()) for point in points)


def _struts(drawn: Sequence[Solid], points: Sequence[Array], radius: float) -> tuple[Solid, ...]:
    """A thin bar from the nearest part to each point that is off all parts."""
    if not drawn:
        return ()
    struts: list[Solid] = []
    for point in points:
        near = min((_nearest(part, point) for part in drawn), key=lambda at: float(np.linalg.norm(point - at)))
        if np.linalg.norm(point - near) > OFF * radius:
            struts += bar(near, point, radius)[:1]
    return tuple(struts)


def _nearest(part: Solid, point: Array) -> Array:
    """The point of a part that is about nearest to `point`."""
    if part.mesh is not None:
        corners = part.outline()
        nearest: Array = corners[np.argmin(np.linalg.norm(corners - point, axis=1))]
        return nearest
    local = part.rotation.T @ (point - part.position)
    if part.kind == "box":
        half = 0.5 * np.array(part.size)
        return part.position + part.rotation @ np.clip(local, -half, half)
    radius, half_length = part.size[0], (0.0 if part.kind == "sphere" else 0.5 * part.size[-1])
    along = np.array([0.0, 0.0, np.clip(local[2], -half_length, half_length)])
    out = local - along
    if part.kind != "sphere":
        out[2] = 0.0
    length = float(np.linalg.norm(out))
    return part.position + part.rotation @ (along + out * min(1.0, radius / length if length else 0.0))
