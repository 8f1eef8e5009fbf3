"""The arrays of a new results file."""

from __future__ import annotations

import h5py
import numpy as np
import numpy.typing as npt

from mbproj.results.file.checksums import NOT_YET, crc32, stamp
from mbproj.results.layout import Constant, Dataset

CHUNK_BYTES = 2**18
CHUNK_SAMPLES = 512


def create_dataset(file: h5py.File, dataset: Dataset, shape: tuple[int, ...]) -> None:
    """An array of samples without any, that grows."""
    row_bytes = 8 * max(1, int(np.prod(shape)))
    samples = min(CHUNK_SAMPLES, max(1, CHUNK_BYTES // row_bytes))
    created = file.create_dataset(
        dataset.path,
        shape=(0, *shape),
        # HDF5 wants chunks of at least one; an axis of none (no markers) must then be open.
        maxshape=(None, *(size or None for size in shape)),
        chunks=(samples, *(max(1, size) for size in shape)),
        dtype=dataset.dtype,
        fletcher32=True,
    )
    stamp(created, NOT_YET)
    created.attrs.update({"units": dataset.unit, "description": dataset.description})
    if dataset.frame:
        created.attrs["frame"] = dataset.frame


def create_constant(file: h5py.File, constant: Constant, values: npt.NDArray[np.bool_]) -> None:
    """Marks without a time axis."""
    created = file.create_dataset(constant.path, data=values)
    stamp(created, crc32(values))
    created.attrs.update({"units": constant.unit, "description": constant.description, "frame": constant.frame})
