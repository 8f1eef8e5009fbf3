"""The /scene group of a file: the text from which the scene can be read again, and the meshes of its bodies."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.results.file.contents import Contents
from mbproj.scene.meshes import MOST_TRIANGLES, TriangleMesh

MESHES = "scene/meshes"


def text(contents: Contents, name: str) -> str:
    """A text of the group."""
    return contents.text(f"scene/{name}")


def as_json(contents: Contents, name: str) -> Any:
    """The value of a JSON text of the group."""
    try:
        return json.loads(text(contents, name))
    except (ValueError, RecursionError) as error:
        raise contents.damaged(f"scene/{name}", "is not JSON") from error


def path(contents: Contents) -> Path | None:
    """The path of the scene file; None for text from elsewhere."""
    found = text(contents, "path")
    if "\0" in found:
        raise contents.damaged("scene/path", "is not a path")
    return Path(found) if found else None


def overrides(contents: Contents) -> dict[str, str]:
    """The parameters that --set changed."""
    values = as_json(contents, "overrides")
    if not (isinstance(values, dict) and all(isinstance(value, str) for value in values.values())):
        raise contents.damaged("scene/overrides", "is not text by parameter")
    return values


def meshes(contents: Contents) -> dict[str, TriangleMesh]:
    """The meshes by body; {} in files of older programs."""
    if not contents.has(MESHES):
        return {}
    found: dict[str, TriangleMesh] = {}
    triangles = 0
    for number, body in enumerate(contents.texts(f"{MESHES}/bodies")):
        name = f"{MESHES}/{number}"
        triangles += contents.rows(f"{name}/triangles", (3,), np.int64)
        if triangles > MOST_TRIANGLES:
            raise contents.damaged(MESHES, f"has more than {MOST_TRIANGLES} triangles")
        corners = contents.array(f"{name}/triangles", (None, 3), np.int64)
        vertices = contents.array(f"{name}/vertices", (None, 3))
        if not np.isfinite(vertices).all() or not ((corners >= 0) & (corners < len(vertices))).all():
            raise contents.damaged(name, "is no mesh")
        found[body] = TriangleMesh(vertices, corners)
    return found
