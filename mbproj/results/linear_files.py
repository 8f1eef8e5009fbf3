"""A file described by a table of parts: each is a field of a record, with its path, shape, unit and description.

Complex numbers are in two datasets, "<path>_real" and "<path>_imag", which every reader of HDF5 can read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.output_files import hdf5, replacing
from mbproj.results import provenance
from mbproj.results.file.checksums import crc32, describe, stamp, stamp_attributes
from mbproj.results.file.contents import Contents
from mbproj.results.file.opening import open_file
from mbproj.results.file.whole import create_text
from mbproj.results.provenance import Attribute, root_attributes, write_scene
from mbproj.scene.meshes import TriangleMesh
from mbproj.scene.read import Scene

VERSION = 1


@dataclass(frozen=True)
class RecordField:
    """The field `name` of a record, at `path` in the file. `shape` has numbers, or symbols, each of which means one
    number throughout the file. The `kind` "text" is a list of texts. A `later` field is missing in older files, and
    then empty or zero."""

    name: str
    path: str
    shape: tuple[str | int, ...]
    unit: str
    description: str
    frame: str | None = None
    kind: str = "real"
    later: bool = False


@dataclass(frozen=True)
class FileLayout:
    """The layout of a file: its `format`, `what` it is called in messages, the command that writes it, its parts."""

    format: str
    what: str
    writer: str
    parts: tuple[RecordField, ...]


@dataclass(frozen=True)
class StoredScene:
    """The parts from which a scene can be read again: its text, the path of its file, the parameters that --set
    changed, and the meshes of its bodies."""

    text: str
    path: Path | None
    overrides: Mapping[str, str]
    meshes: Mapping[str, TriangleMesh]


def write(
    path: Path,
    layout: FileLayout,
    values: Mapping[str, Any],
    attributes: Mapping[str, Attribute],
    scene: Scene,
    *,
    force: bool = False,
) -> Path:
    """Write the parts, the attributes and the scene, and return `path`; a file of the same format is replaced."""
    with (
        replacing(path, hdf5(layout.format), force=force) as draft,
        h5py.File(draft, "w", libver=("v110",) * 2) as file,
    ):
        file.attrs.update({**root_attributes(), "format": layout.format, "schema_version": VERSION})
        file.attrs.update(
            {"status": "complete", **{key: value for key, value in attributes.items() if value is not None}}
        )
        write_scene(file, scene)
        for part in layout.parts:
            _write_part(file, part, values[part.name])
        stamp_attributes(file)
    return path


def _write_part(file: h5py.File, part: RecordField, value: Any) -> None:
    if part.kind == "text":
        create_text(file, part.path, list(value), part.description)
        return
    numbers = np.asarray(value)
    halves = {"": numbers} if part.kind == "real" else {"_real": numbers.real, "_imag": numbers.imag}
    for ending, half in halves.items():
        data = np.ascontiguousarray(half, dtype="f8")
        created = file.create_dataset(part.path + ending, data=data)
        stamp(created, crc32(data))
        frame = {"frame": part.frame} if part.frame else {}
        describe(created, {"units": part.unit, "description": part.description, **frame})


def read(path: Path, layout: FileLayout) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read the parts, by name, and the attributes. Raises InputError where the file is of another format, damaged, or
    has names that are not valid."""
    if not path.exists():
        raise InputError(Problem(f"there is no file '{path}'", hint=f"write it with: {layout.writer} -o {path}"))
    with open_file(path, lambda contents: _read(contents, layout), layout.format) as contents:
        return _read(contents, layout), dict(contents.attributes())


def scene_in(path: Path) -> StoredScene:
    """Read the scene that the file belongs to."""
    with open_file(path) as contents:
        path_then, overrides = provenance.path(contents), provenance.overrides(contents)
        return StoredScene(provenance.text(contents, "text"), path_then, overrides, provenance.meshes(contents))


def scene_of_modes(path: Path, bodies: Sequence[str]) -> tuple[Scene, Mapping[str, TriangleMesh]]:
    """The scene in the file of modes at `path`, and its meshes. Raises InputError where its bodies are not `bodies`."""
    recorded = scene_in(path)
    again = provenance.scene_again(recorded.text, recorded.path, recorded.overrides, bodies, path)
    return again, recorded.meshes


def _read(contents: Contents, layout: FileLayout) -> dict[str, Any]:
    attributes = contents.attributes()
    if attributes.get("format") != layout.format:
        hint = f"write it with: {layout.writer}"
        raise InputError(Problem(f"'{contents.path}' is not {layout.what} of mbproj", hint=hint))
    if attributes.get("schema_version") != VERSION:
        said = (
            f"'{contents.path}' has schema version {attributes.get('schema_version')}, and this mbproj reads {VERSION}"
        )
        raise InputError(Problem(said, hint=f"write it again with: {layout.writer}"))
    sizes: dict[str, int] = {}
    return {part.name: _read_part(contents, part, sizes) for part in layout.parts}


def _read_part(contents: Contents, part: RecordField, sizes: dict[str, int]) -> Any:
    if part.later and not contents.has(part.path + "_real" * (part.kind == "complex")):
        return () if part.kind == "text" else np.zeros([_size(axis, sizes) for axis in part.shape])
    if part.kind == "text":
        texts = contents.texts(part.path)
        _check(contents, part, (len(texts),), sizes)
        for text in texts:
            if not text.isprintable():
                raise contents.damaged(part.path, f"has {text!r}, which is no name")
        return texts
    wanted = tuple(sizes.get(axis) if isinstance(axis, str) else axis for axis in part.shape)
    if part.kind == "real":
        value: npt.NDArray[Any] = contents.array(part.path, wanted)
    else:
        value = contents.array(f"{part.path}_real", wanted) + 1j * contents.array(f"{part.path}_imag", wanted)
    _check(contents, part, value.shape, sizes)
    return value


def _size(axis: str | int, sizes: Mapping[str, int]) -> int:
    return sizes.get(axis, 0) if isinstance(axis, str) else axis


def _check(contents: Contents, part: RecordField, shape: Sequence[int], sizes: dict[str, int]) -> None:
    """Raises InputError where a symbol of the shape stands for another number than before in the file."""
    for axis, length in zip(part.shape, shape, strict=True):
        if isinstance(axis, str) and sizes.setdefault(axis, length) != length:
            raise contents.damaged(part.path, f"has {length} entries where {sizes[axis]} are due")
