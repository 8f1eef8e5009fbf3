"""The scene format as a JSON Schema, from the definitions that read it: for editors and for programs that write scenes.

It says less than the reader: units, expressions, names of what there is, and rules on several values are the reader's.
It never says more: a scene that the reader accepts is valid, with its plain values taken as YAML's JSON schema or as
text. Only a name that YAML takes for true, false or null has to be quoted where it is not a key.
"""

from __future__ import annotations

from mbproj.scene.fields.fields import Schema
from mbproj.scene.grammar import SCENE

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def scene_schema() -> Schema:
    """The JSON Schema (draft 2020-12) of a scene, as plain data."""
    about = (
        "A scene of mbproj. A number is in SI units and radians, or a text: an expression, with or without units, "
        "which are products, quotients and powers, as in 3 kg*mm^2, 2 N*s/mm, 25 1/s."
    )
    return {"$schema": DIALECT, "title": "mbproj scene", **SCENE.schema(), "description": about}
