"""The file of modes: the pose of the linearisation, and the eigenvalue, shape and energies of each mode.

A mode moves the bodies from the pose by Re(displacement · exp(λ t)): three shifts of a body's centre of mass in m and
three components of a small turn in rad, in global axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from mbproj.arrays import Array, Numbers
from mbproj.dataclass import dataclass
from mbproj.results.linear.parts import FileLayout, RecordField, read, write
from mbproj.results.provenance import Attribute
from mbproj.scene.read import Scene

GLOBAL = "global axes"
LAYOUT = FileLayout(
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
    return write(path, LAYOUT, values, attributes, scene, force=force)


def read_modes(path: Path) -> StoredModes:
    """Read a file of modes. Raises InputError where the file is no such one, or damaged."""
    values, attributes = read(path, LAYOUT)
    where, title, notes = (str(attributes.get(name, "")) for name in ("where", "title", "notes"))
    return StoredModes(**values, where=where, time=float(attributes.get("time", 0.0)), title=title, notes=notes)
