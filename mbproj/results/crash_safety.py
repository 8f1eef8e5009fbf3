"""A run claims OUT.part: it is locked before it has content, so that a kill at any moment blocks nobody.

A part whose lock a process holds is being written. A part without such a process was left by a kill. It is kept under
another name where it has samples, else replaced.

Room on the disk is reserved before HDF5 writes: after a write that fails, HDF5 cannot close its file any more.
"""

from __future__ import annotations

import errno
import json
import os
import struct
import zlib
from collections.abc import Iterable, Mapping
from itertools import count
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple, final

import h5py
import numpy as np

from mbproj.base.errors import InputError, Problem
from mbproj.base.registry import FORMULATIONS
from mbproj.results.faults import (
    ELSEWHERE,
    being_written,
    cannot_write,
    is_directory,
    not_replaced,
    not_replaced_for_damage,
)
from mbproj.results.file.checksums import NOT_YET, crc32, describe, stamp
from mbproj.results.file.contents import Contents
from mbproj.results.file.opening import Identity, check_regular, identify, is_locked, lock, open_file

#: Bytes for HDF5's own bookkeeping of one flush, and for the attributes at the end.
MARGIN = 2**20
#: The bytes that Fletcher-32 adds to a chunk.
CHECKSUM = 4
FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EIO)


