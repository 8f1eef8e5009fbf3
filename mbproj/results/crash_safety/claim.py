"""A run claims OUT.part: it is locked before it has content, so that a kill at any moment blocks nobody.

A part whose lock a process holds is being written. Any other was left by a kill: one with samples is kept under another
name, one without is replaced.
"""

from __future__ import annotations

import os
from itertools import count
from pathlib import Path

from mbproj.errors import InputError
from mbproj.results.crash_safety.reserve import MARGIN
from mbproj.results.faults import being_written, not_replaced
from mbproj.results.file.lock import is_locked, lock
from mbproj.results.file.opening import Identity, identify, open_rehearsed


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
        # The owner of the lock may remove the file. Reading the file can lose the lock, so that we lock last.
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
        with open_rehearsed(part) as contents:
            return contents.rows("time", ()) > 0
    except InputError:
        return True


def _writer(part: Path) -> str | None:
    """The process and host that write the part, for messages; None where the part does not have them yet."""
    try:
        with open_rehearsed(part) as contents:
            attributes = contents.attributes()
    except InputError:
        return None
    return f"process {attributes['pid']} on '{attributes['host']}'" if {"pid", "host"} <= attributes.keys() else None


def _free_name(part: Path) -> Path:
    """OUT.part.1, or the next number that is free."""
    names = (part.with_name(f"{part.name}.{number}") for number in count(1))
    return next(name for name in names if not name.exists())
