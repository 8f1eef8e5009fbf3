"""The `bodies` block: the field of each key of a body. There are three ways to give its mass and inertia:

    mass, inertia                          moments and products about the centre of mass, body axes
    mass or density, shape: {box: [..]}    one shape of `shapes.SHAPES`, centred on the centre of mass
    shapes: [{box: [..], density: 7850, position: [..], orientation: {..}}, ...]
                                           several, each with its own mass or density

`shapes` are placed in a frame of their own, along the body axes, whose origin need not be the centre of mass. The body
is placed by `position`, the global position of its centre of mass, or by `origin`, that of the frame's origin. Points
in a body's axes (of joints, markers) are always from its centre of mass.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from mbproj.scene.appearance import PlacedShape
from mbproj.scene.fields import inertia, rotations
from mbproj.scene.fields.alternatives import Alternatives
from mbproj.scene.fields.checks import inertia_of
from mbproj.scene.fields.containers import Complaint, OneOf, Record, Rule
from mbproj.scene.fields.fields import Converted, Field, List
from mbproj.scene.fields.orientation import ORIENTATION
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.vectors import POINT, rows, vector
from mbproj.scene.records import Body, Matrix, Quaternion, Vector
from mbproj.scene.solids.appearance import APPEARANCE
from mbproj.scene.solids.composed import SolidBody, SolidPart, alone, mass_of, together
from mbproj.scene.solids.shapes import A_SHAPE, SHAPE_FIELDS, Shape

INERTIA: Field[Matrix] = Converted(
    Alternatives(
        (
            Converted(vector("kg*m^2"), inertia.from_principal),
            Converted(List(Number("kg*m^2"), 6), inertia.from_elements),
            rows("kg*m^2"),
        )
    ),
    inertia_of,
)

DENSITY = Number("kg/m^3", above=0.0)


def has_volume(shape: Shape, density: float) -> Iterator[Complaint]:
    """A check that a shape with a density has a volume."""
    if shape.volume is None:
        yield Complaint(("density",), f"a {shape.kind} has no volume, so no density", "give its mass")


SHAPE: Record[Shape] = Record("a shape", SHAPE_FIELDS, lambda **given: next(iter(given.values())), choices=(A_SHAPE,))


def _part(given: dict[str, Any]) -> SolidPart:
    shape = next(given[kind] for kind in SHAPE_FIELDS if kind in given)
    place = {key: given[key] for key in ("position", "orientation") if key in given}
    return SolidPart(shape, mass_of(shape, given.get("mass"), given.get("density")), **place)


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


def _solid(given: dict[str, Any]) -> SolidBody:
    """The mass, centre and inertia of a body, however they are written."""
    if "shapes" in given:
        solid: SolidBody = given["shapes"]
        return solid
    if "shape" in given:
        shape = given["shape"]
        return alone(SolidPart(shape, mass_of(shape, given.get("mass"), given.get("density"))))
    return SolidBody(given["mass"], (0.0, 0.0, 0.0), given["inertia"])


def _body(given: dict[str, Any]) -> Body:
    solid = _solid(given)
    kept = ("orientation", "velocity", "angular_velocity", "start", "appearance")
    rest = {key: given[key] for key in kept if key in given}
    position = given.get("position")
    if position is None:
        position = _placed(given["origin"], given.get("orientation", Body.orientation), solid.centre)
    shapes = tuple(_drawn_shape(part, solid.centre) for part in solid.parts)
    return Body(given["name"], solid.mass, solid.inertia, position, shapes=shapes, **rest)


def _drawn_shape(part: SolidPart, centre: Vector) -> PlacedShape:
    """The shape that is drawn for a part, placed from the body's centre of mass at `centre`."""
    x, y, z = (at - middle for at, middle in zip(part.position, centre, strict=True))
    return PlacedShape(part.shape.kind, part.shape.sizes, part.shape.axis, (x, y, z), part.orientation)


def _placed(origin: Vector, orientation: Quaternion, point: Vector) -> Vector:
    """The global position of a point of a frame with this origin and orientation."""
    x, y, z = (
        start + sum(a * b for a, b in zip(row, point, strict=True))
        for start, row in zip(origin, rotations.to_matrix(orientation), strict=True)
    )
    return (x, y, z)


def _start(position: Vector, orientation: Quaternion = Body.orientation) -> tuple[Vector, Quaternion]:
    return position, orientation


BODY: Field[Body] = Converted(
    Record(
        "a body",
        {
            "mass": Number("kg", minimum=0.0),
            "density": DENSITY,
            "inertia": INERTIA,
            "shape": SHAPE,
            "shapes": SOLID,
            "position": POINT,
            "origin": POINT,
            "orientation": ORIENTATION,
            "velocity": vector("m/s"),
            "angular_velocity": vector("rad/s"),
            "start": Record(
                "a pose at the start", {"position": POINT, "orientation": ORIENTATION}, _start, ("position",)
            ),
            "appearance": APPEARANCE,
        },
        dict,
        checks=(Rule(("shape", "density"), has_volume),),
        choices=(
            OneOf(("mass", "density", "shapes"), needed=True, hint="keep one of them ('shapes' have their own)"),
            OneOf(("inertia", "shape", "shapes"), needed=True),
            OneOf(("position", "origin"), needed=True),
            OneOf(("density", "inertia"), hint="a density needs a 'shape'"),
            OneOf(("origin", "inertia"), hint="the centre of mass is at 'position'; 'origin' is that of 'shapes'"),
            OneOf(("origin", "shape"), hint="the centre of mass is at 'position'; 'origin' is that of 'shapes'"),
        ),
        named=True,
    ),
    _body,
)
