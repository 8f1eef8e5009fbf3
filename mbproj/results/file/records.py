"""Groups of records with one dataset for each field: empty at the start of a run, and filled at its end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import h5py
import numpy as np

from mbproj.results.file.checksums import NOT_YET, crc32, describe, stamp

#: The most bytes of a text; longer ones are cut.
LONGEST = 200
TEXT = h5py.string_dtype("utf-8", LONGEST)
#: The HDF5 type of an entry, its unit and its description, by field.
Fields: TypeAlias = Mapping[str, tuple[Any, str, str]]


def create_records(file: h5py.File, group: str, fields: Fields) -> None:
    """Create the group without records: the file must have its whole structure from the start."""
    for name, (dtype, unit, description) in fields.items():
        data = file.create_dataset(f"{group}/{name}", (0,), dtype, maxshape=(None,), chunks=(64,), fletcher32=True)
        describe(data, {"units": unit, "description": description} if unit else {"description": description})
        stamp(data, NOT_YET)


def room_for_records(count: int, fields: Fields) -> int:
    """The most bytes that `count` records add to the file: those of the texts, with a margin for the numbers."""
    return (count + 64) * sum(LONGEST + 64 for dtype, _, _ in fields.values() if dtype is TEXT)


def write_records(file: h5py.File, group: str, fields: Fields, records: Sequence[Any]) -> None:
    """Write the records into the group: each field from the attribute of that name."""
    for name, (dtype, _, _) in fields.items():
        values = [getattr(record, name) for record in records]
        data = np.array([_cut(value) for value in values] if dtype is TEXT else values, dtype=dtype)
        dataset = file[group][name]
        dataset.resize(data.shape)
        if data.size:
            dataset[...] = data
        stamp(dataset, crc32(data))


def _cut(text: str) -> bytes:
    """The text in UTF-8, cut to the characters that fit as a whole."""
    return text.encode()[:LONGEST].decode(errors="ignore").encode()
