"""The solid of a body that is given by homogeneous shapes: its mass, centre of mass and inertia tensor.

`SHAPE` and `SOLID` are the fields of the keys `shape` and `shapes`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from math import pi
from types import MappingProxyType
from typing import Any

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import choose_from
from mbproj.scene.fields import rotations
from mbproj.scene.fields.fields import (
    Alternatives,
    Complaint,
    Converted,
    Field,
    List,
    NameChoice,
    OneOf,
    Record,
    Rule,
    Text,
)
from mbproj.scene.fields.placing import ORIENTATION
from mbproj.scene.fields.quantities import LARGEST, POINT, Number, inertia_of
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import COLOURS, MESH_FORMATS, Appearance, Matrix, MeshFile, PlacedShape, Quaternion, Vector

# --- The shapes of bodies, one entry each -----------------------------------------------------------------------------
# The dimensions, the volume, and the mean squares of the coordinates.
#
#    box: [a, b, c]                                        edges along x, y and z
#    cylinder: {radius, length}                            along z, or another `axis: x | y | z`
#    tube: {outer_radius, inner_radius, length}            a hollow cylinder, likewise
#    sphere: radius
#    hollow_sphere: {outer_radius, inner_radius}
#    rod: {length}                                         slender, along z or another `axis`; no volume
#    point: {}                                             no volume, no moments of inertia
# All are homogeneous, with their centres of mass at the middle. `spread` are the mean squares of the coordinates,
# ⟨x²⟩, ⟨y²⟩ and ⟨z²⟩ in m², about that centre in the shape's own axes. The principal moments per unit mass follow
# from them: ⟨y²⟩ + ⟨z²⟩, ⟨z²⟩ + ⟨x²⟩, ⟨x²⟩ + ⟨y²⟩.


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


# --- The solid of a body that is given by homogeneous shapes ----------------------------------------------------------


_ELEMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


@dataclass(frozen=True)
class SolidPart:
    """A shape of mass `mass` in kg with its centre of mass at `position` in m, its axes turned by `orientation`."""

    shape: Shape
    mass: float
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SolidBody:
    """A solid: mass in kg, centre of mass in m, the inertia tensor about it in kg m², in the common axes of `parts`."""

    mass: float
    centre: Vector
    inertia: Matrix
    parts: tuple[SolidPart, ...] = ()


def mass_of(shape: Shape, mass: float | None, density: float | None) -> float:
    """The mass as given, or the density times the volume of the shape. Raises Unfit where the product is no mass."""
    if mass is not None:
        return mass
    assert density is not None and shape.volume is not None
    return _possible(density * shape.volume)


def _possible(mass: float) -> float:
    if not 0.0 < mass <= LARGEST:
        raise Unfit(f"has a mass of {mass:g} kg", "look at the units of its dimensions and density")
    return mass


def alone(part: SolidPart) -> SolidBody:
    """The solid of one part, whose mass may be 0."""
    return SolidBody(part.mass, part.position, _tensor([part], part.position), (part,))


def together(parts: Iterable[SolidPart]) -> SolidBody:
    """The solid of several parts, each of which has a mass; where they overlap the masses add.

    Raises Unfit where its mass or its moments are no finite numbers.
    """
    parts = tuple(parts)
    mass = _possible(sum(part.mass for part in parts))
    x, y, z = (sum(part.mass * part.position[i] for part in parts) / mass for i in range(3))
    return SolidBody(mass, (x, y, z), _tensor(parts, (x, y, z)), parts)


def _tensor(parts: Iterable[SolidPart], centre: Vector) -> Matrix:
    """The inertia tensor about `centre`: J = tr(S) I - S, S = ∫ x xᵀ dm, from each part's own by Steiner's theorem."""
    second = dict.fromkeys(_ELEMENTS, 0.0)
    for part in parts:
        axes = rotations.to_matrix(part.orientation)
        arm = [at - middle for at, middle in zip(part.position, centre, strict=True)]
        for i, j in _ELEMENTS:
            spread = sum(axes[i][k] * axes[j][k] * part.shape.spread[k] for k in range(3))
            second[i, j] += part.mass * (spread + arm[i] * arm[j])
    xx, yy, zz, xy, xz, yz = second.values()
    if not all(abs(moment) <= LARGEST for moment in (*centre, *second.values(), xx + yy + zz)):
        raise Unfit("has moments of inertia that are too large", "look at the units of its dimensions")
    products = [0.0 - product for product in (xy, xz, yz)]  # never -0.0
    return inertia_of(rotations.from_elements([yy + zz, xx + zz, xx + yy, *products]))


DENSITY = Number("kg/m^3", above=0.0)


def has_volume(shape: Shape, density: float) -> Iterator[Complaint]:
    """A check that a shape with a density has a volume."""
    if shape.volume is None:
        yield Complaint(("density",), f"a {shape.kind} has no volume, so no density", "give its mass")


SHAPE: Record[Shape] = Record("a shape", SHAPE_FIELDS, lambda **keys: next(iter(keys.values())), choices=(A_SHAPE,))


def _part(keys: dict[str, Any]) -> SolidPart:
    shape = next(keys[kind] for kind in SHAPE_FIELDS if kind in keys)
    place = {key: keys[key] for key in ("position", "orientation") if key in keys}
    return SolidPart(shape, mass_of(shape, keys.get("mass"), keys.get("density")), **place)


PART: Field[SolidPart] = Converted(
    Record(
        "a shape",
        {
            **SHAPE_FIELDS,
            "mass": Number("kg", above=0.0),
            "density": DENSITY,
            "position": POINT,
            "orientation": ORIENTATION,
        },
        dict,
        checks=tuple(Rule((kind, "density"), has_volume) for kind in SHAPE_FIELDS),
        choices=(A_SHAPE, OneOf(("mass", "density"), needed=True)),
    ),
    _part,
)

SOLID: Field[SolidBody] = Converted(List(PART, None, "shapes"), together)


def solid_of(keys: Mapping[str, Any]) -> SolidBody:
    """The solid of a body's keys `shapes`, or `shape` with a mass or a density."""
    if "shapes" in keys:
        solid: SolidBody = keys["shapes"]
        return solid
    return alone(SolidPart(keys["shape"], mass_of(keys["shape"], keys.get("mass"), keys.get("density"))))


