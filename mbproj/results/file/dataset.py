"""A dataset of an opened file: its declared shape and type, the bytes that exist, its numbers and their checksum.

Methods raise one of `DAMAGE` where the bytes of the file are not what they should be.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, final

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5z

from mbproj.results.file.checksums import NOT_YET, OF_DATA, crc32

#: The exceptions of h5py for a file whose bytes are wrong.
DAMAGE = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, ArithmeticError, MemoryError)

#: The filters that come with HDF5 and h5py, which other programs (as h5repack) may have added. The first ones compress.
COMPRESSING = frozenset((h5z.FILTER_DEFLATE, h5z.FILTER_LZF))
FILTERS = COMPRESSING | {h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32}

#: HDF5's cache of chunks for each dataset, as large as the largest chunk that mbproj writes. The default is 8 MB for
#: each of some forty datasets, although every chunk is written once.
CHUNK_CACHE: Mapping[str, int] = MappingProxyType({"rdcc_nbytes": 2**18, "rdcc_nslots": 101})

#: The lengths of axes; None is any length.
Shape = tuple[int | None, ...]


@final
class StoredDataset:
    """A dataset of a file, with the `shape` and the `dtype` that it declares."""

    def __init__(self, dataset: h5py.Dataset) -> None:
        if not isinstance(dataset, h5py.Dataset) or dataset.shape is None:
            raise TypeError("no dataset with numbers")
        self._dataset = dataset
        self.shape: tuple[int, ...] = dataset.shape
        self.dtype: np.dtype[Any] = dataset.dtype

    def fits(self, shape: Shape, dtype: npt.DTypeLike | None) -> bool:
        """Whether the dataset has this shape and type; the type None is text of fixed length."""
        if len(shape) != len(self.shape) or not all(map(_is_or_any, self.shape, shape)):
            return False
        return self.dtype.kind == "S" if dtype is None else self.dtype == np.dtype(dtype)

    @property
    def has_texts(self) -> bool:
        """Whether the dataset has texts of variable length."""
        return h5py.check_string_dtype(self.dtype) is not None and self.dtype.kind == "O"

    def size(self, rows: int | None) -> int:
        """The bytes in memory of `rows` rows of the first axis, or of all (None)."""
        shape = self.shape if rows is None else (rows, *self.shape[1:])
        return math.prod(shape) * self.dtype.itemsize

    @cached_property
    def filters(self) -> frozenset[int]:
        """HDF5's numbers of the filters of its chunks."""
        properties = self._dataset.id.get_create_plist()
        return frozenset(properties.get_filter(number)[0] for number in range(properties.get_nfilters()))

    @cached_property
    def stored(self) -> int:
        """The bytes that the dataset takes in the file. HDF5 visits every chunk for this."""
        return int(self._dataset.id.get_storage_size())

    @property
    def chunk(self) -> int:
        """The bytes of a chunk in memory; 0 where the dataset has no chunks."""
        return math.prod(self._dataset.chunks) * self.dtype.itemsize if self._dataset.chunks else 0

    @property
    def chunk_rows(self) -> int:
        """The number of rows in a chunk, or of all where there are no chunks."""
        return self._dataset.chunks[0] if self._dataset.chunks else self.shape[0]

    @property
    def is_guarded(self) -> bool:
        """Whether the dataset has a checksum of its own, or of each chunk."""
        return h5z.FILTER_FLETCHER32 in self.filters or self._checksum != NOT_YET

    @property
    def unit(self) -> object:
        """The unit in the file; None where it has none."""
        return self._dataset.attrs.get("units")

    @property
    def _checksum(self) -> int:
        return int(self._dataset.attrs.get(OF_DATA, NOT_YET))

    def read(self, window: slice | None = None) -> npt.NDArray[Any]:
        """Read the dataset, or the rows of a window."""
        return np.asarray(self._dataset[... if window is None else window])

    def ends_in_a_chunk_that_grows(self, window: slice, rows: int) -> bool:
        """Whether a run adds rows to the last chunk of a window, or did so when it was killed. `rows` is the number of
        complete rows."""
        first = self._last_chunk(window)
        return self.filters == {h5z.FILTER_FLETCHER32} and first <= rows < first + self.chunk_rows

    def read_without_the_last_checksum(self, window: slice) -> npt.NDArray[Any]:
        """Read the rows of a window without the checksum of the last chunk. Each flush writes a growing chunk anew: a
        kill may have left its new rows without the new checksum."""
        shape, first = self._dataset.chunks, self._last_chunk(window)
        full = max(window.start, first)
        stored = self._dataset.id.read_direct_chunk((first, *(0 for _ in shape[1:])))[1]
        rows = np.frombuffer(stored, self.dtype, count=math.prod(shape)).reshape(shape)
        return np.concatenate([self._dataset[window.start : full], rows[full - first : window.stop - first]])

    def _last_chunk(self, window: slice) -> int:
        """The first row of the chunk that has the last row of the window."""
        return int((window.stop - 1) // self.chunk_rows * self.chunk_rows)

    def is_as_written(self, values: npt.NDArray[Any]) -> bool:
        """Whether `values`, all those of the dataset, have its checksum; true where it has none."""
        return self._checksum in (NOT_YET, crc32(values))


def _is_or_any(size: int, asked: int | None) -> bool:
    return asked in (None, size)
