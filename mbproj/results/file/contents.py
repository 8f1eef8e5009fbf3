"""`Contents`: every read from an opened results file. Kind, shape, size and checksum are checked before use.

A damaged file may declare any size: sizes are compared with the bytes of the file before an array is allocated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Any, NoReturn, TypeAlias, final

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5a, h5t, h5z

from mbproj.base.errors import InputError, Problem, warn_once
from mbproj.results.faults import damaged
from mbproj.results.file.checksums import NOT_YET, OF_ATTRIBUTES, OF_DATA, crc32, plain, wrong_attributes

# --- A dataset of an opened file --------------------------------------------------------------------------------------
# Its declared shape and type, the bytes that exist, its numbers and their checksum.
# Methods raise one of `DAMAGE` where the bytes of the file are not what they should be.


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


# --- `Contents` -------------------------------------------------------------------------------------------------------


#: The most bytes of a file's data in memory: UNPACKED times the size of the file, or UNPACKED_BYTES if that is more.
UNPACKED, UNPACKED_BYTES = 64, 2**26
#: Attributes are numbers, flags and texts that are stored in place, each of at most ATTRIBUTE_BYTES.
ATTRIBUTE_TYPES = (h5t.INTEGER, h5t.FLOAT, h5t.ENUM, h5t.STRING)
ATTRIBUTE_BYTES = 2**20

UNCHECKED = "do not have their checksum: the run was killed while it wrote them, or they were changed"


@final
class Contents:
    """The contents of the opened `file` at `path`, by the paths of the layout; `close` closes it.

    `unfinished`: a run is writing it, or was killed; `grows_from` is then the number of complete samples, None until it
    is known. Every fault is an InputError that names the file and the part.
    """

    def __init__(self, file: h5py.File, path: Path, *, unfinished: bool) -> None:
        self._opened, self.path, self.unfinished = file, path, unfinished
        self.grows_from: int | None = None
        self._size = path.stat().st_size
        self._datasets: dict[str, StoredDataset] = {}
        self._unpacked: dict[str, int] = {}

    def __enter__(self) -> Contents:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def is_open(self) -> bool:
        """Whether the file is open, so that it can be read."""
        return bool(self._opened)

    def __reduce__(self) -> NoReturn:
        what = "results are an open file, which cannot be pickled or copied deeply: pass its path on"
        raise TypeError(f"{what}, and open it there with open_results")

    def close(self) -> None:
        """Close the file."""
        self._opened.close()

    @property
    def _file(self) -> h5py.File:
        """The file. Raises InputError where it is closed."""
        if not self._opened:
            raise InputError(Problem(f"'{self.path}' is closed", hint="open it again, with open_results"))
        return self._opened

    def has(self, name: str) -> bool:
        """Whether there is a dataset or group of this name."""
        with self._reading(name):
            return name in self._file

    def damaged(self, name: str, what: str) -> InputError:
        """The error of a damaged part of the file."""
        return damaged(self.path, f"'{name}' {what}")

    def check_whole(self, name: str) -> None:
        """Read a dataset with its attributes. Raises InputError where one of its checksums is wrong or missing."""
        dataset = self._dataset(name)
        if not self.is_guarded(name):
            raise self.damaged(name, "has no checksum")
        self.check_description(name)
        self.check_room(name)
        self._read(dataset, name)

    def datasets(self) -> list[str]:
        """The names of all datasets."""
        paths: list[str] = []
        with self._reading("/"):
            self._file.visititems(lambda name, item: paths.append(name) if isinstance(item, h5py.Dataset) else None)
            for place, name in enumerate(paths):  # a scale of several groups is also in the root
                shared = name.rpartition("/")[2]
                if shared in self._file and self._file[shared] == self._file[name]:
                    paths[place] = shared
        return paths

    def rows(self, name: str, trailing: tuple[int, ...], dtype: npt.DTypeLike = "f8") -> int:
        """The length of the first axis of a dataset; its other axes must have the lengths `trailing`."""
        return self._fitting(name, (None, *trailing), dtype).shape[0]

    def check_room(self, name: str, rows: int | None = None) -> None:
        """Raises InputError where the file is too small to hold `rows` rows of a dataset, or all of them (None)."""
        dataset = self._dataset(name)
        with self._reading(name):
            needed, stored, filters = dataset.size(rows), dataset.stored, dataset.filters
        if not filters <= FILTERS:
            raise self.damaged(name, "is packed by a filter that is not HDF5's own")
        if filters & COMPRESSING:
            self._unpacked[name] = max(needed, dataset.chunk) if needed else 0
            if sum(self._unpacked.values()) > max(UNPACKED * self._present_size(), UNPACKED_BYTES):
                raise self.damaged(name, f"would be {needed} bytes when unpacked, far more than the file has")
        elif needed > stored:
            raise self.damaged(name, f"declares {needed} bytes, and the file holds {stored} of them")
        if needed and stored > self._present_size():
            raise self.damaged(name, f"declares {stored} stored bytes, more than the file has")

    def array(
        self, name: str, shape: Shape, dtype: npt.DTypeLike = "f8", window: slice | None = None
    ) -> npt.NDArray[Any]:
        """The numbers of a dataset of this shape and type, or those in the rows `window`. Its checksum is compared
        where all of it is read."""
        dataset = self._fitting(name, shape, dtype)
        self.check_room(name, window.stop if window else None)
        return self._read(dataset, name, window)

    def texts(self, name: str) -> tuple[str, ...]:
        """The texts of a dataset that is a list."""
        return self._texts(name, (None,))

    def text(self, name: str) -> str:
        """The text of a dataset that is a single one."""
        return self._texts(name, ())[0]

    def column(self, name: str, shape: Shape) -> npt.NDArray[Any]:
        """The numbers, or texts of any length, of a dataset of this shape. The file has texts apart from their dataset:
        the sandbox limits the memory that they take."""
        dataset = self._dataset(name)
        if not dataset.has_texts:
            return self.array(name, shape)
        if not dataset.fits(shape, dataset.dtype):
            raise self.damaged(name, "has the wrong shape or type")
        self.check_room(name)
        stored = self._read(dataset, name)
        with self._reading(name):
            texts = [bytes(text).decode() for text in stored.reshape(-1)]
        if not all(text.isprintable() for text in texts):
            raise self.damaged(name, "has a text that cannot be printed")
        return np.array(texts, dtype=object).reshape(stored.shape)

    def length(self, name: str) -> int:
        """The number of values of a dataset with one axis."""
        shape = self._dataset(name).shape
        if len(shape) != 1:
            raise self.damaged(name, "has the wrong shape")
        return shape[0]

    def names_in(self, attribute: str) -> tuple[str, ...]:
        """The names in an attribute of the file that is a list."""
        with self._reading(attribute):
            names = [plain(name) for name in np.atleast_1d(self._file.attrs[attribute])]
        if not all(isinstance(name, str) and name.isprintable() for name in names):
            raise self.damaged(attribute, "is no list of names")
        return tuple(names)

    def attributes(self, group: str = "/") -> Mapping[str, Any]:
        """The attributes that are numbers, flags or texts. In a finished file those that mbproj wrote, also lists of
        texts, are compared with their checksums."""
        try:
            stored = dict(_attributes(self._file[group]))
        except DAMAGE as error:
            raise damaged(self.path, "its attributes cannot be read") from error
        for name in () if self.unfinished else wrong_attributes(stored):
            raise damaged(self.path, f"its attribute '{name}' is not what was written")
        return {name: value for name, value in stored.items() if name != OF_ATTRIBUTES and not isinstance(value, list)}

    def check_description(self, name: str) -> None:
        """Raises InputError where an attribute of a dataset, as its unit, differs from its checksum."""
        self._dataset(name)
        with self._reading(name):
            wrong = wrong_attributes(dict(_attributes(self._file[name])))
        for attribute in wrong:
            raise self.damaged(name, f"has an attribute '{attribute}' that is not what was written")

    def unreadable_rows(self, name: str, rows: int) -> list[tuple[int, int]]:
        """The first and the last row of each chunk of a dataset that cannot be read."""
        dataset, ranges = self._dataset(name), []
        for first in range(0, rows, max(1, dataset.chunk_rows)):
            last = min(first + dataset.chunk_rows, rows)
            try:
                dataset.read(slice(first, last))
            except DAMAGE:
                ranges.append((first, last - 1))
        return ranges

    def is_guarded(self, name: str) -> bool:
        """Whether the file has a checksum of this dataset."""
        with self._reading(name):
            return self._dataset(name).is_guarded

    def unit(self, name: str) -> object:
        """The unit that the file gives a dataset."""
        with self._reading(name):
            return self._dataset(name).unit

    @contextmanager
    def _reading(self, name: str) -> Iterator[None]:
        """Turn the exceptions of h5py in this block into the error of a damaged part of the file."""
        try:
            yield
        except DAMAGE as error:
            raise self.damaged(name, "cannot be read") from error

    def _dataset(self, name: str) -> StoredDataset:
        file = self._file
        if name not in self._datasets:
            try:
                member = file[name]
            except DAMAGE as error:
                raise damaged(self.path, f"it has no '{name}'") from error
            with self._reading(name):
                self._datasets[name] = StoredDataset(member)
        return self._datasets[name]

    def _fitting(self, name: str, shape: Shape, dtype: npt.DTypeLike | None) -> StoredDataset:
        dataset = self._dataset(name)
        if not dataset.fits(shape, dtype):
            raise self.damaged(name, "has the wrong shape or type")
        return dataset

    def _present_size(self) -> int:
        """The present size of the file in bytes: it grows while a run writes it, which renames it at its end."""
        if self.unfinished and self.path.exists():
            self._size = max(self._size, self.path.stat().st_size)
        return self._size

    def _read(self, dataset: StoredDataset, name: str, window: slice | None = None) -> npt.NDArray[Any]:
        with self._reading(name):
            values = self._values(dataset, name, window)
            as_written = values.shape != dataset.shape or dataset.is_as_written(values)
        if not as_written:
            raise self.damaged(name, "is not what was written: its checksum differs")
        return values

    def _values(self, dataset: StoredDataset, name: str, window: slice | None) -> npt.NDArray[Any]:
        try:
            return dataset.read(window)
        except DAMAGE:
            if window is None or self.grows_from is None:
                raise
            if not dataset.ends_in_a_chunk_that_grows(window, self.grows_from):
                raise
        values = dataset.read_without_the_last_checksum(window)
        warn_once(f"the last samples of '{name}' in '{self.path}' {UNCHECKED}")
        return values

    def _texts(self, name: str, shape: Shape) -> tuple[str, ...]:
        dataset = self._fitting(name, shape, None)
        self.check_room(name)
        stored = self._read(dataset, name)
        with self._reading(name):
            return tuple(bytes(text).decode() for text in stored.reshape(-1))


def _attributes(place: h5py.Group | h5py.Dataset) -> Iterator[tuple[str, Any]]:
    for name in place.attrs:
        attribute = h5a.open(place.id, name.encode("utf-8", "surrogateescape"))
        kind = attribute.get_type().get_class()
        of_a_kind = (
            kind in ATTRIBUTE_TYPES if attribute.shape == () else kind == h5t.STRING and len(attribute.shape or ()) == 1
        )
        if of_a_kind and attribute.get_storage_size() <= ATTRIBUTE_BYTES and name.isprintable():
            value = plain(place.attrs[name])
            for text in value if isinstance(value, list) else [value]:
                if isinstance(text, str):
                    text.encode()  # raises for bytes that are no UTF-8, which were read as surrogates
            yield name, value


Values: TypeAlias = npt.NDArray[Any]
#: The most bytes of all arrays together; one alone may take more.
KEPT_BYTES = 2**25


@final
class KeptArrays:
    """The arrays by path, those used last at the end; the times always stay."""

    def __init__(self) -> None:
        self._arrays: dict[str, Values] = {}

    def get(self, path: str, read: Callable[[], Values]) -> Values:
        """The array of a path, which is read where it is not here. Those that were not used for longest may be
        dropped."""
        array = self._arrays.pop(path, None)
        self._arrays[path] = array = read() if array is None else array
        size = sum(values.nbytes for values in self._arrays.values())
        for other in [other for other in list(self._arrays)[:-1] if other != "time"]:
            if size > KEPT_BYTES:
                size -= self._arrays.pop(other).nbytes
        return array
