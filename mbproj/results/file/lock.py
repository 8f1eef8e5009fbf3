"""Guards a results file: it has to be a regular file, and one run alone writes to it.

Opening a pipe or a device may block, so results are read from regular files only. A lock on OUT.part refuses a second
run with the same output, in another process or in a thread of this one. The lock belongs to the open file: it ends
where the last descriptor of that opening is closed, at the latest with the process. A record lock of POSIX would end
where the process closes any descriptor of the file, as a reader does. flock is the lock where the system has no other:
HDF5 has it too, so that other programs cannot read OUT.part there.
"""

from __future__ import annotations

import errno
import os
import stat
import struct
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

#: The struct flock of Linux: the kind of lock, from where its place counts, start, length (0: all of it), process.
RANGE = "hhqqi0q"


def lock(descriptor: int) -> bool:
    """Lock the open file until it is closed. Return False where it is locked by another opening, in this process or
    another; True also where locks are not available."""
    return fcntl is None or not _is_refused(descriptor, "F_OFD_SETLK", fcntl.LOCK_EX)


def is_locked(path: Path) -> bool:
    """Whether a run, of this process or another, has locked the file at `path`. Nothing else than a regular file is."""
    if fcntl is None:
        return False
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe would wait for who writes into it
    except OSError:
        return False
    try:
        return stat.S_ISREG(os.fstat(descriptor).st_mode) and _is_refused(descriptor, "F_OFD_GETLK", fcntl.LOCK_SH)
    finally:
        os.close(descriptor)


def _is_refused(descriptor: int, command: str, operation: int) -> bool:
    """Whether another opening has the lock. The `command` of open file descriptions either takes it, or asks for it;
    where the system or the file system does not know such locks, flock tries the `operation`."""
    wanted = struct.pack(RANGE, fcntl.F_WRLCK, 0, 0, 0, 0)
    try:
        if hasattr(fcntl, command):
            told = fcntl.fcntl(descriptor, getattr(fcntl, command), wanted)
            return command == "F_OFD_GETLK" and struct.unpack(RANGE, told)[0] != fcntl.F_UNLCK
    except (BlockingIOError, PermissionError):
        return True
    except OSError as error:
        if error.errno != errno.EINVAL:
            return False
    try:
        fcntl.flock(descriptor, operation | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False
