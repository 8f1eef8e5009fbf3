"""Changes of a file's bytes: what disks, transfers and crashes do."""

from __future__ import annotations

import random
import struct
from collections.abc import Callable
from pathlib import Path

from mbproj.results.file.opening import CHECKSUM, FLAGS, lookup3


def bits(data: bytearray, draw: random.Random) -> str:
    """Flips some bits where the file is used."""
    places = [_used(data, draw) for _ in range(draw.choice([1, 1, 3, 20]))]
    for place in places:
        data[place] ^= 1 << draw.randrange(8)
    return f"bits at {places[:3]}"


def page(data: bytearray, draw: random.Random) -> str:
    """Zeros, ones or noise in place of a page."""
    size = 2 ** draw.randrange(6, 17)
    start = _used(data, draw) // size * size if draw.random() < 0.7 else _used(data, draw)
    length = len(data[start : start + size])
    data[start : start + size] = draw.choice([bytes(length), b"\xff" * length, draw.randbytes(length)])
    return f"a page of {size} at {start}"


def cut(data: bytearray, draw: random.Random) -> str:
    """The file ends too early, or zeros follow."""
    start = draw.randrange(len(data))
    keep = draw.random() < 0.5
    data[start:] = bytes(len(data) - start) if keep else b""
    return f"{'zeros' if keep else 'nothing'} from {start} on"


def moved(data: bytearray, draw: random.Random) -> str:
    """A part of the file stands in another place too."""
    size = draw.choice([8, 64, 512, 4096])
    source, target = _used(data, draw), _used(data, draw)
    part = bytes(data[source : source + size])
    data[target : target + len(part)] = part
    return f"{size} bytes of {source} at {target} too"


def word(data: bytearray, draw: random.Random) -> str:
    """A number of HDF5's own bookkeeping becomes another."""
    place, width = _used(data, draw), draw.choice([1, 2, 4, 8])
    value = draw.choice([0, 1, 2 ** (8 * width) - 1, 2 ** (8 * width - 1), draw.randrange(2 ** (8 * width))])
    data[place : place + width] = value.to_bytes(width, "little")
    return f"{value} in {width} bytes at {place}"


def left_open(data: bytearray, draw: random.Random) -> str:
    """As a killed run leaves it, and a bit flipped."""
    data[FLAGS] = draw.choice([1, 5])
    data[CHECKSUM : CHECKSUM + 4] = struct.pack("<I", lookup3(bytes(data[:CHECKSUM])))
    return f"left open, {draw.choice([bits, page, word])(data, draw)}"


def resealed(data: bytearray, draw: random.Random) -> str:
    """A word of an object header becomes another, and the checksum of the header is made to fit: HDF5 believes it."""
    starts = [place for place in _all(data, b"OHDR") if place + 16 < len(data)]
    if not starts:
        return bits(data, draw)
    start = draw.choice(starts)
    end = _end_of_header(data, start)
    place = draw.randrange(start + 5, max(end, start + 6))
    data[place] = draw.choice([0, 255, data[place] ^ 1 << draw.randrange(8)])
    data[end : end + 4] = struct.pack("<I", lookup3(bytes(data[start:end])))
    return f"byte {place} of the header at {start}, sealed again"


CHANGES: tuple[Callable[[bytearray, random.Random], str], ...] = (bits, page, cut, moved, word, left_open, resealed)


def change_bytes(path: Path, draw: random.Random) -> str:
    """Changes the file at `path`; says how."""
    data = bytearray(path.read_bytes())
    change = draw.choice(CHANGES)
    said = change(data, draw)
    path.write_bytes(data)
    return f"{change.__name__}: {said}"


def _used(data: bytearray, draw: random.Random) -> int:
    """A place that is not among many zeros."""
    for _ in range(100):
        place = draw.randrange(len(data))
        if any(data[place : place + 16]):
            return place
    return draw.randrange(len(data))


def _all(data: bytearray, mark: bytes) -> list[int]:
    found, start = [], data.find(mark)
    while start >= 0:
        found.append(start)
        start = data.find(mark, start + 1)
    return found


def _end_of_header(data: bytearray, start: int) -> int:
    """Where the checksum of an object header (version 2) stands: HDF5 file format specification, IV.A.1.b."""
    flags = data[start + 5]
    place = start + 6 + (16 if flags & 0x20 else 0) + (4 if flags & 0x10 else 0)
    width = 1 << (flags & 3)
    return min(place + width + int.from_bytes(data[place : place + width], "little"), len(data) - 4)
