"""Checksums in a file: the CRC-32 of each dataset's bytes, and of each attribute that mbproj wrote.

HDF5 guards its own bookkeeping, and Fletcher-32 guards each chunk of samples. These checksums guard the rest: data
without chunks, text attributes (in a heap without a checksum), and chunks that became zeros as a whole, which
Fletcher-32 accepts.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5a, h5s, h5t

#: The attribute with the checksum of a dataset; its value is NOT_YET while samples are added.
OF_DATA, NOT_YET = "crc32", -1
#: The attribute with the checksums of the other attributes of a group or a dataset: a JSON object by name.
OF_ATTRIBUTES = "crc32_of_attributes"


def crc32(values: npt.NDArray[Any], so_far: int = 0) -> int:
    """The checksum of an array's bytes as they are in the file; `so_far` is that of the bytes before. Texts of variable
    length are stored elsewhere, so that the checksum is that of their list."""
    if values.dtype.kind == "O":
        return of_value([plain(text) for text in values.reshape(-1).tolist()])
    stored = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return zlib.crc32(stored.reshape(-1).view(np.uint8).data, so_far) if stored.size else so_far


def stamp(dataset: h5py.Dataset, checksum: int) -> None:
    """Store the checksum of a dataset as its attribute."""
    put_integer(dataset, OF_DATA, checksum)


def stamp_attributes(group: h5py.Group) -> None:
    """Store the checksums of the attributes that the group has now."""
    sums = {name: of_value(plain(value)) for name, value in group.attrs.items() if name != OF_ATTRIBUTES}
    group.attrs[OF_ATTRIBUTES] = json.dumps(sums)


def describe(dataset: h5py.Dataset, texts: Mapping[str, str]) -> None:
    """Add attributes to a new dataset, texts by name, and their checksums."""
    checksums = {name: of_value(text) for name, text in texts.items()}
    add_texts(dataset, {**texts, OF_ATTRIBUTES: json.dumps(checksums)})


def of_value(value: Any) -> int:
    """The checksum of an attribute: a number, a flag, text, or a list of texts."""
    return zlib.crc32(json.dumps(value).encode())


def plain(value: Any) -> Any:
    """A value of NumPy as a number, text or list of Python."""
    if isinstance(value, np.ndarray):
        return [plain(item) for item in value.tolist()]
    simple = value.item() if isinstance(value, np.generic) else value
    return simple.decode() if isinstance(simple, bytes) else simple


def wrong_attributes(attributes: Mapping[str, Any]) -> list[str]:
    """The names of attributes that differ from their stored checksums; [] where the group has no checksums."""
    if OF_ATTRIBUTES not in attributes:
        return []
    try:
        expected = dict(json.loads(attributes[OF_ATTRIBUTES]))
    except (ValueError, TypeError, RecursionError):
        return [OF_ATTRIBUTES]
    return [name for name, checksum in expected.items() if _differs(attributes, name, checksum)]


def _differs(attributes: Mapping[str, Any], name: str, checksum: object) -> bool:
    return name not in attributes or of_value(attributes[name]) != checksum


ONE = h5s.create(h5s.SCALAR)
#: Text of any length, in the file and in memory.
STORED = h5t.py_create(h5py.string_dtype(), logical=True)
GIVEN = h5t.py_create(h5py.string_dtype())
#: The type in the file, by the type of a value.
KINDS = {str: STORED, int: h5t.NATIVE_INT64, float: h5t.NATIVE_DOUBLE}


def add_texts(place: h5py.Dataset | h5py.Group, texts: Mapping[str, str]) -> None:
    """Add each text under its name, which the object must not have yet."""
    for name, text in texts.items():
        h5a.create(place.id, name.encode(), STORED, ONE).write(np.array(text, dtype=object), mtype=GIVEN)


def put(place: h5py.Dataset | h5py.Group, values: Mapping[str, Any]) -> None:
    """Write each number, flag or text under its name; an attribute of that name is replaced."""
    for name, value in values.items():
        kind = KINDS.get(type(value))  # h5py writes numbers of NumPy, some of which are floats, too
        if kind is not None and name not in place.attrs:
            data = np.array(value, dtype=object if kind is STORED else None)
            h5a.create(place.id, name.encode(), kind, ONE).write(data, mtype=GIVEN if kind is STORED else None)
        else:
            place.attrs[name] = value


def put_integer(place: h5py.Dataset | h5py.Group, name: str, value: int) -> None:
    """Write an integer under a name; where the object has one of that name, it is overwritten."""
    named = name.encode()
    exists = h5a.exists(place.id, named)
    kept = h5a.open(place.id, named) if exists else h5a.create(place.id, named, h5t.STD_I64LE, ONE)
    kept.write(np.array(value, dtype=np.int64))