def drawn_shapes(solid: SolidBody) -> tuple[PlacedShape, ...]:
    """The shapes that are drawn for the parts of a solid, placed from its centre of mass."""
    shapes = []
    for part in solid.parts:
        x, y, z = (at - middle for at, middle in zip(part.position, solid.centre, strict=True))
        shapes.append(PlacedShape(part.shape.kind, part.shape.sizes, part.shape.axis, (x, y, z), part.orientation))
    return tuple(shapes)


# --- The `appearance` of a body ---------------------------------------------------------------------------------------
# How it is drawn. It has no effect on the motion.
#
#    appearance: {colour: "#4477aa", opacity: 0.5}
#    appearance: {shapes: [{cylinder: {radius: 0.4, length: 0.1}}, {box: [0.1, 0.1, 1], position: [0, 0, 0.5]}]}
#    appearance: {mesh: crank.stl}
#    appearance: {mesh: {file: crank.stl, scale: 0.001, position: [0, 0, 0.1]}}
# Places of shapes and meshes are from the centre of mass, along the body axes.


HEX = re.compile(r"#[0-9a-fA-F]{6}")
PLACE: dict[str, Field[Any]] = {"position": POINT, "orientation": ORIENTATION}


def _colour(text: str) -> str:
    """The colour as #rrggbb. Raises Unfit for a text that is none."""
    if HEX.fullmatch(text):
        return text.lower()
    if text not in COLOURS:
        raise Unfit(f"is no colour: '{text}'", f'give "#rrggbb"; {choose_from(text, COLOURS)}')
    return COLOURS[text]


def _file(text: str) -> str:
    """The path of a mesh. Raises Unfit where mbproj does not read its format."""
    ending = text.lower().rpartition(".")[2]
    if ending not in MESH_FORMATS or not text.isprintable():
        hint = "give the path of a .stl or .obj file, from the scene's folder"
        raise Unfit(f"is no mesh that can be read: '{text}'", hint)
    return text


def _placed_shape(keys: dict[str, Any]) -> PlacedShape:
    shape = next(keys[kind] for kind in SHAPE_FIELDS if kind in keys)
    place = {key: keys[key] for key in PLACE if key in keys}
    return PlacedShape(shape.kind, shape.sizes, shape.axis, **place)


COLOUR: Field[str] = Converted(Text(), _colour)
APPEARANCE_SHAPES: Field[tuple[PlacedShape, ...]] = List(
    Converted(Record("a shape", {**SHAPE_FIELDS, **PLACE}, dict, choices=(A_SHAPE,)), _placed_shape), None, "shapes"
)
FILE: Field[str] = Converted(Text(), _file)
MESH: Field[MeshFile] = Alternatives(
    (
        Record("a mesh", {"file": FILE, "scale": Number(above=0.0), **PLACE}, MeshFile, required=("file",)),
        Converted(FILE, MeshFile),
    )
)
APPEARANCE: Record[Appearance] = Record(
    "an appearance",
    {"colour": COLOUR, "opacity": Number(minimum=0.05, maximum=1.0), "shapes": APPEARANCE_SHAPES, "mesh": MESH},
    Appearance,
    choices=(OneOf(("shapes", "mesh"), hint="draw the one or the other"),),
)
