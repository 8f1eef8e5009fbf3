"""Writes arrays that do not grow, each at once: numbers, and texts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5d, h5p, h5s, h5t

from mbproj.results.file.checksums import crc32, describe, stamp

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
