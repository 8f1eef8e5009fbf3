"""A lock on OUT.part, so that a second run with the same output is refused instead of mixing with the first.

POSIX record locks, because HDF5 locks with flock and would refuse its own readers. They end with the process.
"""

from __future__ import annotations

import os
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows, where a file that is open cannot be replaced anyway
    fcntl = None  # type: ignore[assignment]


def lock(descriptor: int) -> bool:
    """Lock the open file for this process, until any descriptor of the file is closed. Return False where another
    process has the lock; True also where locks are not available."""
    if fcntl is None:
        return True
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        return True
    return True


def is_locked(path: Path) -> bool:
    """Whether another process holds the lock on the regular file at `path`."""
    if fcntl is None or not path.exists():
        return False
    try:
        descriptor = os.open(path, os.O_RDWR)
    except OSError:
        return False
    try:
        return not lock(descriptor)
    finally:
        os.close(descriptor)
