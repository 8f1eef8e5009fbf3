"""Writes attributes by HDF5's own calls. h5py first determines the type of each value and looks for an older attribute,
which takes four times as long."""

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
