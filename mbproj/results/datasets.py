"""Creates the arrays of a new results file, and appends samples to them.

Dimension scales name the axes of arrays in the way of netCDF-4, so that xarray shows them. Time is a scale of every
array; the names of bodies, joints and so on are scales of their arrays. xarray shows scales in the group of an array:
hard links put time and the components there, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from itertools import chain, count
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5a, h5d, h5ds, h5f, h5p, h5r, h5s, h5t

from mbproj.results import events
from mbproj.results.crash_safety import checkpoint
from mbproj.results.file.checksums import NOT_YET, crc32, describe, stamp
from mbproj.results.file.whole import GROUPS_TOO, create_text
from mbproj.results.layout import ALL_NAMES, LATER_NAMES, Constant, Dataset, datasets_for, trailing
from mbproj.results.loads import stored as stored_loads

CHUNK_BYTES = 2**18
CHUNK_SAMPLES = 512
_NUMBERS = count()
#: The file format of HDF5 1.10, the oldest that SWMR can use: so older readers can open the results.
VERSIONS = ("v110", "v110")
TIME = "time"
#: HDF5 types: a reference, the list of scales of an axis, and the use of a scale for an axis of a dataset.
REFERENCE = h5py.ref_dtype
SCALES = h5py.vlen_dtype(REFERENCE)
USES = np.dtype([("dataset", REFERENCE), ("dimension", "<u4")])
#: The paths of the names of columns, by the symbol of the layout.
NAMES = {entry.symbol: entry.path for kind, entry in ALL_NAMES.items() if not kind.endswith("_units")}
#: The components of vectors and of Euler parameters, by their number.
COMPONENTS = {
    3: ("axis", ("x", "y", "z"), "components of a vector"),
    4: ("euler_parameter", ("e0", "e1", "e2", "e3"), "Euler parameters, scalar first"),
}


@lru_cache(8)
def without_samples(names: tuple[tuple[str, tuple[str, ...]], ...]) -> bytes:
    """The bytes of a file with empty arrays for columns with these names, by kind. They are cached for runs with the
    same names, since the arrays take two thirds of the time of a new file."""
    sizes = {ALL_NAMES[kind].symbol: len(own) for kind, own in names}
    with h5py.File(_name(), "w", driver="core", backing_store=False, libver=VERSIONS) as file:
        for kind, own in names:
            if kind not in LATER_NAMES or own:
                create_text(file, ALL_NAMES[kind].path, own, ALL_NAMES[kind].description)
        for dataset in datasets_for(sizes):
            create_dataset(file, dataset, trailing(dataset, sizes))
        name_axes(file, datasets_for(sizes))
        events.create(file)
        stored_loads.create(file)
        checkpoint.create(file, sizes["n"])
        return image_of(file)


@contextmanager
def in_memory(image: bytes) -> Iterator[h5py.File]:
    """Open a file in memory that begins with these bytes; it never reaches the disk."""
    access = h5p.create(h5p.FILE_ACCESS)
    access.set_fapl_core(2**16, backing_store=False)
    access.set_libver_bounds(h5f.LIBVER_V110, h5f.LIBVER_V110)
    access.set_file_image(image)
    with h5py.File(h5f.open(_name().encode(), h5f.ACC_RDWR, access)) as file:
        yield file


def _name() -> str:
    """A new name for a file in memory: HDF5 takes two of one name for the same file, and threads may have several."""
    return f"image {next(_NUMBERS)}"


def image_of(file: h5py.File) -> bytes:
    """The bytes of a file in memory."""
    file.flush()
    image: bytes = file.id.get_file_image()
    return image


def chunk_rows(shape: tuple[int, ...]) -> int:
    """The number of samples in a chunk of a dataset whose samples have this shape."""
    row_bytes = 8 * max(1, math.prod(shape))
    return min(CHUNK_SAMPLES, max(1, CHUNK_BYTES // row_bytes))


def create_dataset(file: h5py.File, dataset: Dataset, shape: tuple[int, ...]) -> None:
    """Create an array without samples, that can grow."""
    # HDF5 needs chunks of at least one entry; an axis of length 0 (no markers) must then be unlimited.
    space = h5s.create_simple((0, *shape), (h5s.UNLIMITED, *(size or h5s.UNLIMITED for size in shape)))
    properties = h5p.create(h5p.DATASET_CREATE)
    properties.set_chunk((chunk_rows(shape), *(max(1, size) for size in shape)))
    properties.set_fletcher32()
    properties.set_obj_track_times(False)
    kind = h5t.py_create(np.dtype(dataset.dtype), logical=True)
    # HDF5's own calls are used, since those of h5py take three times as long.
    created = h5py.Dataset(h5d.create(file.id, dataset.path.encode(), kind, space, properties, GROUPS_TOO))
    stamp(created, NOT_YET)
    frame = {"frame": dataset.frame} if dataset.frame else {}
    describe(created, {"units": dataset.unit, "description": dataset.description, **frame})


def open_array(file: h5py.File, path: str) -> h5py.Dataset:
    """Open an existing array."""
    return h5py.Dataset(h5d.open(file.id, path.encode()))


def append(target: h5py.Dataset, values: npt.NDArray[Any], first: int) -> None:
    """Write samples (T, ...) into an array from its row `first` on; it ends with them. HDF5's own calls are faster."""
    target.id.set_extent((first + len(values), *values.shape[1:]))
    if values.size:
        rows = target.id.get_space()
        rows.select_hyperslab((first, *(0 for _ in values.shape[1:])), values.shape)
        target.id.write(h5s.create_simple(values.shape), rows, np.ascontiguousarray(values))


