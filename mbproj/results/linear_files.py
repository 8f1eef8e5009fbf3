"""A file described by a table of parts: each is a field of a record, with its path, shape, unit and description.

Complex numbers are in two datasets, "<path>_real" and "<path>_imag", which every reader of HDF5 can read.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.results import provenance
from mbproj.results.file.checksums import crc32, create_text, describe, stamp, stamp_attributes
from mbproj.results.file.contents import Contents
from mbproj.results.file.opening import open_file
from mbproj.results.output_files import FileKind, hdf5, replacing
from mbproj.results.provenance import Attribute, root_attributes, write_scene
from mbproj.scene.meshes import TriangleMesh
from mbproj.scene.scene import Scene

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


# --- The file of modes ------------------------------------------------------------------------------------------------
# The pose of the linearisation, and the eigenvalue, shape and energies of each mode.
# A mode moves the bodies from the pose by Re(displacement · exp(λ t)): three shifts of a body's centre of mass in m
# and three components of a small turn in rad, in global axes.


GLOBAL = "global axes"
MODES_LAYOUT = FileLayout(
    "mbproj modes",
    "a file of modes",
    "mbproj modes SCENE",
    (
        RecordField("bodies", "bodies/names", ("n",), "1", "names of the bodies", kind="text"),
        RecordField(
            "position", "bodies/position", ("n", 3), "m", "centre of mass at the pose that is linearised", GLOBAL
        ),
        RecordField(
            "orientation", "bodies/orientation", ("n", 4), "1", "Euler parameters there, scalar first, body to global"
        ),
        RecordField(
            "coordinates", "joints/coordinate_names", ("nc",), "1", "names of the joint coordinates", kind="text"
        ),
        RecordField("coordinate_units", "joints/coordinate_units", ("nc",), "1", "their units, rad or m", kind="text"),
        RecordField(
            "coordinate", "joints/coordinate", ("nc",), "rad, m", "joint coordinates at the pose, turns counted"
        ),
        RecordField("names", "modes/names", ("k",), "1", "what moves most in each mode", kind="text"),
        RecordField("eigenvalue", "modes/eigenvalue", ("k",), "1/s", "λ, one of each conjugate pair", kind="complex"),
        RecordField("frequency", "modes/frequency", ("k",), "Hz", "|Im λ| / 2π"),
        RecordField("damping_ratio", "modes/damping_ratio", ("k",), "1", "-Re λ / |λ|"),
        RecordField(
            "displacement",
            "modes/displacement",
            ("k", "n", 6),
            "m, rad",
            "shift and small turn of each body: it moves by Re(displacement · exp(λ t))",
            GLOBAL,
            "complex",
        ),
        RecordField(
            "coordinate_shape",
            "modes/coordinate",
            ("k", "nc"),
            "rad, m",
            "change of each joint coordinate",
            kind="complex",
        ),
        RecordField("states", "modes/state_names", ("K",), "1", "states of elements", kind="text", later=True),
        RecordField("state_units", "modes/state_units", ("K",), "1", "their units", kind="text", later=True),
        RecordField(
            "state_shape",
            "modes/state",
            ("k", "K"),
            "of each state",
            "change of each state",
            kind="complex",
            later=True,
        ),
        RecordField("state_share", "modes/state_share", ("k", "K"), "1", "the part of each in the mode", later=True),
        RecordField("kinetic_names", "modes/kinetic_names", ("b",), "1", "what has kinetic energy", kind="text"),
        RecordField(
            "kinetic_share", "modes/kinetic_share", ("k", "b"), "1", "share of each in the mode's kinetic energy"
        ),
        RecordField("strain_names", "modes/strain_names", ("e",), "1", "what keeps energy, and gravity", kind="text"),
        RecordField(
            "strain_share", "modes/strain_share", ("k", "e"), "1", "share of each in the mode's potential energy"
        ),
        RecordField(
            "varied", "traces/parameter", ("v",), "1", "the parameter that was varied; none without", kind="text"
        ),
        RecordField("trace_value", "traces/value", ("p",), "1", "its values"),
        RecordField(
            "trace", "traces/eigenvalue", ("p", "j"), "1/s", "λ at each, a column a mode; nan: none", kind="complex"
        ),
    ),
)


@dataclass(frozen=True, eq=False)
class StoredModes:
    """The modes in a file, field by field as in `LAYOUT`: n bodies, nc joint coordinates, k modes, K states of
    elements. `where` it is linearised, at `time` in s; `axes` names the coordinates; `notes` are for the reader;
    `title` is the scene's."""

    bodies: Sequence[str]
    position: Array
    orientation: Array
    coordinates: Sequence[str]
    coordinate_units: Sequence[str]
    coordinate: Array
    names: Sequence[str]
    eigenvalue: Numbers
    frequency: Array
    damping_ratio: Array
    displacement: Numbers
    coordinate_shape: Numbers
    states: Sequence[str]
    state_units: Sequence[str]
    state_shape: Numbers
    state_share: Array
    kinetic_names: Sequence[str]
    kinetic_share: Array
    strain_names: Sequence[str]
    strain_share: Array
    varied: Sequence[str]
    trace_value: Array
    trace: Numbers
    where: str
    time: float
    title: str
    notes: str = ""


def write_modes(path: Path, modes: StoredModes, scene: Scene, *, force: bool = False) -> Path:
    """Write the modes as an HDF5 file, and return its path."""
    attributes: dict[str, Attribute] = {name: getattr(modes, name) for name in ("where", "time", "title", "notes")}
    values = {field.name: getattr(modes, field.name) for field in fields(StoredModes)}
    return write(path, MODES_LAYOUT, values, attributes, scene, force=force)


def read_modes(path: Path) -> StoredModes:
    """Read a file of modes. Raises InputError where the file is no such one, or damaged."""
    values, attributes = read(path, MODES_LAYOUT)
    where, title, notes = (str(attributes.get(name, "")) for name in ("where", "title", "notes"))
    return StoredModes(**values, where=where, time=float(attributes.get("time", 0.0)), title=title, notes=notes)


# --- The files of a linear model --------------------------------------------------------------------------------------
# HDF5 with names and units, NumPy's .npz, MATLAB's .mat.


MODEL_LAYOUT = FileLayout(
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
        ".h5": hdf5(MODEL_LAYOUT.format),
        ".npz": FileKind("an .npz file", _has_mark(b"PK")),
        ".mat": FileKind("a .mat file", _has_mark(b"MATLAB 5.0")),
    }
)


def write_model(path: Path, model: StoredModel, scene: Scene, *, force: bool = False) -> Path:
    """Write the model in the format of the path's ending, and return the path."""
    values: dict[str, Any] = {field.name: getattr(model, field.name) for field in fields(StoredModel)}
    if path.suffix == ".h5":
        attributes = {name: values[name] for name in ("where", "time", "title")}
        return write(path, MODEL_LAYOUT, values, attributes, scene, force=force)
    arrays = {MARK: np.array([1.0]), **{part.name: _plain(values[part.name], part) for part in MODEL_LAYOUT.parts}}
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
    values, attributes = read(path, MODEL_LAYOUT)
    where, title = (str(attributes.get(name, "")) for name in ("where", "title"))
    return StoredModel(**values, where=where, time=float(attributes.get("time", 0.0)), title=title)
