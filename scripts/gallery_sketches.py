"""How each mechanism of the gallery is drawn: its view, and the shapes of bodies that are not bars between joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mbproj.base.arrays import Array

Point = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Shape:
    """Part of a body: corners (k, 3) of a bar or plate in body axes, m; `width` of a bar in points, None: a plate."""

    corners: Array
    width: float | None = 6.0


def disc(centre: Point, radius: float, axis: int) -> Shape:
    """A round plate normal to a body axis (0, 1 or 2)."""
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    return Shape(np.array(centre) + radius * np.roll(np.stack([0 * turn, np.cos(turn), np.sin(turn)]), axis, 0).T, None)


def box(x: float, y: float, z: float) -> tuple[Shape, ...]:
    """The faces of a box with these half sides about the centre of mass."""
    corners = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
    faces = [side * np.roll(corners, axis, axis=1) * [x, y, z] for axis in range(3) for side in (1.0, -1.0)]
    return tuple(Shape(face, None) for face in faces)


def bar(corners: Iterable[Point], width: float | None = 6.0) -> Shape:
    """A bar through these points, or a plate where `width` is None."""
    return Shape(np.array(list(corners), dtype=float), width)


@dataclass(frozen=True)
class Sketch:
    """How a mechanism is shown: the view from (azimuth, elevation) in degrees, the time that the paths cover, times at
    which it is drawn once more, faintly, bodies that are not bars between their joints (by a pattern of names; the
    ground's are global), which markers leave a path (all, where None), and whether it hangs from the ground."""

    view: tuple[float, float] = (-60.0, 20.0)
    duration: float = 2.0
    ghosts: tuple[float, ...] = ()
    shapes: Mapping[str, tuple[Shape, ...]] = field(default_factory=dict)
    markers: tuple[str, ...] | None = None
    hangs: bool = False


def _shapes(given: Mapping[str, Any]) -> tuple[Shape, ...]:
    """Of one entry of the data: a bar, a plate, a disc, or a box by its half sides."""
    if "disc" in given:
        return (disc(given["disc"]["centre"], given["disc"]["radius"], "xyz".index(given["disc"]["axis"])),)
    if "box" in given:
        return box(*given["box"])
    if "plate" in given:
        return (bar(given["plate"], None),)
    return (bar(given["bar"], given.get("width", 6.0)),)


def _sketch(view: list[float], duration: float, shapes: Mapping[str, Any] | None = None, **others: Any) -> Sketch:
    """Of the keys of the data."""
    drawn = {name: tuple(shape for entry in each for shape in _shapes(entry)) for name, each in (shapes or {}).items()}
    keys: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in others.items()}
    return Sketch((float(view[0]), float(view[1])), duration, shapes=drawn, **keys)


FLAT = (-90.0, 0.0)
SKETCHES: Mapping[str, Sketch] = {
    name: _sketch(**given)
    for name, given in yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8")).items()
}
