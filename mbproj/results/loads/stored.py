"""The /summary/loads group of a results file: the largest loads of the run, one row each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from mbproj.results.events import Happening
from mbproj.results.file.contents import Contents
from mbproj.results.file.whole import TEXT, create_records, room_for_records, write_records
from mbproj.results.loads.largest import Load, Recorded, loads, open_directions

GROUP = "summary/loads"
OF_CYCLE = "rad or m"
#: The HDF5 type of an entry, its unit and its description, by field of a `Load`.
LAYOUT = {
    "kind": (TEXT, "", "of what: joint, motion, force, stop, friction"),
    "name": (TEXT, "", "its name"),
    "quantity": (TEXT, "", "reaction_force, reaction_torque, force or power"),
    "unit": (TEXT, "", "unit of largest, uncertainty, mean and rms"),
    "largest": ("f8", "per row in unit", "largest magnitude, with its sign where it has one"),
    "uncertainty": ("f8", "per row in unit", "how far it may be off for want of samples"),
    "time": ("f8", "s", "when"),
    "place": ("f8", OF_CYCLE, "coordinate of the first motion there, modulo a turn; nan without motions"),
    "mean": ("f8", "per row in unit", "mean over time, of magnitudes where it is a vector"),
    "rms": ("f8", "per row in unit", "root of the mean square over time"),
    "put_in": ("f8", "J", "work where the power is positive; nan of what is no power"),
    "taken_out": ("f8", "J", "work where the power is negative, as a positive number"),
    "unique": ("i8", "1", "1; 0 where redundant joints share the reaction at will"),
}


def create(file: h5py.File) -> None:
    """Create the group without rows, which are written at the end of the run."""
    create_records(file, GROUP, LAYOUT)


def room(names: Mapping[str, Sequence[str]]) -> int:
    """The most bytes that `write` adds to the file for a run with these names by kind: two rows a name."""
    return room_for_records(2 * sum(map(len, names.values())), LAYOUT)


def recorded_loads(
    targets: Mapping[str, h5py.Dataset],
    names: Mapping[str, Sequence[str]],
    constants: Mapping[str, npt.NDArray[Any]],
    events: Sequence[Happening],
) -> list[Load]:
    """The largest loads of a run, from samples that are read back from its file: there may be more than memory
    holds."""
    recorded = Recorded(
        names,
        lambda path, columns: targets[path][:, columns],
        targets["time"][:],
        np.array([event.time for event in events]),
        lambda path: open_directions(constants.get, path),
    )
    return loads(recorded, recorded.cycle())


def write(file: h5py.File, loads: Sequence[Load]) -> None:
    """Write the loads into the group."""
    write_records(file, GROUP, LAYOUT, loads)


def read(contents: Contents) -> tuple[Load, ...]:
    """Read the loads; () where the file has no such group."""
    if not contents.has(GROUP):
        return ()
    texts = [contents.texts(f"{GROUP}/{name}") for name, (dtype, _, _) in LAYOUT.items() if dtype is TEXT]
    shape = (len(texts[0]),)
    if any(len(column) != shape[0] for column in texts):
        raise contents.damaged(GROUP, "does not fit together")
    plain = [name for name, (dtype, _, _) in LAYOUT.items() if dtype == "f8"]
    numbers = [contents.array(f"{GROUP}/{name}", shape).tolist() for name in plain]
    unique = contents.array(f"{GROUP}/unique", shape, np.int64).astype(bool).tolist()
    return tuple(Load(*row) for row in zip(*texts, *numbers, unique, strict=True))
