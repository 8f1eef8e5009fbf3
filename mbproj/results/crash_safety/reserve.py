"""Room on the disk is taken before HDF5 writes: a write that fails inside HDF5 leaves it unable to close its file."""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Iterable

import h5py

#: Room for HDF5's own bookkeeping of one flush, and for the attributes at the end.
MARGIN = 2**20
#: What Fletcher-32 adds to a chunk.
CHECKSUM = 4
FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EIO)


def room_for(file: h5py.File, datasets: Iterable[h5py.Dataset], samples: int) -> int:
    """The size in bytes that the file may reach when `datasets` grow to `samples`."""
    growth = 0
    for dataset in datasets:
        shape, chunk = dataset.shape, dataset.chunks[0]
        new_chunks = -(-samples // chunk) - -(-shape[0] // chunk)
        row_bytes = dataset.dtype.itemsize * math.prod(shape[1:])
        growth += max(0, new_chunks) * (chunk * row_bytes + CHECKSUM)
    return int(file.id.get_filesize()) + growth + MARGIN


def reserve(descriptor: int, size: int) -> None:
    """Make the file at least `size` bytes long, on the disk. Raises OSError where there is no room for that."""
    if not hasattr(os, "posix_fallocate") or os.fstat(descriptor).st_size >= size:
        return
    try:
        os.posix_fallocate(descriptor, 0, size)
    except OSError as error:
        if error.errno in FULL:
            raise


def write_whole(descriptor: int, data: bytes) -> None:
    """Write `data` at the begin of the file. Raises OSError where not all of it has room."""
    if os.pwrite(descriptor, data, 0) < len(data):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
