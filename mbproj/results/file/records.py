"""Groups that hold records, a dataset a field: they are empty at the start of a run and filled at its end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import h5py
import numpy as np

from mbproj.results.file.checksums import NOT_YET, crc32, describe, stamp

#: Bytes of the longest text that is kept.
LONGEST = 200
TEXT = h5py.string_dtype("utf-8", LONGEST)
#: By field: what an entry is in HDF5, its unit, what it is.
Fields: TypeAlias = Mapping[str, tuple[Any, str, str]]


def create_records(file: h5py.File, group: str, fields: Fields) -> None:
    """The group without records: the file's structure must be there from the start."""
    for name, (dtype, unit, description) in fields.items():
        data = file.create_dataset(f"{group}/{name}", (0,), dtype, maxshape=(None,), chunks=(64,), fletcher32=True)
        describe(data, {"units": unit, "description": description} if unit else {"description": description})
        stamp(data, NOT_YET)


def room_for_records(count: int, fields: Fields) -> int:
    """What writing so many records adds to the file at most, in bytes: its texts, with room to spare
    for the numbers."""
    return (count + 64) * sum(LONGEST + 64 for dtype, _, _ in fields.values() if dtype is TEXT)


def write_records(file: h5py.File, group: str, fields: Fields, records: Sequence[Any]) -> None:
    """Fills the group with the attributes of these names."""
    for name, (dtype, _, _) in fields.items():
        values = [getattr(record, name) for record in records]
        data = np.array([_cut(value) for value in values] if dtype is TEXT else values, dtype=dtype)
        dataset = file[group][name]
        dataset.resize(data.shape)
        if data.size:
            dataset[...] = data
        stamp(dataset, crc32(data))


def _cut(text: str) -> bytes:
    """As much of the text as fits, no character in parts."""
    return text.encode()[:LONGEST].decode(errors="ignore").encode()
