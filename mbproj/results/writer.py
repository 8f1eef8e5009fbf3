"""Writes a results file: blocks of samples are buffered, flushed about once a second to OUT.part, and renamed to OUT.

The file is in HDF5's SWMR mode from the first sample on: whatever the moment of a kill, OUT.part can be read up to the
last flush. `info` and `plot` can read it while the run goes on.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from itertools import chain, count
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, TypeAlias, final

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5a, h5d, h5ds, h5f, h5p, h5r, h5s, h5t

from mbproj.base.arrays import together
from mbproj.base.errors import InputError
from mbproj.base.sandbox import distrust, trust
from mbproj.results import crash_safety as checkpoint
from mbproj.results import crash_safety as restarting
from mbproj.results import events
from mbproj.results import events as happening
from mbproj.results import largest_loads as stored_loads
from mbproj.results import trust as trusting
from mbproj.results.crash_safety import (
    MARGIN,
    Checkpoint,
    Slots,
    check_output,
    claim,
    has_room,
    part_path,
    reserve,
    room_for,
    write_whole,
)
from mbproj.results.events import Happening
from mbproj.results.faults import OutputError, cannot_write, status_of
from mbproj.results.file.checksums import (
    GROUPS_TOO,
    NOT_YET,
    as_text,
    crc32,
    create_text,
    describe,
    put,
    stamp,
    stamp_attributes,
)
from mbproj.results.file.contents import CHUNK_CACHE, Contents
from mbproj.results.largest_loads import recorded_loads
from mbproj.results.layout import ALL_NAMES, CONSTANTS, LATER_NAMES, Constant, Dataset, datasets_for, trailing
from mbproj.results.provenance import Attribute, root_attributes, write_scene
from mbproj.results.trust import Trust
from mbproj.scene.scene import Scene

if TYPE_CHECKING:
    from mbproj.results.record import Results


# --- Creates the arrays of a new results file, and appends samples to them --------------------------------------------
# Dimension scales name the axes of arrays in the way of netCDF-4, so that xarray shows them. Time is a scale of every
# array; the names of bodies, joints and so on are scales of their arrays. xarray shows scales in the group of an
# array: hard links put time and the components there, too.


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
    sizes = {ALL_NAMES[kind].symbol: len(columns) for kind, columns in names}
    with h5py.File(_name(), "w", driver="core", backing_store=False, libver=VERSIONS) as file:
        for kind, columns in names:
            if kind not in LATER_NAMES or columns:
                create_text(file, ALL_NAMES[kind].path, columns, ALL_NAMES[kind].description)
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


# --- Writes a results file --------------------------------------------------------------------------------------------


#: Names by kind: "bodies", "markers", "joints", "coordinates" ("A.angle"), "coordinate_units" ("rad" | "m").
Names: TypeAlias = Mapping[str, Sequence[str]]
#: Values of T consecutive samples by dataset path, first axis time.
Block: TypeAlias = Mapping[str, npt.NDArray[Any]]

#: Marks by dataset path, without a time axis.
Constants: TypeAlias = Mapping[str, npt.NDArray[Any]]

FLUSH_SECONDS = 1.0
FLUSH_BYTES = 2**23


@final
class ResultsWriter:
    """A context manager that records blocks of samples in `path`.

    The end of the block renames OUT.part to OUT with the status "complete". Where an exception ends it, the status is
    "failed: cause" or "interrupted", with the samples so far; an InputError before the first sample leaves OUT as it
    was. `constants` are the layout's marks by path (`equations.rank.uniqueness`), as far as they are known.
    Raises InputError where `path` cannot or must not be written (see `check_output`), OutputError where writing fails
    later. `certified` are the limits in m of a run that is certified; its `trust` is added at its end. `marks` are
    attributes that the file has from the start.
    """

    def __init__(
        self,
        path: Path | str,
        scene: Scene,
        names: Names,
        constants: Constants | None = None,
        *,
        certified: Sequence[float] | None = None,
        marks: Mapping[str, Attribute] | None = None,
    ) -> None:
        self.path = check_output(Path(path))
        self.part = part_path(self.path)
        self._scene = scene
        self._names = {
            kind: list(names.get(kind, ())) if kind in LATER_NAMES else list(names[kind]) for kind in ALL_NAMES
        }
        self._sizes = {entry.symbol: len(self._names[kind]) for kind, entry in ALL_NAMES.items()}
        self._datasets = datasets_for(self._sizes)
        shapes = [(trailing(dataset, self._sizes), np.dtype(dataset.dtype)) for dataset in self._datasets]
        self._rows = [(chunk_rows(shape), kind.itemsize * math.prod(shape)) for shape, kind in shapes]
        #: The path where the part of a killed run is kept now.
        self.set_aside: Path | None = None
        self._certified, self._marks = certified, marks or {}
        self._trust: Trust | None = None
        self._events: tuple[Happening, ...] = ()
        #: Those that are in the file already; None as long as none is.
        self._met: list[Happening] | None = None
        self._slots = Slots()
        self._constants: dict[str, npt.NDArray[Any]] = {}
        self.mark(constants or {})
        self._summary: dict[str, Attribute] = {}
        self._pending: list[dict[str, npt.NDArray[Any]]] = []
        self._pending_bytes = self._samples = 0
        self._checksums = dict.fromkeys((dataset.path for dataset in self._datasets), 0)
        self._last_time, self._broken, self._finished = 0.0, False, False

    def __enter__(self) -> ResultsWriter:
        try:
            # A new file, not the old one emptied: somebody may be reading the part that a kill has left.
            self._descriptor, self.set_aside = claim(self.part)
        except OSError as error:
            raise cannot_write(self.path, error) from error
        trust(self._descriptor, growing=True)
        try:
            image = self._image()
            reserve(self._descriptor, MARGIN)
            write_whole(self._descriptor, image)
            reserve(self._descriptor, len(image) + MARGIN)
            # HDF5's own lock would fail where somebody is reading the file; `claim` has locked it already.
            self._file = h5py.File(self.part, "r+", libver=VERSIONS, locking=False, **CHUNK_CACHE)
            self._file.swmr_mode = True
            self._targets = {dataset.path: open_array(self._file, dataset.path) for dataset in self._datasets}
        except BaseException as error:  # also an interruption, or InputError where a mesh cannot be read
            self._remove()
            if isinstance(error, OSError):
                raise cannot_write(self.path, error) from error
            raise
        self._flushed = time.monotonic()
        return self

    def mark(self, constants: Constants) -> None:
        """Set the layout's marks by path, before the file is made."""
        self._constants |= {path: self._constant(path, values) for path, values in constants.items()}

    def write(self, block: Block) -> None:
        """Append the samples of `block`, which has every dataset of the layout. The arrays may be reused afterwards.

        Raises ValueError where a dataset is missing, unknown or of the wrong shape, OutputError where the disk refuses.
        """
        unknown = block.keys() - {dataset.path for dataset in self._datasets}
        if unknown:
            raise ValueError(f"the layout has no '{min(unknown)}'")
        samples = len(block["time"])
        if not samples:
            return
        columns = {dataset.path: self._column(dataset, block, samples) for dataset in self._datasets}
        self._pending.append(columns)
        self._pending_bytes += sum(values.nbytes for values in columns.values())
        if self._pending_bytes >= FLUSH_BYTES or time.monotonic() - self._flushed >= FLUSH_SECONDS:
            self._flush()

    def attributes(self, values: Mapping[str, Attribute]) -> None:
        """Add attributes (timings, counters, a summary), which are written at the end. Those of None are left out."""
        texts = {name: as_text(value) for name, value in values.items() if isinstance(value, str)}
        self._summary.update({**values, **texts})

    def events(self, events: Sequence[Happening]) -> None:
        """Set the events of the run, which are written when its results are read, or at its end."""
        self._events, self._met = tuple(events), None

    def keep(self, formulation: str, build: str, state: Mapping[str, Any]) -> None:
        """Set the state from which the run can be continued, to be written with the samples so far."""
        self._slots.take(Checkpoint(formulation, build, state))

    def trust(self, trust: Trust) -> None:
        """Set the comparison with a better solution, which is written at the end; its limits must be `certified`."""
        self._trust = trust

    def results(self) -> Results:
        """The results so far, with the events, read from the file that is open here. They close with it."""
        from mbproj.results.record import Results, ShownPart

        self._flush()
        with self._breaking():
            self._write_events()
        names = {kind: tuple(columns) for kind, columns in self._names.items()}
        contents = Contents(self._file, self.part, unfinished=True)
        return Results(contents, {"status": "running"}, names, ShownPart(slice(0, self._samples), {}))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, InputError) and not (self._samples or self._pending):
            self._discard()
            return
        try:
            if not isinstance(error, OutputError):
                self._flush()
            if not self._broken:
                self._finish(status_of(error))
        except OutputError as late:
            if not self._broken:
                self._finish(status_of(late))
            raise
        finally:
            self._close()

    def _image(self) -> bytes:
        """The bytes of a file without samples. It is made in memory and written at once, so that OUT.part is never half
        created."""
        with in_memory(without_samples(tuple((kind, tuple(columns)) for kind, columns in self._names.items()))) as file:
            put(file, {**root_attributes(), **self._marks})
            write_scene(file, self._scene)
            if self._certified is not None:
                points = self._names["markers"] or self._names["bodies"]
                trusting.create(file, points, self._certified, self._sizes["n"])
            for constant in CONSTANTS:
                if constant.path in self._constants:
                    create_constant(file, constant, self._constants[constant.path])
            return image_of(file)

    def _constant(self, path: str, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        constant = next((each for each in CONSTANTS if each.path == path), None)
        if constant is None:
            raise ValueError(f"the layout has no '{path}'")
        if values.shape != (expected := trailing(constant, self._sizes)):
            raise ValueError(f"'{path}' has the shape {values.shape} where {expected} is due")
        return values.astype(constant.dtype)

    def _column(self, dataset: Dataset, block: Block, samples: int) -> npt.NDArray[Any]:
        expected = (samples, *trailing(dataset, self._sizes))
        if dataset.path not in block:
            raise ValueError(f"the block has no '{dataset.path}'")
        values = np.asarray(block[dataset.path])
        if values.shape != expected:
            raise ValueError(f"'{dataset.path}' has the shape {values.shape} where {expected} is due")
        return values.astype(dataset.dtype, order="C", casting="same_kind", copy=True)

    def _flush(self) -> None:
        """Append the buffered samples. After an interruption they are written again at the same place."""
        self._flushed = time.monotonic()
        if not self._pending:
            return
        total = self._samples + sum(len(columns["time"]) for columns in self._pending)
        try:
            reserve(self._descriptor, self._room_for(total) + self._slots.room)
        except OSError as error:
            what = f"no room for results after t = {self._last_time:.6g} s in '{self.path}': {error.strerror}"
            raise OutputError(f"{what}; make room and run again, what was written before is kept") from error
        checksums: dict[str, int] = {}
        with self._breaking():
            # Data first and time last: after a kill between, the length of `time` is the number of complete samples.
            time_dataset, *others = self._datasets
            for dataset in (*others, time_dataset):
                if dataset is time_dataset:
                    self._file.flush()
                values = together([columns[dataset.path] for columns in self._pending])
                append(self._targets[dataset.path], values, self._samples)
                checksums[dataset.path] = crc32(values, self._checksums[dataset.path])
            self._file.flush()
            self._slots.write(self._file)
            self._file.flush()
        self._checksums = checksums
        self._last_time = float(self._pending[-1]["time"][-1])
        self._samples, self._pending, self._pending_bytes = total, [], 0

    def _finish(self, status: str) -> None:
        with self._breaking():
            if self._trust is not None:
                reserve(self._descriptor, self._room_for(self._samples) + trusting.room(self._trust))
                trusting.write(self._file, self._trust)
            met, end = self._write_events()
            if has_room(self._descriptor, end + stored_loads.room(self._names)):
                stored_loads.write(self._file, recorded_loads(self._targets, self._names, self._constants, met))
            self._slots.write(self._file)
            put(self._file, {name: value for name, value in self._summary.items() if value is not None})
            self._file.attrs["status"] = status
            stamp_attributes(self._file)
            for path, checksum in self._checksums.items():
                stamp(self._targets[path], checksum)
            restarting.seal(self._file)
            self._file.flush()
        self._finished = True

    def _write_events(self) -> tuple[list[Happening], int]:
        """Write the events until the last sample; return them, and the size that the file has at its end."""
        # Half of the margin that each flush has reserved: so there is room for the end even on a full disk.
        met, end = self._met, self._room_for(self._samples) - MARGIN // 2
        if met is None:
            self._met = met = [event for event in self._events if event.time <= self._last_time]
            reserve(self._descriptor, end + happening.room(met) + self._slots.room)
            happening.write(self._file, met)
        return met, end

    def _room_for(self, samples: int) -> int:
        return room_for(self._file, self._rows, self._samples, samples)

    def _discard(self) -> None:
        """Remove OUT.part, where nothing was simulated: OUT stays as it was."""
        with self._breaking():
            self._file.close()
        self._remove()

    def _remove(self) -> None:
        self.part.unlink(missing_ok=True)
        distrust(self._descriptor)
        os.close(self._descriptor)

    def _close(self) -> None:
        """Close the file and, if it is complete, rename it to OUT. Its lock ends last."""
        try:
            with self._breaking():
                self._file.close()
                if self._finished:
                    self.part.replace(self.path)
        finally:
            distrust(self._descriptor)
            if self._finished and not self._broken:
                trust(self._descriptor)
            os.close(self._descriptor)

    @contextmanager
    def _breaking(self) -> Iterator[None]:
        """Mark the file as broken where this block fails: HDF5 cannot continue with it, and it stays OUT.part."""
        try:
            yield
        except (OSError, RuntimeError) as error:
            self._broken = True
            cause = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
            remains = "what was written before is still in it"
            if not self.part.exists():
                remains = "it was removed meanwhile, and what was written is lost"
            raise OutputError(f"cannot write '{self.part}': {cause}; {remains}") from error
