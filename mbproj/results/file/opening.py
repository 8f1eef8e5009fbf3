"""Opens a results file, also while a run writes it or after a kill.

Groups and links are checked before any dataset is used: nothing in a results file may lead to another file.

HDF5 refuses a file that a kill has left, for a flag in its first bytes, the superblock. The superblock's version 3 is:
0 signature, 8 version, 9 and 10 sizes of addresses and lengths, 11 flags, 12 base, 20 extension, 28 end of file, 36
root, 44 checksum (HDF5 file format specification, III.A). h5py cannot clear the flags without writing to the file. Two
other ways were measured. HDF5's SWMR mode ignores the flags, but of 80 damaged parts 34 kept it waiting for ever. A
writer that closes the file at each flush leaves the flags, too, where the kill comes within a flush. So the file is
handed to HDF5 through an object that shows those 48 bytes as a closed file would have them.
"""

from __future__ import annotations

import errno
import io
import os
import stat
import struct
from collections.abc import Callable, Iterator
from contextlib import suppress
from enum import Enum, auto
from pathlib import Path
from typing import Any

import h5py
from h5py import h5d, h5g, h5l, h5o

from mbproj.base.errors import InputError, Problem
from mbproj.base.sandbox import is_growing, try_in_sandbox
from mbproj.results.faults import damaged, not_ours
from mbproj.results.file.checksums import plain
from mbproj.results.file.contents import CHUNK_CACHE, DAMAGE, Contents
from mbproj.results.layout import FORMAT

# --- Guards a results file --------------------------------------------------------------------------------------------
# It has to be a regular file, and one run alone writes to it.
# Opening a pipe or a device may block, so results are read from regular files only. A lock on OUT.part refuses a
# second run with the same output, in another process or in a thread of this one. The lock belongs to the open file:
# it ends where the last descriptor of that opening is closed, at the latest with the process. A record lock of POSIX
# would end where the process closes any descriptor of the file, as a reader does. flock is the lock where the system
# has no other: HDF5 has it too, so that other programs cannot read OUT.part there.


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


# --- Opens a results file, also while a run writes it or after a kill -------------------------------------------------


SIGNATURE = b"\x89HDF\r\n\x1a\n"
SIZE, FLAGS, END_OF_FILE, CHECKSUM = 48, 11, 28, 44


def is_open_for_writing(path: Path) -> bool:
    """Whether the flags say that a writer has the file open, or had it when it was killed. May raise OSError."""
    with path.open("rb") as file:
        head = file.read(SIZE)
    return len(head) == SIZE and head.startswith(SIGNATURE) and head[8] == 3 and head[FLAGS] != 0


