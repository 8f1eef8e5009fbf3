"""Checks the kind of file at a path: results are read from regular files only. Opening a pipe or a device may block."""

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
