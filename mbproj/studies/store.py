"""Values of studies, stored by the data that determine them, with the code of mbproj and of plug-ins.

A value is stored as bytes that hold data only: numbers, text, lists, tuples, mappings, arrays, and records of classes
that the reader names. Any other bytes raise ValueError.

    crc32 of the rest (4 bytes) | length of the text (8 bytes) | JSON | the arrays one after another

In the JSON, a value that is neither a number, a text nor a list is an object whose single key names its type.
"""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Callable, ItemsView, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import cache
from math import prod
from pathlib import Path
from typing import Any, TypeVar
from zlib import crc32

import numpy as np

import mbproj
from mbproj.arrays import Array
from mbproj.kernel import build_info, core
from mbproj.plugins import marks
from mbproj.studies.store import database

Value = TypeVar("Value")


def cached(what: Any, compute: Callable[[], Value], records: Sequence[type]) -> Value:
    """Return the value for the key `what` (any JSON data): from the store, or by `compute`. `records`: the classes of
    the records in the value."""
    study = key_of(what)
    for data in database.read(study).values():
        with suppress(ValueError):  # written by a version with other fields, or damaged
            kept: Value = decoded(data, records)
            return kept
    value = compute()
    database.write(study, "", encoded(value))
    return value


class ValueCache:
    """The results of a study by name, with which it resumes after an interruption: numbers, text, lists and mappings.

    The key of a study is `what` (any JSON data) and the machine, because results contain times. Without `what` results
    are in memory only; with `fresh` earlier results are dropped. `records` are the classes of the records among its
    values."""

    def __init__(self, what: Any = None, fresh: bool = False, records: Sequence[type] = ()) -> None:
        self._study = None if what is None else key_of([platform.node(), what])
        self._records: dict[str, Any] = {}
        if self._study is not None and fresh:
            database.forget(self._study)
        elif self._study is not None:
            for name, data in database.read(self._study).items():
                with suppress(ValueError):
                    self._records[name] = decoded(data, records)

    def __contains__(self, name: str) -> bool:
        return name in self._records

    def __getitem__(self, name: str) -> Any:
        return self._records[name]

    def items(self) -> ItemsView[str, Any]:
        """All records, with their names."""
        return self._records.items()

    def add(self, name: str, record: Any) -> None:
        """Stores a record; it is on the disk when this returns."""
        self._records[name] = record
        if self._study is not None:
            database.write(self._study, name, encoded(record))


def key_of(what: Any) -> str:
    """The key of values that `what` (any JSON data) and the code of mbproj, its kernel and plug-ins determine."""
    return hashlib.sha256(json.dumps([_code(), build_info(), what, *marks()], default=_plain).encode()).hexdigest()


@cache
def _code() -> str:
    """A checksum of all code of mbproj. The version alone is not enough: in a checkout it stays the same while code
    changes."""
    checksum, kernel = hashlib.sha256(), core()
    for path in sorted(Path(mbproj.__file__).parent.rglob("*.py")):
        checksum.update(path.read_bytes())
    if kernel is not None:
        checksum.update(Path(str(kernel.__file__)).read_bytes())
    return checksum.hexdigest()


def _plain(number: Any) -> Any:
    """A number of NumPy as Python's."""
    return number.item()


#: Types of arrays: floats, integers, booleans.
NUMBERS = ("<f8", "<i8", "|b1")
CHECKSUM, LENGTH = 4, 8


def encoded(value: Any) -> bytes:
    """The bytes of a value. Raises TypeError for other types of data."""
    arrays: list[bytes] = []
    text = json.dumps(_as_json(value, arrays)).encode()
    rest = b"".join([len(text).to_bytes(LENGTH, "little"), text, *arrays])
    return crc32(rest).to_bytes(CHECKSUM, "little") + rest


def decoded(data: bytes, records: Sequence[type] = ()) -> Any:
    """The value, which may contain records of these classes only. Raises ValueError for bytes that `encoded` has not
    written."""
    rest = memoryview(data)[CHECKSUM:]
    if crc32(rest) != int.from_bytes(data[:CHECKSUM], "little"):
        raise ValueError("its checksum is wrong")
    end = LENGTH + int.from_bytes(rest[:LENGTH], "little")
    try:
        tree = json.loads(bytes(rest[LENGTH:end]))
        return _read(tree, rest[end:], {each.__name__: each for each in records})
    except (AttributeError, KeyError, TypeError, RecursionError) as error:
        raise ValueError(f"it is not as mbproj writes it: {error!r}") from error


def _as_json(value: Any, arrays: list[bytes]) -> Any:
    """The value as JSON; the numbers of its arrays are added to `arrays`."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return _as_json(value.item(), arrays)
    if isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        if array.dtype.str not in NUMBERS:
            raise TypeError(f"arrays of {array.dtype} are not kept")
        start = sum(map(len, arrays))
        arrays.append(array.tobytes())
        return {"array": [array.dtype.str, list(value.shape), start]}
    if is_dataclass(value) and not isinstance(value, type):
        members = {each.name: _as_json(getattr(value, each.name), arrays) for each in fields(value)}
        return {"record": [type(value).__name__, members]}
    if isinstance(value, Mapping):
        if not all(isinstance(key, str) for key in value):
            raise TypeError("keys that are not text are not kept")
        return {"mapping": {key: _as_json(each, arrays) for key, each in value.items()}}
    if isinstance(value, tuple):
        return {"tuple": [_as_json(each, arrays) for each in value]}
    if isinstance(value, list):
        return [_as_json(each, arrays) for each in value]
    raise TypeError(f"a {type(value).__name__} is not kept")


def _read(tree: Any, arrays: memoryview, records: Mapping[str, type]) -> Any:
    if isinstance(tree, list):
        return [_read(each, arrays, records) for each in tree]
    if not isinstance(tree, dict):
        return tree
    ((kind, content),) = tree.items()
    if kind == "array":
        number, shape, start = content
        return _array(number, shape, start, arrays)
    if kind == "tuple":
        return tuple(_read(content, arrays, records))
    if kind not in ("mapping", "record"):
        raise ValueError(f"'{kind}' is no kind of data")
    name, members = content if kind == "record" else ("", content)
    values = {key: _read(each, arrays, records) for key, each in members.items()}
    if kind == "mapping":
        return values
    if values.keys() != {each.name for each in fields(records[name])}:
        raise ValueError(f"a {name} has other fields")
    return records[name](**values)


def _array(number: str, shape: list[int], start: int, arrays: memoryview) -> Array:
    """A writable copy of an array in the bytes."""
    if number not in NUMBERS or not all(isinstance(size, int) and size >= 0 for size in (*shape, start)):
        raise ValueError("an array is not described as such")
    return np.frombuffer(arrays, np.dtype(number), prod(shape), start).reshape(shape).copy()
