"""The mass and the inertia of a link of an SDF: as given, or from its collision shapes with their densities."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.formats.geometry import Frame, check_inertia
from mbproj.formats.sdf.scopes import number, pose_in, vector
from mbproj.formats.xml import XmlElement

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
    given, pose = inertial.first("inertia"), pose_in(inertial)
    mass = number(inertial, "mass", 1.0)
    inertia = np.eye(3)
    if given is not None:
        xx, yy, zz = (number(given, tag, 1.0) for tag in ("ixx", "iyy", "izz"))
        xy, xz, yz = (number(given, tag) for tag in ("ixy", "ixz", "iyz"))
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    check_inertia(mass, inertia, (inertial.first("mass") or inertial).place, (given or inertial).place)
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
