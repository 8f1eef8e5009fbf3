"""Visuals of a URDF: boxes, cylinders, spheres, capsules, and meshes, in the colours of their materials."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from mbproj.formats.geometry import Frame, numbers
from mbproj.formats.urdf.model import Urdf, number, origin_of
from mbproj.formats.visuals import Shapes, Visual, box, capsule, colour, cylinder, mesh_file, sphere
from mbproj.formats.xml import XmlElement


def visuals(
    root: XmlElement, model: Urdf, frames: Mapping[str, Frame], called: Mapping[str, str], folder: Path
) -> Iterator[Visual]:
    """Yield the visuals of all links. Raises InputError at numbers that are wrong."""
    materials = {each.get("name"): _colour(each) for each in root.walk() if each.tag == "material" and each.children}
    for link in model.links.values():
        for element in link.element.all("visual"):
            pose = frames[link.name].then(origin_of(element.first("origin")))
            geometry, material = element.first("geometry"), element.first("material")
            look = materials.get(material.get("name")) if material is not None else None
            kind = geometry.children[0] if geometry is not None and geometry.children else None
            if kind is None:
                continue
            body = called[link.name]
            if kind.tag != "mesh":
                yield Visual(body, pose, _shapes(kind), colour=look)
                continue
            scale = numbers(kind.get("scale", "1 1 1"), 3, kind.place, "'scale'")
            file = mesh_file(kind.get("filename"), folder) if np.ptp(scale) == 0.0 else None
            yield Visual(body, pose, (), file, float(scale[0]), look, "meshes")


def _colour(material: XmlElement) -> str | None:
    given = material.first("color")
    return None if given is None else colour(numbers(given.get("rgba", "0 0 0 1"), 4, given.place, "'rgba'").tolist())


def _shapes(kind: XmlElement) -> Shapes:
    if kind.tag == "box":
        return box(numbers(kind.get("size"), 3, kind.place, "'size'"))
    if kind.tag == "sphere":
        return sphere(number(kind, "radius"))
    if kind.tag in ("cylinder", "capsule"):
        return (cylinder if kind.tag == "cylinder" else capsule)(number(kind, "radius"), number(kind, "length"))
    return ()
