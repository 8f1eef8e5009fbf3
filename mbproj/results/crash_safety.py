"""A run claims OUT.part: it is locked before it has content, so that a kill at any moment blocks nobody.

A part whose lock a process holds is being written. A part without such a process was left by a kill. It is kept under
another name where it has samples, else replaced.

Room on the disk is reserved before HDF5 writes: after a write that fails, HDF5 cannot close its file any more.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable
from itertools import count
from pathlib import Path

import h5py

from mbproj.errors import InputError
from mbproj.results.faults import being_written, not_replaced
from mbproj.results.file.lock import is_locked, lock
from mbproj.results.file.opening import Identity, identify, open_file

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
    kept = None
    while True:
        try:
            descriptor = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            kept = _clear(part) or kept
            continue
        if lock(descriptor) and _is_at(descriptor, part):
            return descriptor, kept
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
