"""New attributes of a new object, written by HDF5's own calls: h5py looks for each value's type and for an older
attribute of the name first, which takes four times as long."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5s, h5t

ONE = h5s.create(h5s.SCALAR)
#: Text of any length, in the file and in memory.
STORED = h5t.py_create(h5py.string_dtype(), logical=True)
GIVEN = h5t.py_create(h5py.string_dtype())
#: By the type of a value, what is in the file.
KINDS = {str: STORED, int: h5t.NATIVE_INT64, float: h5t.NATIVE_DOUBLE}


def add_texts(place: h5py.Dataset | h5py.Group, texts: Mapping[str, str]) -> None:
    """Each text under its name, which the object must not have yet."""
    for name, text in texts.items():
        h5a.create(place.id, name.encode(), STORED, ONE).write(np.array(text, dtype=object), mtype=GIVEN)


def put(place: h5py.Dataset | h5py.Group, values: Mapping[str, Any]) -> None:
    """Each number, flag or text under its name; in the place of one that has the name already."""
    for name, value in values.items():
        kind = KINDS.get(type(value))  # a number of NumPy, which may be a float too, is h5py's
        if kind is not None and name not in place.attrs:
            data = np.array(value, dtype=object if kind is STORED else None)
            h5a.create(place.id, name.encode(), kind, ONE).write(data, mtype=GIVEN if kind is STORED else None)
        else:
            place.attrs[name] = value


def put_integer(place: h5py.Dataset | h5py.Group, name: str, value: int) -> None:
    """An integer under a name, which the object may have already for one."""
    named = name.encode()
    exists = h5a.exists(place.id, named)
    kept = h5a.open(place.id, named) if exists else h5a.create(place.id, named, h5t.STD_I64LE, ONE)
    kept.write(np.array(value, dtype=np.int64))