class ClosedView(io.FileIO):
    """The file at `path` for reading, as HDF5 would have closed it: no flags, and the true end of file."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "rb")
        head = bytearray(super().read(SIZE))
        head[FLAGS] = 0
        head[END_OF_FILE : END_OF_FILE + 8] = struct.pack("<Q", path.stat().st_size)
        head[CHECKSUM:] = struct.pack("<I", lookup3(bytes(head[:CHECKSUM])))
        self._head = bytes(head)

    def readinto(self, buffer: Any) -> int:
        """Read bytes from the present position into `buffer`; return how many."""
        start, view = self.tell(), memoryview(buffer).cast("B")
        count = super().readinto(view) or 0
        if start < SIZE:
            head = self._head[start : start + count]
            view[: len(head)] = head
        return count


def lookup3(data: bytes) -> int:
    """Bob Jenkins's hash of 1 to any number of bytes, with which HDF5 guards its metadata."""
    mask = 0xFFFFFFFF
    words = struct.unpack(f"<{-(-len(data) // 12) * 3}I", data.ljust(-(-len(data) // 12) * 12, b"\0"))
    state = [(0xDEADBEEF + len(data)) & mask] * 3

    def rotated(value: int, bits: int) -> int:
        return (value << bits | value >> (32 - bits)) & mask

    for start in range(0, len(words), 3):
        state = [(value + word) & mask for value, word in zip(state, words[start : start + 3], strict=True)]
        if start + 3 == len(words):
            break
        for step, bits in enumerate((4, 6, 8, 16, 19, 4)):
            i, j, k = step % 3, (step + 1) % 3, (step + 2) % 3
            state[i] = ((state[i] - state[k]) & mask) ^ rotated(state[k], bits)
            state[k] = (state[k] + state[j]) & mask
    for step, bits in enumerate((14, 11, 25, 16, 4, 14, 24)):
        i, j = (step + 2) % 3, (step + 1) % 3
        state[i] = ((state[i] ^ state[j]) - rotated(state[j], bits)) & mask
    return state[2]


#: Links that name the place of an object. mbproj writes only hard links, which lead to an object of the file itself.
LINKS = {h5l.TYPE_SOFT: "a soft link", h5l.TYPE_EXTERNAL: "an external link"}


def check_structure(file: h5py.File, path: Path) -> None:
    """Raises InputError that names the first link out of the file, or the first dataset with its numbers in another.
    None of the other files is opened."""
    for name, what in _ways_out(file.id):
        message = f"'{path}': '{name}' is {what}, which could lead to another file"
        raise InputError(Problem(message, hint="a results file holds all of its data itself; repeat the run"))


def _ways_out(root: h5g.GroupID) -> Iterator[tuple[str, str]]:
    """Yield each link or dataset that leads out of the file, and its kind. Every object is visited once."""
    groups = [("", h5g.open(root, b"/"))]
    seen = {h5o.get_info(root).addr}
    while groups:
        prefix, group = groups.pop()
        for link, kind in _links(group):
            name = f"{prefix}/{link.decode('utf-8', 'replace')}"
            if kind != h5l.TYPE_HARD:
                yield name, LINKS.get(kind, "a link of an unknown kind")
                continue
            info = h5o.get_info(group, link)
            if info.addr in seen:
                continue
            seen.add(info.addr)
            if info.type == h5o.TYPE_GROUP:
                groups.append((name, h5g.open(group, link)))
            elif info.type == h5o.TYPE_DATASET:
                elsewhere = _storage_elsewhere(h5d.open(group, link))
                if elsewhere:
                    yield name, elsewhere


def _links(group: h5g.GroupID) -> list[tuple[bytes, int]]:
    links: list[tuple[bytes, int]] = []
    group.links.iterate(lambda name, info: links.append((name, info.type)), info=True)
    return links


def _storage_elsewhere(dataset: h5d.DatasetID) -> str | None:
    """The kind of a dataset whose numbers are in another file; None for others. Its properties tell; its shape is not
    asked for, since HDF5 would open other files for that of a virtual dataset."""
    properties = dataset.get_create_plist()
    if properties.get_layout() == h5d.VIRTUAL:
        return "a virtual dataset"
    if properties.get_external_count():
        return "a dataset in external storage"
    return None


NEEDED = "results are what 'mbproj run SCENE' writes"
#: The fault of a file that has the signature of HDF5, but that HDF5 cannot open.
UNFINISHED = "the run that wrote it was killed before its first samples, or the file was cut short"


class Identity(Enum):
    """Whether mbproj wrote a file."""

    OURS = auto()
    FOREIGN = auto()
    UNREADABLE = auto()


def open_file(path: Path, act: Callable[[Contents], object] | None = None, name: str = "") -> Contents:
    """Open the file at `path`, after the sandbox has opened it and done `act`, the reader's next step. An act with a
    `name` is tried once for each state of the file. Without an act, attributes are read. Raises InputError where HDF5
    cannot open it, or it has links to other files."""
    if act is None:
        act, name = Contents.attributes, "attributes"
    try:
        check_regular(path, NEEDED)
        looked_over = try_in_sandbox(lambda: act(_open_contents(path)), path, name)
    except OSError as error:
        raise unreadable(path) from error
    return _open_contents(path, looked_over=looked_over)


def _open_contents(path: Path, *, looked_over: bool = False) -> Contents:
    """Open the file at `path`. Raises InputError where HDF5 cannot open it, or it has links to other files.
    `looked_over`: it is known to have no such fault. For a damaged file HDF5 may not return."""
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
        if is_growing(path):  # HDF5 writes to no file that the same process has open for reading
            raise BlockingIOError
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
        try_in_sandbox(lambda: _format_of(path), path, "format")
        if _format_of(path) == FORMAT:
            return Identity.OURS
        with open_file(path) as contents:  # raises InputError where damage may hide the format
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
