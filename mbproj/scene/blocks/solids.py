"""The shapes of bodies, one entry each: the dimensions, the volume, and the mean squares of the coordinates.

    box: [a, b, c]                                        edges along x, y and z
    cylinder: {radius, length}                            along z, or another `axis: x | y | z`
    tube: {outer_radius, inner_radius, length}            a hollow cylinder, likewise
    sphere: radius
    hollow_sphere: {outer_radius, inner_radius}
    rod: {length}                                         slender, along z or another `axis`; no volume
    point: {}                                             no volume, no moments of inertia

All are homogeneous, with their centres of mass at the middle. `spread` are the mean squares of the coordinates, ⟨x²⟩,
⟨y²⟩ and ⟨z²⟩ in m², about that centre in the shape's own axes. The principal moments per unit mass follow from them:
⟨y²⟩ + ⟨z²⟩, ⟨z²⟩ + ⟨x²⟩, ⟨x²⟩ + ⟨y²⟩.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from math import pi
from types import MappingProxyType
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.scene.fields.choices import NameChoice
from mbproj.scene.fields.containers import Complaint, OneOf, Record, Rule
from mbproj.scene.fields.fields import Converted, Field, List
from mbproj.scene.fields.quantities import Number
from mbproj.scene.records import Vector

#: The mean squares of a shape along x, y or z, from those of one along z.
_ALONG: Mapping[str, Callable[[Vector], Vector]] = MappingProxyType(
    {"x": lambda s: (s[2], s[0], s[1]), "y": lambda s: (s[1], s[2], s[0]), "z": lambda s: s}
)
LENGTH = Number("m", above=0.0)
AXIS = NameChoice("axis", lambda: _ALONG)


@dataclass(frozen=True)
class ShapeType:
    """One kind of shape: `spread` and `volume` (m³; None where it has none) are functions of the dimensions by name.

    An `axis` among the dimensions is the axis of the shape that is z in `spread`.
    """

    dimensions: Field[Mapping[str, Any]]
    spread: Callable[..., Vector]
    volume: Callable[..., float] | None = None


@dataclass(frozen=True)
class Shape:
    """A shape of given dimensions: `spread` in m², `volume` in m³ or None. `sizes` are the dimensions by name in m; a
    shape with a length has it along its own `axis`."""

    kind: str
    spread: Vector
    volume: float | None
    sizes: Mapping[str, float]
    axis: str


def thick(outer: float, inner: float) -> Iterator[Complaint]:
    """A check that the outer radius is larger than the inner one."""
    if inner >= outer:
        message = f"'inner_radius' must be less than 'outer_radius' ({outer:g} m), found {inner:g}"
        yield Complaint(("inner_radius",), message)


RADII: Mapping[str, Field[Any]] = MappingProxyType({"outer_radius": LENGTH, "inner_radius": LENGTH})
_THICK = (Rule(("outer_radius", "inner_radius"), thick),)
_EDGES: Field[Any] = Converted(List(LENGTH, 3), lambda edges: dict(zip("abc", edges, strict=True)))
_RODLIKE: Mapping[str, Field[Any]] = MappingProxyType({"length": LENGTH, "axis": AXIS})
_ROD: Record[dict[str, Any]] = Record("a rod", _RODLIKE, dict, ("length",))
_CYLINDER: Record[dict[str, Any]] = Record("a cylinder", {"radius": LENGTH, **_RODLIKE}, dict, ("radius", "length"))
_TUBE: Record[dict[str, Any]] = Record("a tube", {**RADII, **_RODLIKE}, dict, (*RADII, "length"), _THICK)
_RADIUS: Field[Any] = Converted(LENGTH, lambda radius: {"r": radius})
_HOLLOW: Record[dict[str, float]] = Record("a hollow sphere", RADII, dict, tuple(RADII), _THICK)


def _cylinder_spread(radius: float, length: float) -> Vector:
    return (radius * radius / 4, radius * radius / 4, length * length / 12)


def _tube_spread(outer_radius: float, inner_radius: float, length: float) -> Vector:
    across = (outer_radius * outer_radius + inner_radius * inner_radius) / 4
    return (across, across, length * length / 12)


def _tube_volume(outer_radius: float, inner_radius: float, length: float) -> float:
    return pi * (outer_radius - inner_radius) * (outer_radius + inner_radius) * length


def _hollow_spread(outer_radius: float, inner_radius: float) -> Vector:
    """(R⁵ - r⁵) / (R³ - r³) / 5 with R - r divided out, so that a thin shell loses no digits."""
    big, ratio = outer_radius, inner_radius / outer_radius
    above = 1 + ratio * (1 + ratio * (1 + ratio * (1 + ratio)))
    square = big * big * above / (1 + ratio * (1 + ratio)) / 5
    return (square, square, square)


def _hollow_volume(outer_radius: float, inner_radius: float) -> float:
    squares = outer_radius * outer_radius + outer_radius * inner_radius + inner_radius * inner_radius
    return 4 / 3 * pi * (outer_radius - inner_radius) * squares


SHAPES: Mapping[str, ShapeType] = MappingProxyType(
    {
        "box": ShapeType(_EDGES, lambda a, b, c: (a * a / 12, b * b / 12, c * c / 12), lambda a, b, c: a * b * c),
        "cylinder": ShapeType(_CYLINDER, _cylinder_spread, lambda radius, length: pi * radius * radius * length),
        "tube": ShapeType(_TUBE, _tube_spread, _tube_volume),
        "sphere": ShapeType(_RADIUS, lambda r: (r * r / 5, r * r / 5, r * r / 5), lambda r: 4 / 3 * pi * r * r * r),
        "hollow_sphere": ShapeType(_HOLLOW, _hollow_spread, _hollow_volume),
        "rod": ShapeType(_ROD, lambda length: (0.0, 0.0, length * length / 12)),
        "point": ShapeType(Record("a point", {}, dict), lambda: (0.0, 0.0, 0.0)),
    }
)


def _shape(kind: str, dimensions: Mapping[str, Any]) -> Shape:
    entry = SHAPES[kind]
    sizes = {name: size for name, size in dimensions.items() if name != "axis"}
    axis = dimensions.get("axis", "z")
    spread = _ALONG[axis](entry.spread(**sizes))
    return Shape(kind, spread, entry.volume(**sizes) if entry.volume else None, sizes, axis)


#: The field that reads each shape, by its name.
SHAPE_FIELDS: Mapping[str, Field[Shape]] = MappingProxyType(
    {name: Converted(entry.dimensions, partial(_shape, name)) for name, entry in SHAPES.items()}
)
#: Exactly one of the keys of shapes must be given.
A_SHAPE = OneOf(tuple(SHAPE_FIELDS), needed=True)
