"""Reads a results file that a kill has left: HDF5 refuses it for a flag in its first bytes, the superblock.

The superblock's version 3 is: 0 signature, 8 version, 9 and 10 sizes of addresses and lengths, 11 flags, 12 base,
20 extension, 28 end of file, 36 root, 44 checksum (HDF5 file format specification, III.A). h5py cannot clear the flags
without writing to the file, and its SWMR mode, which ignores them, retries for ever where the file is damaged; so the
file is handed to HDF5 through an object that shows those 48 bytes as a closed file would have them.
"""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

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
