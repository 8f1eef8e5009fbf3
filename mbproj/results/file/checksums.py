"""Checksums in a file: the CRC-32 of each dataset's bytes, and of each attribute that mbproj wrote.

HDF5 guards its own bookkeeping, and Fletcher-32 guards each chunk of samples. These checksums guard the rest: data
without chunks, text attributes (in a heap without a checksum), and chunks that became zeros as a whole, which
Fletcher-32 accepts.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5a, h5d, h5p, h5s, h5t

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
    attribute = h5a.open(place.id, named) if exists else h5a.create(place.id, named, h5t.STD_I64LE, ONE)
    attribute.write(np.array(value, dtype=np.int64))


# --- Writes arrays that do not grow, each at once ---------------------------------------------------------------------
# Numbers, texts, and groups of records with one dataset for each field.
# Records are empty at the start of a run, and filled at its end.


#: The property by which a dataset is created together with the groups in its path.
GROUPS_TOO = h5p.create(h5p.LINK_CREATE)
GROUPS_TOO.set_create_intermediate_group(True)


def as_text(name: str) -> str:
    """A text for HDF5, which may have a path in it: bytes of a file name that are no text are written as \\udcff."""
    return name.encode(errors="backslashreplace").decode()


def create_whole(group: h5py.Group, path: str, values: npt.NDArray[Any]) -> h5py.Dataset:
    """Write an array of fixed size."""
    kind = h5t.py_create(values.dtype, logical=True)
    properties = h5p.create(h5p.DATASET_CREATE)
    properties.set_obj_track_times(False)
    space = h5s.create_simple(values.shape) if values.shape else h5s.create(h5s.SCALAR)
    created = h5d.create(group.id, path.encode(), kind, space, properties, GROUPS_TOO)
    if values.size:
        created.write(h5s.ALL, h5s.ALL, values, mtype=kind)
    return h5py.Dataset(created)


def create_text(group: h5py.Group, path: str, texts: str | Sequence[str], description: str) -> None:
    """Write a dataset of UTF-8 strings of one length, which are stored in place; others would need HDF5's heap."""
    listed = [texts] if isinstance(texts, str) else list(texts)
    encoded = [as_text(text).encode() for text in listed]
    kind = h5py.string_dtype("utf-8", max([1, *map(len, encoded)]))
    data = np.array(encoded, dtype=kind)
    dataset = create_whole(group, path, data.reshape(() if isinstance(texts, str) else (-1,)))
    describe(dataset, {"description": description, "_Encoding": "utf-8"})
    stamp(dataset, crc32(data))


#: The most bytes of a text; longer ones are cut.
LONGEST = 200
TEXT = h5py.string_dtype("utf-8", LONGEST)
#: The HDF5 type of an entry, its unit and its description, by field.
Fields: TypeAlias = Mapping[str, tuple[Any, str, str]]


def create_records(file: h5py.File, group: str, fields: Fields) -> None:
    """Create the group without records: the file must have its whole structure from the start."""
    for name, (dtype, unit, description) in fields.items():
        data = file.create_dataset(f"{group}/{name}", (0,), dtype, maxshape=(None,), chunks=(64,), fletcher32=True)
        describe(data, {"units": unit, "description": description} if unit else {"description": description})
        stamp(data, NOT_YET)


def room_for_records(count: int, fields: Fields) -> int:
    """The most bytes that `count` records add to the file: those of the texts, with a margin for the numbers."""
    return (count + 64) * sum(LONGEST + 64 for dtype, _, _ in fields.values() if dtype is TEXT)


def write_records(file: h5py.File, group: str, fields: Fields, records: Sequence[Any]) -> None:
    """Write the records into the group: each field from the attribute of that name."""
    for name, (dtype, _, _) in fields.items():
        values = [getattr(record, name) for record in records]
        data = np.array([_cut_bytes(value) for value in values] if dtype is TEXT else values, dtype=dtype)
        dataset = file[group][name]
        dataset.resize(data.shape)
        if data.size:
            dataset[...] = data
        stamp(dataset, crc32(data))


def _cut_bytes(text: str) -> bytes:
    """The text in UTF-8, cut to the characters that fit as a whole."""
    return text.encode()[:LONGEST].decode(errors="ignore").encode()
