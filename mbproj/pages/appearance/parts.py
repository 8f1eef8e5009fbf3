"""The few kinds of solids that everything is drawn with, each with its place on a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.model.euler_parameters import product, rotation_matrix

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
            own = self.mesh.vertices
        elif self.kind == "box":
            own = 0.5 * np.array(self.size) * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        elif self.kind == "sphere":
            own = self.size[0] * SPHERE
        else:
            radius, length = self.size[0], self.size[-1]
            ends = [np.column_stack([radius * CIRCLE, np.full(len(CIRCLE), end)]) for end in (-length / 2, length / 2)]
            own = np.concatenate(ends)
        return self.position + own @ self.rotation.T


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
