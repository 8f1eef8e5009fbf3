"""The arrays of a new results file."""

from __future__ import annotations

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5d, h5p, h5s, h5t

from mbproj.results.file.attributes import add_texts
from mbproj.results.file.checksums import NOT_YET, crc32, stamp
from mbproj.results.layout import Constant, Dataset

CHUNK_BYTES = 2**18
CHUNK_SAMPLES = 512
#: A dataset is created with the groups of its path.
GROUPS_TOO = h5p.create(h5p.LINK_CREATE)
GROUPS_TOO.set_create_intermediate_group(True)


def create_dataset(file: h5py.File, dataset: Dataset, shape: tuple[int, ...]) -> None:
    """An array of samples without any, that grows."""
    row_bytes = 8 * max(1, int(np.prod(shape)))
    samples = min(CHUNK_SAMPLES, max(1, CHUNK_BYTES // row_bytes))
    # HDF5 wants chunks of at least one; an axis of none (no markers) must then be open.
    space = h5s.create_simple((0, *shape), (h5s.UNLIMITED, *(size or h5s.UNLIMITED for size in shape)))
    properties = h5p.create(h5p.DATASET_CREATE)
    properties.set_chunk((samples, *(max(1, size) for size in shape)))
    properties.set_fletcher32()
    properties.set_obj_track_times(False)
    kind = h5t.py_create(np.dtype(dataset.dtype), logical=True)
    # By HDF5's own calls: h5py's take three times as long.
    created = h5py.Dataset(h5d.create(file.id, dataset.path.encode(), kind, space, properties, GROUPS_TOO))
    stamp(created, NOT_YET)
    add_texts(created, {"units": dataset.unit, "description": dataset.description})
    if dataset.frame:
        add_texts(created, {"frame": dataset.frame})


def create_constant(file: h5py.File, constant: Constant, values: npt.NDArray[np.bool_]) -> None:
    """Marks without a time axis."""
    created = file.create_dataset(constant.path, data=values)
    stamp(created, crc32(values))
    add_texts(created, {"units": constant.unit, "description": constant.description, "frame": constant.frame})
