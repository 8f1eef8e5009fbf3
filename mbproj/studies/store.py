"""Values of studies, stored by the data that determine them, with the code of mbproj and of plug-ins.

A value is stored as bytes that hold data only: numbers, text, lists, tuples, mappings, arrays, and records of classes
that the reader names. Any other bytes raise ValueError.

    crc32 of the rest (4 bytes) | length of the text (8 bytes) | JSON | the arrays one after another

In the JSON, a value that is neither a number, a text nor a list is an object whose single key names its type.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import sqlite3
import stat
import sys
from collections.abc import Callable, ItemsView, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import fields, is_dataclass
from functools import cache
from math import prod
from pathlib import Path
from time import time
from typing import Any, TypeVar
from zlib import crc32

import numpy as np

import mbproj
from mbproj.base.arrays import Array
from mbproj.base.errors import warn_once
from mbproj.base.plugins import marks
from mbproj.kernel import build_info, core

# --- The store's file -------------------------------------------------------------------------------------------------
# Values of bytes by two names in an SQLite database, which many processes may use at once.
# Its size is bounded: values used longest ago are dropped. A file that is damaged, or of another program, is renamed,
# and a new one begun. Where no file can be opened, nothing is stored. A warning tells each of these once, and none of
# them stops a study.


Result = TypeVar("Result")

#: The largest size of the file, and of one value, in bytes.
BOUND, LARGEST = 256 << 20, 64 << 20
#: Time to wait for another process that writes, s.
PATIENCE = 10.0
#: The application id ("mbpr") and the format, which SQLite stores in the file's header.
OURS, FORMAT = 0x6D627072, 1
SCHEMA = (
    "CREATE TABLE kept (study TEXT NOT NULL, item TEXT NOT NULL, used REAL NOT NULL, value BLOB NOT NULL, "
    "PRIMARY KEY (study, item))",
    "CREATE INDEX kept_by_use ON kept (used)",
)


class ForeignStore(sqlite3.DatabaseError):
    """The error for a database of another program, or of another format."""


def read(study: str) -> dict[str, bytes]:
    """All values of a study by the names of its items."""

    def work(database: sqlite3.Connection) -> dict[str, bytes]:
        items = dict(database.execute("SELECT item, value FROM kept WHERE study = ?", [study]).fetchall())
        if items:
            database.execute("UPDATE kept SET used = ? WHERE study = ?", [time(), study])
        return items

    return _with_store(work, {})


def write(study: str, item: str, value: bytes) -> None:
    """Stores a value, in place of one with the same names, until its space is needed."""

    def work(database: sqlite3.Connection) -> None:
        _make_room(database, len(value))
        row = [study, item, time(), value]
        database.execute("INSERT OR REPLACE INTO kept (study, item, used, value) VALUES (?, ?, ?, ?)", row)

    if len(value) <= LARGEST:
        _with_store(work, None)


def forget(study: str) -> None:
    """Drops all values of a study."""
    _with_store(lambda database: database.execute("DELETE FROM kept WHERE study = ?", [study]) and None, None)


def _with_store(work: Callable[[sqlite3.Connection], Result], otherwise: Result) -> Result:
    """The result of `work` in a transaction; `otherwise` where no store can be opened."""
    try:
        path = _private_folder() / "store.sqlite3"
        before = _identity(path)
        try:
            return _in_transaction(path, work)
        except sqlite3.OperationalError:
            raise
        except (sqlite3.DatabaseError, UnicodeDecodeError) as error:  # SQLite may quote a damaged text
            if _identity(path) == before:  # else another process has replaced it already
                _set_aside(path, str(error))
            return _in_transaction(path, work)
    except (OSError, sqlite3.Error) as error:
        warn_once(f"results of studies are not stored: {error}; MBPROJ_CACHE chooses another folder")
        return otherwise


def _in_transaction(path: Path, work: Callable[[sqlite3.Connection], Result]) -> Result:
    if path.exists() and not path.is_file():
        raise ForeignStore("it is no file")
    with closing(sqlite3.connect(path, timeout=PATIENCE, isolation_level=None)) as database:
        # No write waits for the disk: a power cut may damage the store, whose values have checksums, but no study.
        database.execute("PRAGMA synchronous = OFF")
        with _transaction(database):
            _check(database)
            return work(database)


@contextmanager
def _transaction(database: sqlite3.Connection) -> Iterator[None]:
    database.execute("BEGIN IMMEDIATE")
    try:
        yield
        database.execute("COMMIT")
    except BaseException:
        with suppress(sqlite3.Error):  # the database itself may be damaged
            database.execute("ROLLBACK")
        raise


def _check(database: sqlite3.Connection) -> None:
    """Makes the tables of a new file. Raises ForeignStore where the file has other tables."""
    tables = database.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL").fetchall()
    owner, version = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
    if not tables and not owner and not version:
        for statement in (*SCHEMA, f"PRAGMA application_id = {OURS}", f"PRAGMA user_version = {FORMAT}"):
            database.execute(statement)
    elif (owner, version) != (OURS, FORMAT) or {sql for (sql,) in tables} != set(SCHEMA):
        raise ForeignStore("it is the database of another program, or version")


def _make_room(database: sqlite3.Connection, size: int) -> None:
    """Drops the values used longest ago until `size` bytes fit: SQLite fills free pages before the file grows."""
    page = database.execute("PRAGMA page_size").fetchone()[0]
    oldest = "DELETE FROM kept WHERE rowid = (SELECT rowid FROM kept ORDER BY used LIMIT 1)"
    while True:
        pages, free = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_count", "freelist_count"))
        needed = size + size // 50 + 16 * page  # with SQLite's overhead
        if (pages - free) * page + needed <= BOUND or not database.execute(oldest).rowcount:
            return


def _identity(path: Path) -> int | None:
    return path.stat().st_ino if path.exists() else None


def _set_aside(path: Path, why: str) -> None:
    """Renames the file at the store's path; it replaces a file renamed before."""
    aside = path.with_name("store.aside")
    journal = path.with_name(f"{path.name}-journal")  # SQLite would play it back into the new file
    journal.unlink(missing_ok=True)
    path.replace(aside)
    warn_once(f"'{path}' is not what mbproj has kept there ({why}): it is now '{aside.name}', and studies begin anew")


