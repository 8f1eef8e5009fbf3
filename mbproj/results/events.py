"""The /events group of a results file: the times at which steps ended for an event, and what the event belongs to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import h5py
import numpy as np

from mbproj.base.arrays import Array
from mbproj.results.file.checksums import TEXT, create_records, room_for_records, write_records
from mbproj.results.file.contents import Contents

GROUP = "events"
#: The HDF5 type of an entry, its unit and its description, by dataset.
LAYOUT = {
    "time": ("f8", "s", "when"),
    "name": (TEXT, "", "whose: a force, a motion, the scene's break_times, or the integrator's"),
    "kind": (TEXT, "", "what: a jump, a kink, one of an operation, an end of a narrow feature, asked for, a method"),
    "impulse": ("f8", "N s or N m s", "that a stop gave in an impact; 0 of other events"),
    "energy": ("f8", "J", "that was lost in the impact at that stop"),
    "direction": ("i8", "1", "1 where what it depends on rises, -1 where it falls, 0 for events in time"),
}


class Happening(Protocol):
    """An event with the attributes that are recorded."""

    @property
    def time(self) -> float: ...
    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def direction(self) -> int: ...
    @property
    def impulse(self) -> float: ...
    @property
    def energy(self) -> float: ...


class RecordedEvent(NamedTuple):
    """One event; `direction` is 0 for an event at a given time. An impact has an impulse in N s or N m s, and a lost
    energy in J."""

    time: float
    name: str
    kind: str
    direction: int = 0
    impulse: float = 0.0
    energy: float = 0.0


def create(file: h5py.File) -> None:
    """Create the group without events, which are written at the end of the run."""
    create_records(file, GROUP, LAYOUT)


def room(events: Sequence[Happening]) -> int:
    """The most bytes that `write` adds to the file."""
    return room_for_records(len(events), LAYOUT)


def write(file: h5py.File, events: Sequence[Happening]) -> None:
    """Write the events into the group."""
    write_records(file, GROUP, LAYOUT, events)


def read(contents: Contents) -> tuple[RecordedEvent, ...]:
    """Read the events; () where the file has no such group."""
    if not contents.has(GROUP):
        return ()
    names, kinds = (contents.texts(f"{GROUP}/{name}") for name in ("name", "kind"))
    count = len(names)
    times = contents.array(f"{GROUP}/time", (count,))
    directions = contents.array(f"{GROUP}/direction", (count,), np.int64)
    numbers = [_numbers(contents, name, count) for name in ("impulse", "energy")]
    if len(kinds) != count or not np.isfinite([times, *numbers]).all() or not np.isin(directions, (-1, 0, 1)).all():
        raise contents.damaged(GROUP, "does not fit together")
    parts = (times.tolist(), names, kinds, directions.tolist(), *(each.tolist() for each in numbers))
    return tuple(map(RecordedEvent, *parts))


def _numbers(contents: Contents, name: str, count: int) -> Array:
    """The numbers of a dataset (count,); zeros where an older program wrote the file without it."""
    path = f"{GROUP}/{name}"
    return contents.array(path, (count,)) if contents.has(path) else np.zeros(count)
