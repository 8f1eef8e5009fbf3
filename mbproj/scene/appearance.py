"""The appearance of bodies, as frozen records; it has no effect on the motion."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from mbproj.dataclass import dataclass

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

#: Colours by name: those of the figures (Okabe & Ito, 2008: told apart by colour-blind readers too), and metals.
COLOURS: Mapping[str, str] = MappingProxyType(
    {
        "blue": "#0072b2",
        "orange": "#e69f00",
        "green": "#009e73",
        "vermilion": "#d55e00",
        "sky": "#56b4e9",
        "purple": "#cc79a7",
        "yellow": "#f0e442",
        "black": "#222222",
        "grey": "#8a8f98",
        "steel": "#9aa5b1",
        "brass": "#b8963e",
        "red": "#c23b22",
        "white": "#f4f4f4",
    }
)
#: Meshes that can be read, by the ending of the file.
MESH_FORMATS = ("stl", "obj")


@dataclass(frozen=True)
class PlacedShape:
    """A shape of `mbproj.scene.solids.shapes`, with its dimensions by name in m. A shape with a length has it along its
    own `axis`. `position` in m is that of its middle from the body's centre of mass. It is turned against the body axes
    by `orientation` (Euler parameters)."""

    kind: str
    sizes: Mapping[str, float]
    axis: str = "z"
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class MeshFile:
    """A mesh in a file, by its path from the scene's folder. Its numbers times `scale` are metres. `position` and
    `orientation` are those of a `PlacedShape`."""

    file: str
    scale: float = 1.0
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Appearance:
    """How a body is drawn: `colour` #rrggbb (None: the figure chooses one), `opacity` up to 1. `shapes` or a `mesh` are
    drawn in place of the shapes that give its mass."""

    colour: str | None = None
    opacity: float = 1.0
    shapes: tuple[PlacedShape, ...] = ()
    mesh: MeshFile | None = None
