"""Writes arrays that do not grow, each at once: numbers, texts, and groups of records with one dataset for each field.

Records are empty at the start of a run, and filled at its end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5d, h5p, h5s, h5t

from mbproj.results.file.checksums import NOT_YET, crc32, describe, stamp

#: The property by which a dataset is created together with the groups in its path.
GROUPS_TOO = h5p.create(h5p.LINK_CREATE)
GROUPS_TOO.set_create_intermediate_group(True)


def as_text(name: str) -> str:
    """A text for HDF5, which may have a path in it: bytes of a file name that are no text are written as \\udcff."""
    return name.encode(errors="backslashreplace").decode()


def create_whole(group: h5py.Group, path: str, values: npt.NDArray[Any]) -> h5py.Dataset:
    """Write an array of fixed size."""
    kind = h5t.py_create(values.dtype, logical=True)
    properties = h5p.create(h5p.DATASET_CREATE)
    properties.set_obj_track_times(False)
    space = h5s.create_simple(values.shape) if values.shape else h5s.create(h5s.SCALAR)
    created = h5d.create(group.id, path.encode(), kind, space, properties, GROUPS_TOO)
    if values.size:
        created.write(h5s.ALL, h5s.ALL, values, mtype=kind)
    return h5py.Dataset(created)


def create_text(group: h5py.Group, path: str, texts: str | Sequence[str], description: str) -> None:
    """Write a dataset of UTF-8 strings of one length, which are stored in place; others would need HDF5's heap."""
    listed = [texts] if isinstance(texts, str) else list(texts)
    encoded = [as_text(text).encode() for text in listed]
    kind = h5py.string_dtype("utf-8", max([1, *map(len, encoded)]))
    data = np.array(encoded, dtype=kind)
    dataset = create_whole(group, path, data.reshape(() if isinstance(texts, str) else (-1,)))
    describe(dataset, {"description": description, "_Encoding": "utf-8"})
    stamp(dataset, crc32(data))


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
        data = np.array([_cut_bytes(value) for value in values] if dtype is TEXT else values, dtype=dtype)
        dataset = file[group][name]
        dataset.resize(data.shape)
        if data.size:
            dataset[...] = data
        stamp(dataset, crc32(data))


def _cut_bytes(text: str) -> bytes:
    """The text in UTF-8, cut to the characters that fit as a whole."""
    return text.encode()[:LONGEST].decode(errors="ignore").encode()
