"""A dataset of an opened file: what it declares, what of it is really there, its numbers and their checksum.

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

#: What h5py raises where the bytes of a file are not what they should be.
DAMAGE = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, ArithmeticError, MemoryError)

#: Filters that others may have put on (h5repack, say): those that come with HDF5 and h5py. The first two compress.
COMPRESSING = frozenset((h5z.FILTER_DEFLATE, h5z.FILTER_LZF))
FILTERS = COMPRESSING | {h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32}

#: What HDF5 keeps in memory of each dataset's chunks: as much as the largest that mbproj writes. By itself it keeps
#: 8 MB of each of some forty datasets, although every chunk is written once.
CHUNK_CACHE: Mapping[str, int] = MappingProxyType({"rdcc_nbytes": 2**18, "rdcc_nslots": 101})

#: Sizes of axes; None: any.
Shape = tuple[int | None, ...]


@final
class StoredDataset:
    """A dataset with what it declares: its `shape` and `dtype`."""

    def __init__(self, found: h5py.Dataset) -> None:
        if not isinstance(found, h5py.Dataset) or found.shape is None:
            raise TypeError("no dataset with numbers")
        self._dataset = found
        self.shape: tuple[int, ...] = found.shape
        self.dtype: np.dtype[Any] = found.dtype

    def fits(self, shape: Shape, dtype: npt.DTypeLike | None) -> bool:
        """Whether it has this shape and type; None: text of one length in place."""
        if len(shape) != len(self.shape) or not all(map(_is_or_any, self.shape, shape)):
            return False
        return self.dtype.kind == "S" if dtype is None else self.dtype == np.dtype(dtype)

    @property
    def has_texts(self) -> bool:
        """Whether it holds texts, each of its own length."""
        return h5py.check_string_dtype(self.dtype) is not None and self.dtype.kind == "O"

    def size(self, rows: int | None) -> int:
        """The bytes of so many rows of the first axis, or of all of it."""
        shape = self.shape if rows is None else (rows, *self.shape[1:])
        return math.prod(shape) * self.dtype.itemsize

    @cached_property
    def filters(self) -> frozenset[int]:
        """HDF5's numbers of the filters that its chunks go through."""
        properties = self._dataset.id.get_create_plist()
        return frozenset(properties.get_filter(number)[0] for number in range(properties.get_nfilters()))

    @cached_property
    def stored(self) -> int:
        """The bytes that the file has of it. Every chunk is visited."""
        return int(self._dataset.id.get_storage_size())

    @property
    def chunk(self) -> int:
        """The bytes of a chunk as it is in memory; 0 where there are none."""
        return math.prod(self._dataset.chunks) * self.dtype.itemsize if self._dataset.chunks else 0

    @property
    def chunk_rows(self) -> int:
        """Rows that are stored together."""
        return self._dataset.chunks[0] if self._dataset.chunks else self.shape[0]

    @property
    def is_guarded(self) -> bool:
        """Whether it has a checksum."""
        return h5z.FILTER_FLETCHER32 in self.filters or self._checksum != NOT_YET

    @property
    def unit(self) -> object:
        """The unit that the file gives it."""
        return self._dataset.attrs.get("units")

    @property
    def _checksum(self) -> int:
        return int(self._dataset.attrs.get(OF_DATA, NOT_YET))

    def read(self, window: slice | None = None) -> npt.NDArray[Any]:
        """All of it, or the rows of a window."""
        return np.asarray(self._dataset[... if window is None else window])

    def ends_in_a_chunk_that_grows(self, window: slice, rows: int) -> bool:
        """Whether the last chunk of a window is one that a run adds rows to, or did when it was killed; `rows`: those
        that are whole."""
        first = self._last_chunk(window)
        return self.filters == {h5z.FILTER_FLETCHER32} and first <= rows < first + self.chunk_rows

    def read_without_the_last_checksum(self, window: slice) -> npt.NDArray[Any]:
        """The rows of a window. A chunk that grows is written anew with each flush. A kill can fall between its rows,
        of which new ones then stand behind the old, and its checksum."""
        shape, first = self._dataset.chunks, self._last_chunk(window)
        full = max(window.start, first)
        stored = self._dataset.id.read_direct_chunk((first, *(0 for _ in shape[1:])))[1]
        rows = np.frombuffer(stored, self.dtype, count=math.prod(shape)).reshape(shape)
        return np.concatenate([self._dataset[window.start : full], rows[full - first : window.stop - first]])

    def _last_chunk(self, window: slice) -> int:
        """The first row of the chunk with the window's last one."""
        return int((window.stop - 1) // self.chunk_rows * self.chunk_rows)

    def is_as_written(self, values: npt.NDArray[Any]) -> bool:
        """Whether `values`, which are all of it, have the checksum; also where there is none."""
        return self._checksum in (NOT_YET, crc32(values))


def _is_or_any(size: int, asked: int | None) -> bool:
    return asked in (None, size)
