"""The origin of results: the attributes of the file and its /scene group, enough to repeat the run.

Settings are read by the fields of a scene's `simulation` block, so settings are refused that no scene can have.
"""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from mbproj.base.errors import InputError, Place, Problem
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.base.version import __version__
from mbproj.results.file.checksums import crc32, create_text, describe, stamp
from mbproj.results.file.contents import Contents
from mbproj.results.layout import FORMAT, SCHEMA_VERSION
from mbproj.scene.fields.reading import Reading
from mbproj.scene.grammar import SIMULATION
from mbproj.scene.scene import Scene, read_scene_text
from mbproj.scene.text.nodes import MappingNode, Node, from_value

if TYPE_CHECKING:
    from mbproj.scene.meshes import TriangleMesh

#: The types of an attribute of the file.
Attribute = str | int | float | bool | None


def root_attributes() -> dict[str, Attribute]:
    """The attributes that a file has from its start."""
    return {
        "format": FORMAT,
        "schema_version": SCHEMA_VERSION,
        "status": "running",
        "date": datetime.now().astimezone().isoformat(timespec="seconds"),
        "host": platform.node(),
        "pid": os.getpid(),
        "mbproj_version": __version__,
        "numpy_version": np.__version__,
        "h5py_version": h5py.__version__,
    }


def write_scene(file: h5py.File, scene: Scene) -> None:
    """Write the /scene group: text, path, title, gravity, overrides and complete settings (the last two as JSON), and
    the meshes of its bodies. Raises InputError where a mesh cannot be read."""
    group = file.create_group("scene")
    texts = {
        "text": (scene.text, "the scene file as read (YAML)"),
        "path": ("" if scene.path is None else str(scene.path), "path of the scene file, if it is one"),
        "title": (scene.title, "title of the scene"),
        "settings": (json.dumps(asdict(scene.settings)), "settings of the run, defaults resolved (JSON)"),
        "overrides": (json.dumps(dict(scene.overrides)), "parameters changed by --set (JSON)"),
    }
    for name, (text, description) in texts.items():
        create_text(group, name, text, description)
    _write_meshes(group, scene)
    values = np.array(scene.gravity, dtype=float)
    gravity = group.create_dataset("gravity", data=values)
    stamp(gravity, crc32(values))
    describe(gravity, {"units": "m/s^2", "description": "acceleration of gravity", "frame": "global axes"})


def _write_meshes(scene_group: h5py.Group, scene: Scene) -> None:
    """Write the meshes of bodies, in body axes, so that the file shows them without their own files."""
    if not any(body.appearance is not None and body.appearance.mesh is not None for body in scene.bodies):
        return
    from mbproj.scene.meshes import meshes_of

    meshes = meshes_of(scene)
    if not meshes:
        return
    group = scene_group.create_group("meshes")
    create_text(group, "bodies", list(meshes), "bodies that are drawn as meshes; each has a group by its number")
    for number, mesh in enumerate(meshes.values()):
        parts = {
            "vertices": (mesh.vertices, "m", "corners, from the centre of mass in body axes"),
            "triangles": (mesh.triangles.astype(np.int64), "1", "three corners each, counter-clockwise from outside"),
        }
        for name, (values, unit, description) in parts.items():
            dataset = group.create_dataset(f"{number}/{name}", data=values)
            stamp(dataset, crc32(values))
            describe(dataset, {"units": unit, "description": description})


PLACE = Place("settings")


class UnfitSettings(ValueError):
    """The settings are such as no scene can have; the message says which and why."""


def settings_from(values: Any) -> Settings:
    """The Settings from `values`, which `dataclasses.asdict` made of them, and which JSON wrote and read."""
    reading = Reading()
    if isinstance(values, Mapping) and values.get("break_times") == []:
        values = {key: value for key, value in values.items() if key != "break_times"}  # a scene names one or none
    node = _node(values)
    read = SIMULATION.read(node, ("simulation",), reading) if isinstance(node, MappingNode) else None
    if read is None or reading.problems:
        raise UnfitSettings(reading.problems[0].message if reading.problems else "it is not a mapping of keys")
    return Settings(**{**read, "projection": ProjectionSettings(**read.get("projection", {}))})


def _node(value: Any) -> Node:
    """A value of JSON as a node of a scene; entries that are None are left out."""
    if not isinstance(value, Mapping):
        return from_value(value, PLACE)
    parts = {key: _node(part) for key, part in value.items() if part is not None}
    return MappingNode(parts, dict.fromkeys(parts, PLACE), PLACE)


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
    written = text(contents, "path")
    if "\0" in written:
        raise contents.damaged("scene/path", "is not a path")
    return Path(written) if written else None


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
    from mbproj.scene.meshes import MOST_TRIANGLES, TriangleMesh

    by_body: dict[str, TriangleMesh] = {}
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
        by_body[body] = TriangleMesh(vertices, corners)
    return by_body


def scene_again(
    text: str, stood: Path | None, overrides: Mapping[str, str], bodies: Sequence[str], path: Path
) -> Scene:
    """The scene of the file at `path`, read again. Raises InputError where its bodies are not `bodies`."""
    scene = read_scene_text(text, str(stood or path), overrides)
    if tuple(body.name for body in scene.bodies) != tuple(bodies):
        message = f"the bodies of '{path}' are not those of the scene in it"
        raise InputError(Problem(message, hint="repeat the run: the file is damaged, or was put together by hand"))
    return scene