def room_for(file: h5py.File, rows: Iterable[tuple[int, int]], before: int, samples: int) -> int:
    """The size in bytes that the file may reach when datasets grow from `before` samples to `samples`. `rows` has, for
    each dataset, the number of samples in a chunk and the bytes of a sample."""
    growth = 0
    for chunk, row_bytes in rows:
        new_chunks = -(-samples // chunk) - -(-before // chunk)
        growth += max(0, new_chunks) * (chunk * row_bytes + CHECKSUM)
    return int(file.id.get_filesize()) + growth + MARGIN


def reserve(descriptor: int, size: int) -> None:
    """Make the file at least `size` bytes long, with blocks on the disk. Raises OSError where there is no room."""
    if not hasattr(os, "posix_fallocate") or os.fstat(descriptor).st_size >= size:
        return
    try:
        os.posix_fallocate(descriptor, 0, size)
    except OSError as error:
        if error.errno in FULL:
            raise


def has_room(descriptor: int, size: int) -> bool:
    """Make the file at least `size` bytes long; return whether there was room. For data that may be lost on a full
    disk."""
    try:
        reserve(descriptor, size)
    except OSError:
        return False
    return True


def write_whole(descriptor: int, data: bytes) -> None:
    """Write `data` at the beginning of the file. Raises OSError where there is no room for all of it."""
    if os.pwrite(descriptor, data, 0) < len(data):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def claim(part: Path) -> tuple[int, Path | None]:
    """Create an empty and locked file at `part`. Return its descriptor, and where the part of a killed run is kept now.

    Raises InputError where another run has it, or mbproj did not write it; OSError where it cannot be created.
    """
    rescued = None
    while True:
        try:
            descriptor = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            rescued = _clear(part) or rescued
            continue
        if lock(descriptor) and _is_at(descriptor, part):
            return descriptor, rescued
        os.close(descriptor)


def check_claimable(part: Path) -> None:
    """Raises InputError where `claim` would."""
    if is_locked(part):
        raise being_written(part, _writer(part))
    if part.is_symlink() or (part.exists() and not _is_blank(part) and identify(part) is Identity.FOREIGN):
        raise not_replaced(part)


def _clear(part: Path) -> Path | None:
    """Remove the file at `part`. Return the path under which it is kept; None where it held nothing."""
    check_claimable(part)
    worth_keeping = part.exists() and _holds_something(part)
    try:
        descriptor = os.open(part, os.O_RDWR)
    except FileNotFoundError:
        return None
    try:
        # Since the look at it another run may have locked the file, or removed it.
        if not lock(descriptor):
            raise being_written(part, _writer(part))
        if not _is_at(descriptor, part):
            return None
        if worth_keeping:
            return part.rename(_free_name(part))
        part.unlink()
        return None
    finally:
        os.close(descriptor)


def _is_at(descriptor: int, path: Path) -> bool:
    """Whether the open file is the one at `path`."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _is_blank(path: Path) -> bool:
    """Whether the file is empty, or has only zeros, from room that was reserved and not yet used."""
    with path.open("rb") as file:
        begin = file.read(MARGIN + 1)
    return len(begin) <= MARGIN and not any(begin)


def _holds_something(part: Path) -> bool:
    """Whether a part has samples, or is damaged: then somebody may want to save its content."""
    if _is_blank(part):
        return False
    try:
        with open_file(part) as contents:
            return contents.rows("time", ()) > 0
    except InputError:
        return True


def _writer(part: Path) -> str | None:
    """The process and host that write the part, for messages; None where the part does not have them yet."""
    try:
        with open_file(part) as contents:
            attributes = contents.attributes()
    except InputError:
        return None
    return f"process {attributes['pid']} on '{attributes['host']}'" if {"pid", "host"} <= attributes.keys() else None


def _free_name(part: Path) -> Path:
    """OUT.part.1, or the next number that is free."""
    names = (part.with_name(f"{part.name}.{number}") for number in count(1))
    return next(name for name in names if not name.exists())


# --- The /checkpoint group of a results file --------------------------------------------------------------------------
# A state between two steps, from which `mbproj continue` goes on.
# It is written beside the samples while the run goes on, into one of two slots in turn. A kill damages at most the
# slot that is being written; each has a checksum of its own.


SLOTS = "checkpoint/slots"
DESCRIPTION = "state between two steps, from which mbproj continue goes on; two slots, the newer one counts"
#: Bytes of a chunk: CHUNK_GROUND, and CHUNK_BODY for each body, whose state is a bit smaller; at most LARGEST_CHUNK.
CHUNK_GROUND, CHUNK_BODY, LARGEST_CHUNK = 1024, 512, 2**16
#: The head of a slot: the number of the write, from 0, how many bytes follow, their CRC-32.
HEAD = struct.Struct("<qqq")


class Checkpoint(NamedTuple):
    """The state that the next step depends on, in the coordinates of a `formulation`. `state` has, by name, arrays (n,)
    of float64, and plain data as in JSON. `build` names the program that wrote it."""

    formulation: str
    build: str
    state: Mapping[str, Any]


def create(file: h5py.File, bodies: int) -> None:
    """Create the group without a state; `bodies` sets the size of its chunks."""
    chunk = min(CHUNK_GROUND + CHUNK_BODY * bodies, LARGEST_CHUNK)
    data = file.create_dataset(SLOTS, (2, 0), "u1", maxshape=(2, None), chunks=(1, chunk))
    describe(data, {"description": DESCRIPTION})
    stamp(data, NOT_YET)


def pack(checkpoint: Checkpoint) -> bytes:
    """The bytes of a state: plain data, and the names and sizes of arrays, as JSON; then the arrays' numbers."""
    arrays = {name: np.ravel(value) for name, value in checkpoint.state.items() if isinstance(value, np.ndarray)}
    head = {
        "formulation": checkpoint.formulation,
        "build": checkpoint.build,
        "plain": {name: value for name, value in checkpoint.state.items() if name not in arrays},
        "arrays": [[name, len(array)] for name, array in arrays.items()],
    }
    text = json.dumps(head).encode()
    return struct.pack("<q", len(text)) + text + b"".join(array.astype("<f8").tobytes() for array in arrays.values())


@final
class Slots:
    """Writes the states of a run: holds the newest one, and counts those written."""

    def __init__(self) -> None:
        self._packed, self._written = b"", 0

    def take(self, checkpoint: Checkpoint) -> None:
        """Hold a state in the place of the one before, until `write`."""
        self._packed = pack(checkpoint)

    @property
    def room(self) -> int:
        """The most bytes that `write` adds to the file."""
        return 2 * (len(self._packed) + HEAD.size + LARGEST_CHUNK) if self._packed else 0

    def write(self, file: h5py.File) -> None:
        """Write the held state, where there is one, into the older slot."""
        if not self._packed:
            return
        whole = HEAD.pack(self._written, len(self._packed), zlib.crc32(self._packed)) + self._packed
        slots, newer, before = file[SLOTS], self._written % 2, file[SLOTS].shape[1]
        if before < len(whole):
            slots.resize(len(whole), axis=1)
            slots[:, before:] = 0  # the file has space for both slots
        slots[newer, : len(whole)] = np.frombuffer(whole, dtype=np.uint8)
        self._packed, self._written = b"", self._written + 1


def seal(file: h5py.File) -> None:
    """Store the checksum of the group, at the end of the run."""
    stamp(file[SLOTS], crc32(file[SLOTS][...]))


def read(contents: Contents) -> Checkpoint | None:
    """Read the newest state that is complete; None where there is none. Raises InputError where it is damaged."""
    if not contents.has(SLOTS):
        return None
    slots = contents.array(SLOTS, (2, None), np.uint8)
    whole = [checkpoint for checkpoint in (_slot(bytes(slot)) for slot in slots) if checkpoint is not None]
    try:
        return _unpack(max(whole)[1]) if whole else None
    except (ValueError, KeyError, TypeError, UnicodeDecodeError, struct.error, RecursionError) as error:
        raise contents.damaged(SLOTS, "does not hold a state") from error


def _slot(slot: bytes) -> tuple[int, bytes] | None:
    """The number of the write in a slot, and its bytes; None where the slot is empty, or its write was cut off."""
    if len(slot) < HEAD.size:
        return None
    writing, size, checksum = HEAD.unpack_from(slot)
    packed = slot[HEAD.size : HEAD.size + size] if size > 0 else b""
    return (writing, packed) if len(packed) == size > 0 and zlib.crc32(packed) == checksum else None


def _unpack(packed: bytes) -> Checkpoint:
    (length,) = struct.unpack_from("<q", packed)
    start = struct.calcsize("<q") + length
    head = json.loads(packed[struct.calcsize("<q") : start])
    state = dict(head["plain"])
    for name, size in head["arrays"]:
        if not (isinstance(name, str) and isinstance(size, int) and 0 <= size <= (len(packed) - start) // 8):
            raise ValueError(name)
        state[name] = np.frombuffer(packed, dtype="<f8", count=size, offset=start).copy()
        start += 8 * size
    if head["formulation"] not in FORMULATIONS or (state and not isfinite(state["t"])):
        raise ValueError("formulation or t")
    return Checkpoint(head["formulation"], str(head["build"]), state)


# --- Checks where results may be written ------------------------------------------------------------------------------
# Which files a run may replace.


def part_path(path: Path) -> Path:
    """The path OUT.part, to which a run writes until it has ended."""
    return path.with_name(path.name + ".part")


def check_output(path: Path) -> Path:
    """Return where results for `path` are written: `path`, or its target where it is a link.

    Raises InputError where a run cannot write there, or must not replace the file there.
    """
    try:
        path = Path(os.path.realpath(path)) if path.is_symlink() else path
        _check_directory(path)
        _check_kind(path)
        _check_replaceable(path)
        _check_kind(part_path(path))
        check_claimable(part_path(path))
    except OSError as error:
        raise cannot_write(path, error) from error
    return path


def _check_directory(path: Path) -> None:
    directory = path.parent
    if path.is_dir():
        raise is_directory(path)
    if not directory.exists():
        message = f"the directory '{directory}' of '{path}' does not exist"
        raise InputError(Problem(message, hint=f"create it, or {ELSEWHERE}"))
    if not directory.is_dir():
        raise InputError(Problem(f"'{directory}' is a file, not a directory", hint=ELSEWHERE))
    if not os.access(directory, os.W_OK | os.X_OK):
        raise InputError(Problem(f"cannot write '{path}': its directory takes no new files", hint=ELSEWHERE))


def _check_kind(path: Path) -> None:
    """Raises InputError where the file at `path` is of a kind that no run may touch."""
    if path.is_dir():
        raise is_directory(path)
    check_regular(path, ELSEWHERE)


def _check_replaceable(path: Path) -> None:
    whose = identify(path) if path.exists() else Identity.OURS
    if whose is Identity.FOREIGN:
        raise not_replaced(path)
    if whose is Identity.UNREADABLE:
        raise not_replaced_for_damage(path)
