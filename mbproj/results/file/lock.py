"""Guards a results file: it has to be a regular file, and one run alone writes to it.

Opening a pipe or a device may block, so results are read from regular files only. A lock on OUT.part refuses a second
run with the same output. POSIX record locks, because HDF5 locks with flock and would refuse its own readers. They end
with the process.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from mbproj.errors import InputError, Problem

KINDS = (
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def what_else(path: Path) -> str | None:
    """The kind of `path`, or of its target, where that is no regular file, as "a named pipe". None for a regular file,
    a directory, and a path without a file. May raise OSError."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return None
    return next((name for holds, name in KINDS if holds(mode)), None)


def check_regular(path: Path, hint: str) -> None:
    """Raises InputError where opening `path` may block. May raise OSError."""
    kind = what_else(path)
    if kind is not None:
        raise InputError(Problem(f"'{path}' is {kind}, not a results file", hint=hint))


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