def create_constant(file: h5py.File, constant: Constant, values: npt.NDArray[Any]) -> None:
    """Write an array of marks or numbers, which has no time axis."""
    created = file.create_dataset(constant.path, data=values)
    stamp(created, crc32(values))
    describe(created, {"units": constant.unit, "description": constant.description, "frame": constant.frame})


def name_axes(file: h5py.File, datasets: Sequence[Dataset]) -> None:
    """Make scales of the names, which are written already, and attach them to all axes of these arrays."""
    for name, texts, description in COMPONENTS.values():
        create_text(file, name, texts, description)
    along = {each.path: _scale_paths(each) for each in datasets if each.path != TIME}
    scales = {path: h5d.open(file.id, path.encode()) for path in dict.fromkeys(chain([TIME], *along.values()))}
    uses: dict[str, list[tuple[h5r.Reference, int]]] = {path: [] for path in scales}
    referred = {path: _reference(file, path) for path in scales}
    for path, paths in along.items():
        group, mine = path.partition("/")[0], _reference(file, path)
        lists = np.empty(len(paths), dtype=SCALES)
        for axis, each in enumerate(paths):
            lists[axis] = np.array([referred[each]], dtype=REFERENCE)
        _write_attribute(h5d.open(file.id, path.encode()), b"DIMENSION_LIST", lists)
        for axis, each in enumerate(paths):
            uses[each].append((mine, axis))
            if "/" not in each and not file.id.links.exists(f"{group}/{each}".encode()):
                file.id.links.create_hard(f"{group}/{each}".encode(), file.id, each.encode())
    for path, scale in scales.items():
        h5ds.set_scale(scale, path.rpartition("/")[2].encode())
        _write_attribute(scale, b"REFERENCE_LIST", np.array(uses[path], dtype=USES))


def _reference(file: h5py.File, path: str) -> h5r.Reference:
    return h5r.create(file.id, path.encode(), h5r.OBJECT)


def _write_attribute(target: h5d.DatasetID, name: bytes, values: npt.NDArray[Any]) -> None:
    """Write an attribute of scales. HDF5's calls for scales write the same, but take four times as long."""
    kind = h5t.py_create(values.dtype, logical=True)
    h5a.create(target, name, kind, h5s.create_simple(values.shape)).write(values, mtype=h5t.py_create(values.dtype))


def _scale_paths(dataset: Dataset) -> list[str]:
    """The paths of the scales of an array, one for each axis."""
    return [TIME, *(NAMES[size] if isinstance(size, str) else COMPONENTS[size][0] for size in dataset.shape)]
