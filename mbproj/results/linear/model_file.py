"""The files of a linear model: HDF5 with names and units, NumPy's .npz, MATLAB's .mat."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.output_files import FileKind, hdf5, replacing
from mbproj.results.linear.parts import FileLayout, RecordField, read, write
from mbproj.scene.read import Scene

LAYOUT = FileLayout(
    "mbproj linear model",
    "a linear model",
    "mbproj linearize SCENE",
    (
        RecordField("A", "model/A", ("x", "x"), "by its states", "x' = A x + B u"),
        RecordField("B", "model/B", ("x", "u"), "by its states and inputs", "x' = A x + B u"),
        RecordField("C", "model/C", ("y", "x"), "by its outputs and states", "y = C x + D u"),
        RecordField("D", "model/D", ("y", "u"), "by its outputs and inputs", "y = C x + D u"),
        RecordField("states", "model/states", ("x",), "1", "names of the states", kind="text"),
        RecordField("state_units", "model/state_units", ("x",), "1", "their units", kind="text"),
        RecordField("inputs", "model/inputs", ("u",), "1", "names of the inputs", kind="text"),
        RecordField("input_units", "model/input_units", ("u",), "1", "their units", kind="text"),
        RecordField("outputs", "model/outputs", ("y",), "1", "names of the outputs", kind="text"),
        RecordField("output_units", "model/output_units", ("y",), "1", "their units", kind="text"),
    ),
)
#: A member of .npz and .mat files, by which mbproj recognises those that it wrote.
MARK = "mbproj_linear_model"


@dataclass(frozen=True, eq=False)
class StoredModel:
    """A linear model: its matrices, and the names and units of its states, inputs and outputs. `where` it is
    linearised, at `time` in s; `title` is the scene's."""

    A: Array
    B: Array
    C: Array
    D: Array
    states: Sequence[str]
    state_units: Sequence[str]
    inputs: Sequence[str]
    input_units: Sequence[str]
    outputs: Sequence[str]
    output_units: Sequence[str]
    where: str
    time: float
    title: str


def _has_mark(magic: bytes) -> Callable[[Path], bool]:
    def wrote(path: Path) -> bool:
        with path.open("rb") as file:
            head = file.read(4096)
        return head.startswith(magic) and MARK.encode() in head

    return wrote


#: The kind of file by its ending.
KINDS: Mapping[str, FileKind] = MappingProxyType(
    {
        ".h5": hdf5(LAYOUT.format),
        ".npz": FileKind("an .npz file", _has_mark(b"PK")),
        ".mat": FileKind("a .mat file", _has_mark(b"MATLAB 5.0")),
    }
)


def write_model(path: Path, model: StoredModel, scene: Scene, *, force: bool = False) -> Path:
    """Write the model in the format of the path's ending, and return the path."""
    values: dict[str, Any] = {field.name: getattr(model, field.name) for field in fields(StoredModel)}
    if path.suffix == ".h5":
        attributes = {name: values[name] for name in ("where", "time", "title")}
        return write(path, LAYOUT, values, attributes, scene, force=force)
    arrays = {MARK: np.array([1.0]), **{part.name: _plain(values[part.name], part) for part in LAYOUT.parts}}
    with replacing(path, KINDS[path.suffix], force=force) as draft, draft.open("wb") as file:
        if path.suffix == ".npz":
            np.savez(file, **arrays)
        else:
            from scipy.io import savemat

            savemat(file, arrays)
    return path


def _plain(value: Any, part: RecordField) -> Any:
    return np.array(list(value), dtype=np.str_) if part.kind == "text" else np.asarray(value)


def read_model(path: Path) -> StoredModel:
    """Read a linear model from an HDF5 file. Raises InputError where the file is no such one, or damaged."""
    values, attributes = read(path, LAYOUT)
    where, title = (str(attributes.get(name, "")) for name in ("where", "title"))
    return StoredModel(**values, where=where, time=float(attributes.get("time", 0.0)), title=title)
