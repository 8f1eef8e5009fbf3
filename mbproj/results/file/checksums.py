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

from mbproj.results.file.attributes import add_texts, put_integer

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
    found = {name: of_value(plain(value)) for name, value in group.attrs.items() if name != OF_ATTRIBUTES}
    group.attrs[OF_ATTRIBUTES] = json.dumps(found)


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
    found = value.item() if isinstance(value, np.generic) else value
    return found.decode() if isinstance(found, bytes) else found


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
