"""The appearance of the bodies of a model: shapes, or a mesh whose file stays where it is. It has no effect on
motion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.formats.geometry import Frame, placed
from mbproj.formats.mechanism import ImportedMechanism, Same
from mbproj.scene.records import MESH_FORMATS

#: The largest extent of a shape that is drawn, in m.
LARGEST = 1e6
#: Shapes, each as the key of a scene, with the position of its middle along z of its frame in m.
Shapes = tuple[tuple[dict[str, Any], float], ...]


@dataclass(frozen=True, eq=False)
class Visual:
    """An appearance at a global `pose`: shapes, or the file of a mesh, whose numbers times `scale` are metres. It has
    neither where a scene has no such shape; then `word` names it in the table."""

    body: str
    pose: Frame
    shapes: Shapes = ()
    mesh: Path | None = None
    scale: float = 1.0
    colour: str | None = None
    word: str = "other shapes"


def box(sizes: Iterable[float]) -> Shapes:
    """The shapes of a box with these edges."""
    return (({"box": [float(each) for each in sizes]}, 0.0),)


def sphere(radius: float) -> Shapes:
    """The shapes of a sphere about the origin of its frame."""
    return (({"sphere": float(radius)}, 0.0),)


def cylinder(radius: float, length: float) -> Shapes:
    """The shapes of a cylinder along z."""
    return (({"cylinder": {"radius": float(radius), "length": float(length)}}, 0.0),)


def capsule(radius: float, length: float) -> Shapes:
    """The shapes of a capsule: a cylinder along z and two spheres."""
    ends = tuple(({"sphere": float(radius)}, sign * 0.5 * length) for sign in (-1.0, 1.0))
    return (*cylinder(radius, length), *ends)


def colour(rgba: Sequence[float]) -> str:
    """The colour #rrggbb from red, green and blue between 0 and 1."""
    return "#" + "".join(f"{round(255 * min(1.0, max(0.0, float(part)))):02x}" for part in rgba[:3])


def mesh_file(name: str, folder: Path) -> Path | None:
    """The file that a model names, perhaps as one of a package; None where it does not exist in the model's folder."""
    plain = name.partition("://")[2] if "://" in name else name
    for each in (plain, plain.partition("/")[2]) if "://" in name else (plain,):
        try:
            file = (folder / each.lstrip("/")).resolve() if "://" in name else (folder / each).resolve()
            if each and file.is_relative_to(folder) and file.is_file():
                return file
        except (OSError, ValueError, RuntimeError):
            return None
    return None


def add_visuals(mechanism: ImportedMechanism, visuals: Iterable[Visual], folder: Path) -> None:
    """Give bodies an appearance for a scene in this folder: shapes, or else one mesh. Visuals that are not drawn get
    rows of the table."""
    shapes: dict[str, list[dict[str, Any]]] = {}
    meshes: dict[str, list[dict[str, Any]]] = {}
    colours: dict[str, str | None] = {}
    undrawn: Counter[str] = Counter()
    for visual in visuals:
        part = mechanism.parts.get(visual.body)
        if part is None:
            continue
        at = Frame(part.local(visual.pose.position), part.rotation.T @ visual.pose.rotation)
        file = _from(folder, visual.mesh)
        drawn = [(shape, shift) for shape, shift in visual.shapes if _has_size(shape)]
        for shape, shift in drawn:
            turned = np.eye(3) if "sphere" in shape else at.rotation
            place = placed(at.position + shift * at.rotation[:, 2], turned)
            shapes.setdefault(visual.body, []).append(shape | place)
        if file:
            scale = {"scale": visual.scale} if visual.scale != 1.0 else {}
            meshes.setdefault(visual.body, []).append({"file": file} | scale | placed(at.position, at.rotation))
        if file or drawn:
            colours.setdefault(visual.body, visual.colour)
        else:
            undrawn[visual.word] += 1
    for body in colours:
        body_shapes, others = shapes.get(body), meshes.get(body, [])
        look: dict[str, Any] = {"shapes": body_shapes} if body_shapes else {"mesh": others[0]}
        undrawn["meshes"] += len(others) - (0 if body_shapes else 1)
        shown = {"colour": colours[body]} if colours[body] else {}
        mechanism.parts[body] = replace(mechanism.parts[body], look=shown | look)
    for word, count in undrawn.items():
        what = "not drawn: a body of a scene has shapes, or one .stl or .obj file in the scene's folder"
        if count:
            mechanism.say(f"{count} {word}", None, what if word == "meshes" else "not drawn", Same.YES)


def _has_size(shape: dict[str, Any]) -> bool:
    """Whether the shape has an extent that can be drawn."""
    (sizes,) = shape.values()
    numbers = sizes.values() if isinstance(sizes, dict) else np.atleast_1d(sizes)
    return all(0.0 < each < LARGEST for each in numbers)


def _from(folder: Path, mesh: Path | None) -> str:
    """The path of a mesh from the scene's folder; "" where the scene could not read it."""
    if mesh is None or mesh.suffix[1:].lower() not in MESH_FORMATS or not mesh.is_relative_to(folder.resolve()):
        return ""
    return str(mesh.relative_to(folder.resolve()))
