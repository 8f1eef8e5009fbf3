"""The scene format as a JSON Schema, from the definitions that read it: for editors and for programs that write scenes.

The reader checks more than the schema: units, expressions, references by name, and rules on several values. It accepts
nothing that the schema refuses, whether an editor reads a plain value such as 1e3 as a number or as text. There is one
exception: a name that YAML takes for true, false or null has to be quoted where it is not a key.
"""

from __future__ import annotations

from mbproj.scene.fields.fields import DIALECT, Schema
from mbproj.scene.grammar import SCENE


def scene_schema() -> Schema:
    """The JSON Schema (draft 2020-12) of a scene, as plain data."""
    about = (
        "A scene of mbproj. A number is in SI units and radians, or a text: an expression, with or without units, "
        "which are products, quotients and powers, as in 3 kg*mm^2, 2 N*s/mm, 25 1/s."
    )
    return {"$schema": DIALECT, "title": "mbproj scene", **SCENE.schema(), "description": about}
