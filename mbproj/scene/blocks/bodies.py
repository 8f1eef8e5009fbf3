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

from typing import Any

from mbproj.base.registry import calling
from mbproj.scene.fields import rotations
from mbproj.scene.fields.fields import Alternatives, Converted, Deferred, Field, List, OneOf, Record, Rule
from mbproj.scene.fields.quantities import POINT, Number, inertia_of, rows, vector
from mbproj.scene.records import Body, Matrix, Quaternion, Vector

INERTIA: Field[Matrix] = Converted(
    Alternatives(
        (
            Converted(vector("kg*m^2"), rotations.from_principal),
            Converted(List(Number("kg*m^2"), 6), rotations.from_elements),
            rows("kg*m^2"),
        )
    ),
    inertia_of,
)
ORIENTATION = Deferred[Quaternion]("mbproj.scene.fields.placing:ORIENTATION")


def _body(keys: dict[str, Any]) -> Body:
    optional = ("orientation", "velocity", "angular_velocity", "start", "appearance")
    rest = {key: keys[key] for key in optional if key in keys}
    mass: Any = keys.get("mass")
    tensor, centre = keys.get("inertia"), (0.0, 0.0, 0.0)
    if tensor is None:
        from mbproj.scene.blocks.solids import drawn_shapes, solid_of

        solid = solid_of(keys)
        mass, tensor, centre = solid.mass, solid.inertia, solid.centre
        rest["shapes"] = drawn_shapes(solid)
    position = keys.get("position")
    if position is None:
        position = _placed(keys["origin"], keys.get("orientation", Body.orientation), centre)
    return Body(keys["name"], mass, tensor, position, **rest)


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
            "density": Number("kg/m^3", above=0.0),
            "inertia": INERTIA,
            "shape": Deferred("mbproj.scene.blocks.solids:SHAPE"),
            "shapes": Deferred("mbproj.scene.blocks.solids:SOLID"),
            "position": POINT,
            "origin": POINT,
            "orientation": ORIENTATION,
            "velocity": vector("m/s"),
            "angular_velocity": vector("rad/s"),
            "start": Record(
                "a pose at the start", {"position": POINT, "orientation": ORIENTATION}, _start, ("position",)
            ),
            "appearance": Deferred("mbproj.scene.blocks.solids:APPEARANCE"),
        },
        dict,
        checks=(Rule(("shape", "density"), calling("mbproj.scene.blocks.solids:has_volume")),),
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
