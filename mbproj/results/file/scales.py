"""Dimension scales: the names along the axes of arrays, in the way of netCDF-4, so that xarray shows them.

Time is a scale of every array; the names of bodies, joints and so on are scales of their arrays. xarray shows scales in
the group of an array: hard links put time and the components there, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5a, h5d, h5ds, h5r, h5s, h5t

from mbproj.results.file.whole import create_text
from mbproj.results.layout import ALL_NAMES, Dataset

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


def name_axes(file: h5py.File, datasets: Sequence[Dataset]) -> None:
    """Make scales of the names, which are written already, and attach them to all axes of these arrays."""
    for name, texts, description in COMPONENTS.values():
        create_text(file, name, texts, description)
    along = {each.path: _along(each) for each in datasets if each.path != TIME}
    scales = {path: h5d.open(file.id, path.encode()) for path in dict.fromkeys(chain([TIME], *along.values()))}
    uses: dict[str, list[tuple[h5r.Reference, int]]] = {path: [] for path in scales}
    referred = {path: _reference(file, path) for path in scales}
    for path, paths in along.items():
        group, mine = path.partition("/")[0], _reference(file, path)
        lists = np.empty(len(paths), dtype=SCALES)
        for axis, each in enumerate(paths):
            lists[axis] = np.array([referred[each]], dtype=REFERENCE)
        _put(h5d.open(file.id, path.encode()), b"DIMENSION_LIST", lists)
        for axis, each in enumerate(paths):
            uses[each].append((mine, axis))
            if "/" not in each and not file.id.links.exists(f"{group}/{each}".encode()):
                file.id.links.create_hard(f"{group}/{each}".encode(), file.id, each.encode())
    for path, scale in scales.items():
        h5ds.set_scale(scale, path.rpartition("/")[2].encode())
        _put(scale, b"REFERENCE_LIST", np.array(uses[path], dtype=USES))


def _reference(file: h5py.File, path: str) -> h5r.Reference:
    return h5r.create(file.id, path.encode(), h5r.OBJECT)


def _put(target: h5d.DatasetID, name: bytes, values: npt.NDArray[Any]) -> None:
    """Write an attribute of scales. HDF5's calls for scales write the same, but take four times as long."""
    kind = h5t.py_create(values.dtype, logical=True)
    h5a.create(target, name, kind, h5s.create_simple(values.shape)).write(values, mtype=h5t.py_create(values.dtype))


def _along(dataset: Dataset) -> list[str]:
    """The paths of the scales of an array, one for each axis."""
    return [TIME, *(NAMES[size] if isinstance(size, str) else COMPONENTS[size][0] for size in dataset.shape)]
