"""What stands at a path: results are read from regular files only. A pipe or a device would block whoever opens it."""

from __future__ import annotations

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
    """What `path`, or what it is a link to, is in place of a regular file ("a named pipe"); None for a regular file, a
    directory, and where there is nothing. May raise OSError."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return None
    return next((name for holds, name in KINDS if holds(mode)), None)


def check_regular(path: Path, hint: str) -> None:
    """Raises InputError where `path` is something that cannot be opened without waiting. May raise OSError."""
    kind = what_else(path)
    if kind is not None:
        raise InputError(Problem(f"'{path}' is {kind}, not a results file", hint=hint))