def _folder() -> Path:
    """MBPROJ_CACHE, or `mbproj` in the user's folder for caches, as the system has it."""
    if folder := os.environ.get("MBPROJ_CACHE"):
        return Path(folder)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", "~/AppData/Local")) / "mbproj" / "Cache"
    if sys.platform == "darwin":
        return Path("~/Library/Caches/mbproj")
    caches = Path(os.environ.get("XDG_CACHE_HOME", ""))  # a relative path does not count (XDG Base Directory, 3)
    return (caches if caches.is_absolute() else Path("~/.cache")) / "mbproj"


def _private_folder() -> Path:
    """The folder `studies` in the cache, which only the user can read or write; it is made where it is missing. Raises
    OSError where it cannot be made, or belongs to another user."""
    try:
        parent = _folder().expanduser()
    except RuntimeError as error:
        raise FileNotFoundError(f"'{_folder()}': the user has no home") from error
    parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    private = parent / "studies"
    private.mkdir(mode=0o700, exist_ok=True)
    status = private.stat()
    if hasattr(os, "getuid") and status.st_uid != os.getuid():
        raise PermissionError(f"'{private}' belongs to another user")
    if stat.S_IMODE(status.st_mode) != 0o700 and os.name == "posix":
        private.chmod(0o700)
    return private


# --- Values of studies ------------------------------------------------------------------------------------------------
# They are stored by the data that determine them, with the code of mbproj and of plug-ins.


Value = TypeVar("Value")


def cached(what: Any, compute: Callable[[], Value], records: Sequence[type]) -> Value:
    """Return the value for the key `what` (any JSON data): from the store, or by `compute`. `records`: the classes of
    the records in the value."""
    study = key_of(what)
    for data in read(study).values():
        with suppress(ValueError):  # written by a version with other fields, or damaged
            stored: Value = decoded(data, records)
            return stored
    value = compute()
    write(study, "", encoded(value))
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
            forget(self._study)
        elif self._study is not None:
            for name, data in read(self._study).items():
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
            write(self._study, name, encoded(record))


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
