"""The door: how a results file is opened, also while a run writes it or after a kill."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from enum import Enum, auto
from pathlib import Path

import h5py

from mbproj.errors import InputError, Problem
from mbproj.rehearsal import rehearse
from mbproj.results.faults import damaged, not_ours
from mbproj.results.file.checksums import plain
from mbproj.results.file.contents import Contents
from mbproj.results.file.dataset import CHUNK_CACHE, DAMAGE
from mbproj.results.file.lock import is_locked
from mbproj.results.file.regular import check_regular
from mbproj.results.file.structure import check_structure
from mbproj.results.file.superblock import SIGNATURE, ClosedView, is_open_for_writing
from mbproj.results.layout import FORMAT

NEEDED = "results are what 'mbproj run SCENE' writes"
#: What is wrong with a file that begins as HDF5 does and that HDF5 cannot open.
UNFINISHED = "the run that wrote it was killed before its first samples, or the file was cut short"


class Identity(Enum):
    """Whose a file is."""

    OURS = auto()
    FOREIGN = auto()
    UNREADABLE = auto()


def open_rehearsed(path: Path, act: Callable[[Contents], object] = Contents.attributes) -> Contents:
    """The file at `path`, after that and `act`, what the reader is about to do, were rehearsed. Raises InputError where
    HDF5 cannot open it, or it leads out of itself."""
    try:
        check_regular(path, NEEDED)
        looked_over = rehearse(lambda: act(_open_contents(path)), path)
    except OSError as error:
        raise unreadable(path) from error
    return _open_contents(path, looked_over=looked_over)


def open_own(path: Path) -> Contents:
    """A file that this process has just written, which needs no rehearsal."""
    return _open_contents(path, looked_over=True)


def _open_contents(path: Path, *, looked_over: bool = False) -> Contents:
    """The file at `path`. Raises InputError where HDF5 cannot open it, or it leads out of itself; `looked_over`: a
    child has seen that it does not. HDF5 may not come back from here."""
    try:
        check_regular(path, NEEDED)
        unfinished = is_open_for_writing(path)
        file = _open(path, unfinished)
    except DAMAGE as error:
        raise unreadable(path) from error
    try:
        if not looked_over:
            check_structure(file, path)
        return Contents(file, path, unfinished=unfinished)
    except DAMAGE as error:
        file.close()
        raise damaged(path, "its groups cannot be read") from error
    except BaseException:
        file.close()
        raise


def _open(path: Path, unfinished: bool) -> h5py.File:
    if not unfinished:
        with suppress(OSError):  # a program may open it too, and in one process all have to lock a file, or none
            return h5py.File(path, "r", **CHUNK_CACHE)
        return h5py.File(path, "r", locking=False, **CHUNK_CACHE)
    if is_locked(path):
        return h5py.File(path, "r", swmr=True, locking=False, **CHUNK_CACHE)
    return h5py.File(ClosedView(path), "r", **CHUNK_CACHE)


def identify(path: Path) -> Identity:
    """Whose the regular file at `path` is, whatever its schema version. May raise OSError."""
    if not has_signature(path):
        return Identity.FOREIGN
    try:
        rehearse(lambda: _format_of(path), path)
        if _format_of(path) == FORMAT:
            return Identity.OURS
        with open_rehearsed(path) as contents:  # it may be hidden by what is damaged
            ours = contents.attributes().get("format") == FORMAT
    except InputError:
        return Identity.UNREADABLE
    return Identity.OURS if ours else Identity.FOREIGN


def _format_of(path: Path) -> object:
    """The attribute that says whose the file is; nothing else of it is looked at."""
    try:
        with _open(path, is_open_for_writing(path)) as file:
            return plain(file.attrs.get("format"))
    except DAMAGE as error:
        raise unreadable(path) from error


def unreadable(path: Path) -> InputError:
    """What is wrong with a file that HDF5 cannot open."""
    try:
        return damaged(path, UNFINISHED) if has_signature(path) else not_ours(path)
    except OSError as error:
        return InputError(Problem(f"cannot read '{path}': {error.strerror}", hint="check who may read it"))


def has_signature(path: Path) -> bool:
    """Whether the file at `path` begins as HDF5 does. May raise OSError."""
    with path.open("rb") as file:
        return file.read(len(SIGNATURE)) == SIGNATURE
