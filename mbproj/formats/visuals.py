"""What bodies of a model look like: shapes, or a mesh that stays where it is. No say in the motion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.formats.geometry import Pose
from mbproj.formats.mechanism import Mechanism, Same
from mbproj.formats.placed import placed
from mbproj.scene.appearance import MESH_FORMATS

#: No shape of a scene has so many m.
LARGEST = 1e6
#: A shape as the scene has it, and how far along z of its frame its middle is.
Shapes = tuple[tuple[dict[str, Any], float], ...]


@dataclass(frozen=True, eq=False)
class Visual:
    """Shapes, or the file of a mesh and what makes metres of its numbers, at a global `pose`; neither where a scene has
    no such thing, whose `word` is then said."""

    body: str
    pose: Pose
    shapes: Shapes = ()
    mesh: Path | None = None
    scale: float = 1.0
    colour: str | None = None
    word: str = "other shapes"


def box(sizes: Iterable[float]) -> Shapes:
    """With these edges."""
    return (({"box": [float(each) for each in sizes]}, 0.0),)


def sphere(radius: float) -> Shapes:
    """About its frame."""
    return (({"sphere": float(radius)}, 0.0),)


def cylinder(radius: float, length: float) -> Shapes:
    """Along z."""
    return (({"cylinder": {"radius": float(radius), "length": float(length)}}, 0.0),)


def capsule(radius: float, length: float) -> Shapes:
    """A cylinder and two spheres."""
    ends = tuple(({"sphere": float(radius)}, sign * 0.5 * length) for sign in (-1.0, 1.0))
    return (*cylinder(radius, length), *ends)


def colour(rgba: Sequence[float]) -> str:
    """#rrggbb of parts up to 1."""
    return "#" + "".join(f"{round(255 * min(1.0, max(0.0, float(part)))):02x}" for part in rgba[:3])


def mesh_file(name: str, folder: Path) -> Path | None:
    """The file that a model names, maybe in a package: in its folder, and there."""
    plain = name.partition("://")[2] if "://" in name else name
    for each in (plain, plain.partition("/")[2]) if "://" in name else (plain,):
        try:
            file = (folder / each.lstrip("/")).resolve() if "://" in name else (folder / each).resolve()
            if each and file.is_relative_to(folder) and file.is_file():
                return file
        except (OSError, ValueError, RuntimeError):
            return None
    return None


def add_visuals(mechanism: Mechanism, visuals: Iterable[Visual], folder: Path) -> None:
    """Gives bodies an appearance for a scene in this folder: shapes, or else one mesh. What is not drawn is said."""
    shapes: dict[str, list[dict[str, Any]]] = {}
    meshes: dict[str, list[dict[str, Any]]] = {}
    colours: dict[str, str | None] = {}
    undrawn: Counter[str] = Counter()
    for visual in visuals:
        part = mechanism.parts.get(visual.body)
        if part is None:
            continue
        at = Pose(part.local(visual.pose.position), part.rotation.T @ visual.pose.rotation)
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
        own, others = shapes.get(body), meshes.get(body, [])
        look: dict[str, Any] = {"shapes": own} if own else {"mesh": others[0]}
        undrawn["meshes"] += len(others) - (0 if own else 1)
        shown = {"colour": colours[body]} if colours[body] else {}
        mechanism.parts[body] = replace(mechanism.parts[body], look=shown | look)
    for word, count in undrawn.items():
        what = "not drawn: a body of a scene has shapes, or one .stl or .obj file in the scene's folder"
        if count:
            mechanism.say(f"{count} {word}", None, what if word == "meshes" else "not drawn", Same.YES)


def _has_size(shape: dict[str, Any]) -> bool:
    """Whether it has an extent that can be drawn."""
    (sizes,) = shape.values()
    numbers = sizes.values() if isinstance(sizes, dict) else np.atleast_1d(sizes)
    return all(0.0 < each < LARGEST for each in numbers)


def _from(folder: Path, mesh: Path | None) -> str:
    """The path of a mesh from the scene's folder, "" where the scene could not read it."""
    if mesh is None or mesh.suffix[1:].lower() not in MESH_FORMATS or not mesh.is_relative_to(folder.resolve()):
        return ""
    return str(mesh.relative_to(folder.resolve()))
