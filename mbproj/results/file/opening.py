"""Opens a results file, also while a run writes it or after a kill."""

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
#: The fault of a file that has the signature of HDF5, but that HDF5 cannot open.
UNFINISHED = "the run that wrote it was killed before its first samples, or the file was cut short"


class Identity(Enum):
    """Whether mbproj wrote a file."""

    OURS = auto()
    FOREIGN = auto()
    UNREADABLE = auto()


def open_rehearsed(path: Path, act: Callable[[Contents], object] = Contents.attributes) -> Contents:
    """Open the file at `path`, after a rehearsal of that and of `act`, which the reader will do next. Raises InputError
    where HDF5 cannot open it, or it has links to other files."""
    try:
        check_regular(path, NEEDED)
        looked_over = rehearse(lambda: act(_open_contents(path)), path)
    except OSError as error:
        raise unreadable(path) from error
    return _open_contents(path, looked_over=looked_over)


def open_own(path: Path) -> Contents:
    """Open a file that this process has just written, which needs no rehearsal."""
    return _open_contents(path, looked_over=True)


def _open_contents(path: Path, *, looked_over: bool = False) -> Contents:
    """Open the file at `path`. Raises InputError where HDF5 cannot open it, or it has links to other files;
    `looked_over`: a child process has found none. For a damaged file HDF5 may not return."""
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
        with suppress(OSError):  # the process may have it open without a lock; then all must open it so
            return h5py.File(path, "r", **CHUNK_CACHE)
        return h5py.File(path, "r", locking=False, **CHUNK_CACHE)
    if is_locked(path):
        return h5py.File(path, "r", swmr=True, locking=False, **CHUNK_CACHE)
    return h5py.File(ClosedView(path), "r", **CHUNK_CACHE)


def identify(path: Path) -> Identity:
    """Whether mbproj wrote the regular file at `path`, in any schema version. May raise OSError."""
    if not has_signature(path):
        return Identity.FOREIGN
    try:
        rehearse(lambda: _format_of(path), path)
        if _format_of(path) == FORMAT:
            return Identity.OURS
        with open_rehearsed(path) as contents:  # raises InputError where damage may hide the format
            ours = contents.attributes().get("format") == FORMAT
    except InputError:
        return Identity.UNREADABLE
    return Identity.OURS if ours else Identity.FOREIGN


def _format_of(path: Path) -> object:
    """The attribute `format` of the file; nothing else is read."""
    try:
        with _open(path, is_open_for_writing(path)) as file:
            return plain(file.attrs.get("format"))
    except DAMAGE as error:
        raise unreadable(path) from error


def unreadable(path: Path) -> InputError:
    """The error of a file that HDF5 cannot open."""
    try:
        return damaged(path, UNFINISHED) if has_signature(path) else not_ours(path)
    except OSError as error:
        return InputError(Problem(f"cannot read '{path}': {error.strerror}", hint="check who may read it"))


def has_signature(path: Path) -> bool:
    """Whether the file at `path` begins with the signature of HDF5. May raise OSError."""
    with path.open("rb") as file:
        return file.read(len(SIGNATURE)) == SIGNATURE
