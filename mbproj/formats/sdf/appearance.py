"""Visuals of an SDF: boxes, cylinders, spheres, capsules, and meshes, in the colours of their materials."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from mbproj.formats.geometry import Frame
from mbproj.formats.sdf.scopes import number, text, vector
from mbproj.formats.visuals import Shapes, Visual, box, capsule, colour, cylinder, mesh_file, sphere
from mbproj.formats.xml import XmlElement


def visuals(
    link: XmlElement, body: str, frame: Frame, place: Callable[[XmlElement], Frame], folder: Path
) -> Iterator[Visual]:
    """Yield the visuals of a link whose global pose is `frame`; `place` gives the pose of a shape in the link. Raises
    InputError at a text that is no number."""
    for element in link.all("visual"):
        geometry = element.first("geometry")
        kind = geometry.children[0] if geometry is not None and geometry.children else None
        if kind is None:
            continue
        pose, look = frame.then(place(element)), _colour(element)
        if kind.tag != "mesh":
            yield Visual(body, pose, _shapes(kind), colour=look)
            continue
        scale = vector(kind, "scale", "1 1 1")
        file = mesh_file(text(kind, "uri"), folder) if np.ptp(scale) == 0.0 else None
        yield Visual(body, pose, (), file, float(scale[0]), look, "meshes")


def _colour(visual: XmlElement) -> str | None:
    material = visual.first("material")
    given = text(material, "diffuse") if material is not None else ""
    try:
        parts = [float(part) for part in given.split()]
    except ValueError:
        return None
    return colour(parts) if len(parts) >= 3 and np.isfinite(parts).all() else None


def _shapes(kind: XmlElement) -> Shapes:
    if kind.tag == "box":
        return box(vector(kind, "size", "1 1 1"))
    if kind.tag == "sphere":
        return sphere(number(kind, "radius", 1.0))
    if kind.tag in ("cylinder", "capsule"):
        default = (1.0, 1.0) if kind.tag == "cylinder" else (0.5, 1.0)
        make = cylinder if kind.tag == "cylinder" else capsule
        return make(number(kind, "radius", default[0]), number(kind, "length", default[1]))
    return ()
