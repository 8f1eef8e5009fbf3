"""Values of studies by what they follow from; the code of mbproj and of plug-ins is part of that."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Callable, ItemsView, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import mbproj
from mbproj.kernel import build_info, core
from mbproj.plugins import marks
from mbproj.studies.store import database
from mbproj.studies.store.encoding import decoded, encoded

Value = TypeVar("Value")


def cached(what: Any, compute: Callable[[], Value], records: Sequence[type]) -> Value:
    """The value that `compute` gives for `what` (anything JSON can hold), from the store where it is there. `records`:
    the classes of the records that it consists of."""
    study = _study(what)
    for data in database.read(study).values():
        with suppress(ValueError):  # written by a version with other fields, or damaged
            kept: Value = decoded(data, records)
            return kept
    value = compute()
    database.write(study, "", encoded(value))
    return value


class ValueCache:
    """What a study has done, by name, so that it resumes where it was interrupted: numbers, text, lists and mappings.

    A study is known by `what` it is about (anything JSON can hold) and by the machine, because times are among its
    numbers. Without `what` all is in memory alone; with `fresh` nothing of before counts. `records` are the classes of
    the records among its values."""

    def __init__(self, what: Any = None, fresh: bool = False, records: Sequence[type] = ()) -> None:
        self._study = None if what is None else _study([platform.node(), what])
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
        """Keeps a record; it is on the disk when this returns."""
        self._records[name] = record
        if self._study is not None:
            database.write(self._study, name, encoded(record))


def _study(what: Any) -> str:
    return hashlib.sha256(json.dumps([_code(), build_info(), what, *marks()], default=_plain).encode()).hexdigest()


@cache
def _code() -> str:
    """A checksum of all that mbproj runs. Its version stays the same in a checkout, while records get other fields."""
    checksum, kernel = hashlib.sha256(), core()
    for path in sorted(Path(mbproj.__file__).parent.rglob("*.py")):
        checksum.update(path.read_bytes())
    if kernel is not None:
        checksum.update(Path(str(kernel.__file__)).read_bytes())
    return checksum.hexdigest()


def _plain(number: Any) -> Any:
    """A number of NumPy's as Python's."""
    return number.item()
