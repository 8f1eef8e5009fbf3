"""Results files on disk: which may be replaced, how one is opened that may have been left by a kill, what can fail."""

from __future__ import annotations

import os
from pathlib import Path

import h5py

from mbproj.errors import InputError, Problem
from mbproj.results.faults import ELSEWHERE, cannot_write, is_directory, not_replaced
from mbproj.results.layout import FORMAT
from mbproj.results.lock import is_locked
from mbproj.results.superblock import ClosedView, is_open_for_writing

#: What h5py raises where the bytes of a file are not what they should be.
DAMAGE = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, MemoryError, OverflowError)


def part_path(path: Path) -> Path:
    """OUT.part, where a run writes until it has ended."""
    return path.with_name(path.name + ".part")


def open_file(path: Path) -> h5py.File:
    """The HDF5 file for reading, also while a run writes it or after a kill; one of `DAMAGE` where that cannot be."""
    if not is_open_for_writing(path):
        return h5py.File(path, "r", locking=False)
    if is_locked(path):
        return h5py.File(path, "r", swmr=True, locking=False)
    return h5py.File(ClosedView(path), "r")


def is_ours(path: Path) -> bool:
    """Whether the file at `path` is a results file of mbproj, of any schema version."""
    try:
        with open_file(path) as file:
            return bool(file.attrs["format"] == FORMAT)
    except DAMAGE:
        return False


def check_output(path: Path) -> Path:
    """Where results for `path` are written: `path`, or what it is a link to.

    Raises InputError where a run could not write there or must not replace what is there.
    """
    try:
        path = Path(os.path.realpath(path)) if path.is_symlink() else path
        _check_directory(path)
        for existing in (path, part_path(path)):
            _check_replaceable(existing)
    except OSError as error:
        raise cannot_write(path, error) from error
    if is_locked(part_path(path)):
        raise InputError(Problem(f"another run is writing '{part_path(path)}'", hint=f"wait for it, or {ELSEWHERE}"))
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


def _check_replaceable(path: Path) -> None:
    if path.is_dir():
        raise is_directory(path)
    if path.exists() and not is_ours(path):
        raise not_replaced(path)
