"""The `appearance` of a body: how it is drawn. It has no effect on the motion.

    appearance: {colour: "#4477aa", opacity: 0.5}
    appearance: {shapes: [{cylinder: {radius: 0.4, length: 0.1}}, {box: [0.1, 0.1, 1], position: [0, 0, 0.5]}]}
    appearance: {mesh: crank.stl}
    appearance: {mesh: {file: crank.stl, scale: 0.001, position: [0, 0, 0.1]}}

Places of shapes and meshes are from the centre of mass, along the body axes.
"""

from __future__ import annotations

import re
from typing import Any

from mbproj.errors import choose_from
from mbproj.scene.appearance import COLOURS, MESH_FORMATS, Appearance, MeshFile, PlacedShape
from mbproj.scene.fields.choices import Alternatives
from mbproj.scene.fields.containers import OneOf, Record
from mbproj.scene.fields.fields import Converted, Field, List, Text
from mbproj.scene.fields.orientation import ORIENTATION
from mbproj.scene.fields.quantities import POINT, Number
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.solids.shapes import A_SHAPE, SHAPE_FIELDS

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


def _shape(given: dict[str, Any]) -> PlacedShape:
    shape = next(given[kind] for kind in SHAPE_FIELDS if kind in given)
    place = {key: given[key] for key in PLACE if key in given}
    return PlacedShape(shape.kind, shape.sizes, shape.axis, **place)


COLOUR: Field[str] = Converted(Text(), _colour)
SHAPES: Field[tuple[PlacedShape, ...]] = List(
    Converted(Record("a shape", {**SHAPE_FIELDS, **PLACE}, dict, choices=(A_SHAPE,)), _shape), None, "shapes"
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
    {"colour": COLOUR, "opacity": Number(minimum=0.05, maximum=1.0), "shapes": SHAPES, "mesh": MESH},
    Appearance,
    choices=(OneOf(("shapes", "mesh"), hint="draw the one or the other"),),
)
