"""The /checkpoint group of a results file: a state between two steps, from which `mbproj continue` goes on.

It is written beside the samples while the run goes on, into one of two slots in turn. A kill damages at most the slot
that is being written; each has a checksum of its own.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping
from math import isfinite
from typing import Any, NamedTuple, final

import h5py
import numpy as np

from mbproj.registry import FORMULATIONS
from mbproj.results.file.checksums import NOT_YET, crc32, describe, stamp
from mbproj.results.file.contents import Contents

SLOTS = "checkpoint/slots"
DESCRIPTION = "state between two steps, from which mbproj continue goes on; two slots, the newer one counts"
#: Bytes of a chunk: CHUNK_GROUND, and CHUNK_BODY for each body, whose state is a bit smaller; at most LARGEST_CHUNK.
CHUNK_GROUND, CHUNK_BODY, LARGEST_CHUNK = 1024, 512, 2**16
#: The head of a slot: the number of the write, from 0, how many bytes follow, their CRC-32.
HEAD = struct.Struct("<qqq")


class Checkpoint(NamedTuple):
    """The state that the next step depends on, in the coordinates of a `formulation`. `state` has, by name, arrays (n,)
    of float64, and plain data as in JSON. `build` names the program that wrote it."""

    formulation: str
    build: str
    state: Mapping[str, Any]


def create(file: h5py.File, bodies: int) -> None:
    """Create the group without a state; `bodies` sets the size of its chunks."""
    chunk = min(CHUNK_GROUND + CHUNK_BODY * bodies, LARGEST_CHUNK)
    data = file.create_dataset(SLOTS, (2, 0), "u1", maxshape=(2, None), chunks=(1, chunk))
    describe(data, {"description": DESCRIPTION})
    stamp(data, NOT_YET)


def pack(checkpoint: Checkpoint) -> bytes:
    """The bytes of a state: plain data, and the names and sizes of arrays, as JSON; then the arrays' numbers."""
    arrays = {name: np.ravel(value) for name, value in checkpoint.state.items() if isinstance(value, np.ndarray)}
    head = {
        "formulation": checkpoint.formulation,
        "build": checkpoint.build,
        "plain": {name: value for name, value in checkpoint.state.items() if name not in arrays},
        "arrays": [[name, len(array)] for name, array in arrays.items()],
    }
    text = json.dumps(head).encode()
    return struct.pack("<q", len(text)) + text + b"".join(array.astype("<f8").tobytes() for array in arrays.values())


@final
class Slots:
    """Writes the states of a run: holds the newest one, and counts those written."""

    def __init__(self) -> None:
        self._packed, self._written = b"", 0

    def take(self, checkpoint: Checkpoint) -> None:
        """Hold a state in the place of the one before, until `write`."""
        self._packed = pack(checkpoint)

    @property
    def room(self) -> int:
        """The most bytes that `write` adds to the file."""
        return 2 * (len(self._packed) + HEAD.size + LARGEST_CHUNK) if self._packed else 0

    def write(self, file: h5py.File) -> None:
        """Write the held state, where there is one, into the older slot."""
        if not self._packed:
            return
        whole = HEAD.pack(self._written, len(self._packed), zlib.crc32(self._packed)) + self._packed
        slots, newer, before = file[SLOTS], self._written % 2, file[SLOTS].shape[1]
        if before < len(whole):
            slots.resize(len(whole), axis=1)
            slots[:, before:] = 0  # the file has space for both slots
        slots[newer, : len(whole)] = np.frombuffer(whole, dtype=np.uint8)
        self._packed, self._written = b"", self._written + 1


def seal(file: h5py.File) -> None:
    """Store the checksum of the group, at the end of the run."""
    stamp(file[SLOTS], crc32(file[SLOTS][...]))


def read(contents: Contents) -> Checkpoint | None:
    """Read the newest state that is complete; None where there is none. Raises InputError where it is damaged."""
    if not contents.has(SLOTS):
        return None
    slots = contents.array(SLOTS, (2, None), np.uint8)
    whole = [checkpoint for checkpoint in (_slot(bytes(slot)) for slot in slots) if checkpoint is not None]
    try:
        return _unpack(max(whole)[1]) if whole else None
    except (ValueError, KeyError, TypeError, UnicodeDecodeError, struct.error, RecursionError) as error:
        raise contents.damaged(SLOTS, "does not hold a state") from error


def _slot(slot: bytes) -> tuple[int, bytes] | None:
    """The number of the write in a slot, and its bytes; None where the slot is empty, or its write was cut off."""
    if len(slot) < HEAD.size:
        return None
    writing, size, checksum = HEAD.unpack_from(slot)
    packed = slot[HEAD.size : HEAD.size + size] if size > 0 else b""
    return (writing, packed) if len(packed) == size > 0 and zlib.crc32(packed) == checksum else None


def _unpack(packed: bytes) -> Checkpoint:
    (length,) = struct.unpack_from("<q", packed)
    start = struct.calcsize("<q") + length
    head = json.loads(packed[struct.calcsize("<q") : start])
    state = dict(head["plain"])
    for name, size in head["arrays"]:
        if not (isinstance(name, str) and isinstance(size, int) and 0 <= size <= (len(packed) - start) // 8):
            raise ValueError(name)
        state[name] = np.frombuffer(packed, dtype="<f8", count=size, offset=start).copy()
        start += 8 * size
    if head["formulation"] not in FORMULATIONS or (state and not isfinite(state["t"])):
        raise ValueError("formulation or t")
    return Checkpoint(head["formulation"], str(head["build"]), state)
