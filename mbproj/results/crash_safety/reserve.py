"""Reserves room on the disk before HDF5 writes: after a write that fails, HDF5 cannot close its file any more."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable

import h5py

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
    """Make the file at least `size` bytes long; return whether there was room. For data that a full disk may lose."""
    try:
        reserve(descriptor, size)
    except OSError:
        return False
    return True


def write_whole(descriptor: int, data: bytes) -> None:
    """Write `data` at the beginning of the file. Raises OSError where there is no room for all of it."""
    if os.pwrite(descriptor, data, 0) < len(data):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
