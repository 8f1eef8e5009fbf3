"""Checks where results may be written: which files a run may replace."""

from __future__ import annotations

import os
from pathlib import Path

from mbproj.errors import InputError, Problem
from mbproj.results.crash_safety.claim import check_claimable
from mbproj.results.faults import ELSEWHERE, cannot_write, is_directory, not_replaced, not_replaced_for_damage
from mbproj.results.file.lock import check_regular
from mbproj.results.file.opening import Identity, identify


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
