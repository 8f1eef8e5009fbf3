"""The origin of results: the attributes of the file and its /scene group, enough to repeat the run."""

from __future__ import annotations

import json
import os
import platform
from dataclasses import asdict
from datetime import datetime

import h5py
import numpy as np

from mbproj.results.file.checksums import crc32, describe, stamp
from mbproj.results.file.whole import create_text
from mbproj.results.layout import FORMAT, SCHEMA_VERSION
from mbproj.scene.meshes import meshes_of
from mbproj.scene.records import Scene
from mbproj.version import __version__

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
