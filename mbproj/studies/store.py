"""The store: values by two names, a study and an item, in an SQLite file.

There is one such file in the user's cache, for all studies, and one in the folder of each sweep. A value follows from
the data that are its key, with the code of mbproj and of plug-ins. It is stored as bytes that hold data only, and read
as the type that the reader names. Any other bytes raise ValueError.

    length of the text (8 bytes) | JSON | the arrays one after another
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
import stat
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache, partial
from math import prod
from pathlib import Path
from time import time
from types import UnionType
from typing import Annotated, Any, NamedTuple, TypeAlias, TypeVar, Union, get_args, get_origin, get_type_hints
from zlib import crc32

import numpy as np

import mbproj
from mbproj.base.arrays import Array
from mbproj.base.errors import warn_once
from mbproj.base.plugins import marks
from mbproj.kernel import build_info, core

# --- The file ---------------------------------------------------------------------------------------------------------
# Every row has a checksum of its names and its value. A damaged file is renamed, and a new one takes its place.


Result = TypeVar("Result")

#: The application id ("mbpr") and the format, which SQLite stores in the file's header.
OURS, FORMAT = 0x6D627072, 2
#: The bytes of a file with the application id.
OURS_AT = slice(68, 72)
SCHEMA = (
    "CREATE TABLE kept (study TEXT NOT NULL, item TEXT NOT NULL, used REAL NOT NULL, value BLOB NOT NULL, "
    "PRIMARY KEY (study, item)) WITHOUT ROWID"  # a damaged index would hide a row that is whole
)
CHECKSUM, LENGTH = 4, 8
#: Endings of the files that SQLite writes beside its own.
BESIDE = ("-wal", "-journal", "-shm")
#: The name to which a damaged file is renamed.
ASIDE = "store.aside"
#: Words in SQLite's messages whose cause is the machine, not the content of the file.
MACHINE = ("locked", "full", "I/O", "unable to open")


class Foreign(sqlite3.DatabaseError):
    """The error for a database of another program, or of another format."""


def put(database: sqlite3.Connection, study: str, item: str, value: bytes) -> None:
    """Stores a value, in place of one with the same names."""
    row = [study, item, time(), _sealed(study, item, value)]
    database.execute("INSERT OR REPLACE INTO kept (study, item, used, value) VALUES (?, ?, ?, ?)", row)


def drop(database: sqlite3.Connection, study: str) -> None:
    """Drops all values of a study."""
    database.execute("DELETE FROM kept WHERE study = ?", [study])


def rows(database: sqlite3.Connection, study: str, item: str | None = None) -> Iterator[tuple[str, bytes]]:
    """The values of a study by the names of its items, or that of one item. Damaged rows are left out."""
    which, names = ("", [study]) if item is None else (" AND item = ?", [study, item])
    for row in database.execute(f"SELECT study, item, value FROM kept WHERE study = ?{which}", names):
        value = _whole(*row)
        if value is not None:
            yield row[1], value


def _sealed(study: str, item: str, value: bytes) -> bytes:
    return crc32(value, crc32(f"{study}\0{item}".encode())).to_bytes(CHECKSUM, "little") + value


def _whole(study: Any, item: Any, data: Any) -> bytes | None:
    """The value of a row; None where the row is damaged."""
    if not isinstance(data, bytes) or _sealed(study, item, data[CHECKSUM:]) != data:
        return None
    return data[CHECKSUM:]


@contextmanager
def damage_as_sqlite_says_it() -> Iterator[None]:
    """Raises sqlite3.DatabaseError where SQLite's message quotes a damaged text, which Python cannot decode."""
    try:
        yield
    except UnicodeDecodeError as error:
        raise sqlite3.DatabaseError("a text in it is damaged") from error


def _connected(path: Path | str, patience: float) -> sqlite3.Connection:
    """The database at a path or URI, where damaged text can be read, too: its checksum then differs."""
    if isinstance(path, Path) and path.exists() and not path.is_file():
        raise Foreign("it is no file")
    database = sqlite3.connect(path, timeout=patience, isolation_level=None, uri=isinstance(path, str))
    database.text_factory = lambda data: data.decode(errors="replace")
    return database


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
    """Makes the tables of a new file. Raises Foreign for a file of another program or format, and
    sqlite3.DatabaseError where the tables are not as they were made."""
    tables = {sql for (sql,) in database.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")}
    owner, version = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
    if not tables and not owner and not version:
        for statement in (SCHEMA, f"PRAGMA application_id = {OURS}", f"PRAGMA user_version = {FORMAT}"):
            database.execute(statement)
    elif (owner, version) != (OURS, FORMAT):
        raise Foreign("it is that of another program, or version")
    elif tables != {SCHEMA}:
        raise sqlite3.DatabaseError("its tables are damaged")


def _by_the_machine(path: Path, error: sqlite3.Error) -> bool:
    """Whether the cause of SQLite's error is the machine, or another process."""
    said = str(error)
    return any(word in said for word in MACHINE) or ("readonly" in said and not os.access(path, os.W_OK))


def is_damage(path: Path, error: sqlite3.Error) -> bool:
    """Whether the cause of SQLite's error is damage of a file of ours. May raise OSError."""
    if isinstance(error, Foreign) or _by_the_machine(path, error):
        return False
    with path.open("rb") as file:
        return file.read(OURS_AT.stop)[OURS_AT] == OURS.to_bytes(4, "big")


def opened_alone(path: Path) -> sqlite3.Connection:
    """The undamaged database at `path`, locked for this process, and made where there is none. A damaged file of ours
    is replaced by one with its whole rows. Raises sqlite3.Error for other files and where another process has it."""
    database, why = None, ""
    try:
        with damage_as_sqlite_says_it():
            database = _connected(path, 0.0)
            if not (why := "; ".join(faults_of(_locked(database)))):
                return database
    except sqlite3.Error as error:
        if not is_damage(path, error):
            if database is not None:
                database.close()
            raise
        why = str(error)
    _replace(path, why, database)
    return _locked(_connected(path, 0.0))


def _locked(database: sqlite3.Connection) -> sqlite3.Connection:
    # The lock is held as long as the file is open, so that no memory is shared: network file systems have none.
    database.execute("PRAGMA locking_mode = EXCLUSIVE")
    with _transaction(database):
        _check(database)
    for mode in ("journal_mode = WAL", "synchronous = NORMAL"):
        database.execute(f"PRAGMA {mode}")
    return database


def faults_of(database: sqlite3.Connection) -> list[str]:
    """What is wrong with a database, which is read as a whole: a sentence for each fault. Raises sqlite3.Error where it
    cannot be read to its end."""
    whole = [_whole(*row) is not None for row in database.execute("SELECT study, item, value FROM kept")]
    damaged = [f"{whole.count(False)} of {len(whole)} rows are damaged"] if not all(whole) else []
    return [said for (said,) in database.execute("PRAGMA quick_check(3)") if said != "ok"] + damaged


def only_read(path: Path, work: Callable[[sqlite3.Connection], Result]) -> Result:
    """The result of `work` on the database at `path`, which is not changed. A log of SQLite beside it means that a
    process is at work, or was killed: then it is opened with a lock. Raises sqlite3.Error."""
    has_log = path.with_name(path.name + "-wal").exists()
    name = path if has_log else f"{path.absolute().as_uri()}?mode=ro&immutable=1"
    with damage_as_sqlite_says_it(), closing(_connected(name, 0.0)) as database:
        if has_log:
            _locked(database)
        _check(database)
        return work(database)


def _replace(path: Path, why: str, old: sqlite3.Connection | None = None) -> None:
    """Replaces a file by a new one, with the whole rows of the `old` connection, which is closed. The file before gets
    another name, in place of one renamed earlier."""
    draft, aside = path.with_name(f".mbproj-{os.urandom(8).hex()}.sqlite"), path.with_name(ASIDE)
    try:
        with closing(_connected(draft, 0.0)) as new, _transaction(new):
            _check(new)
            for row in () if old is None else _whole_rows(old):
                put(new, *row)
            count = new.execute("SELECT count(*) FROM kept").fetchone()[0]
        if old is not None:
            old.close()
        for ending in ("", *BESIDE):  # SQLite would play back a log of the old file into the new one
            with suppress(FileNotFoundError):
                path.with_name(path.name + ending).replace(aside.with_name(aside.name + ending))
        draft.replace(path)
    finally:
        if old is not None:
            old.close()
        draft.unlink(missing_ok=True)
    whole = f"{count} of its values are whole, and all others are computed again; " if count else ""
    warn_once(f"'{path}' is not as mbproj has written it ({why}): {whole}it is now '{aside.name}'")


def _whole_rows(old: sqlite3.Connection) -> Iterator[tuple[str, str, bytes]]:
    """Yield the undamaged rows, read from both ends: SQLite may fail at a part between them."""
    for order in ("ASC", "DESC"):
        with suppress(sqlite3.DatabaseError), damage_as_sqlite_says_it():
            for study, item, data in old.execute(
                f"SELECT study, item, value FROM kept ORDER BY study {order}, item {order}"
            ):
                value = _whole(study, item, data)
                if value is not None:
                    yield study, item, value
            return


# --- The file in the user's cache -------------------------------------------------------------------------------------
# Many processes may use it at once. Its size is bounded: values used longest ago are dropped. What stands in its place
# is renamed. Where no file can be opened, nothing is stored. A warning tells each of these once, and none of them stops
# a study.


#: The largest size of the file, and of one value, in bytes.
BOUND, LARGEST = 256 << 20, 64 << 20
#: Time to wait for another process that writes, s.
PATIENCE = 10.0


def read(study: str) -> dict[str, bytes]:
    """All values of a study by the names of its items."""

    def work(database: sqlite3.Connection) -> dict[str, bytes]:
        items = dict(rows(database, study))
        if items:
            database.execute("UPDATE kept SET used = ? WHERE study = ?", [time(), study])
        return items

    return _with_cache(work, {})


def write(study: str, item: str, value: bytes) -> None:
    """Stores a value, in place of one with the same names, until its space is needed."""

    def work(database: sqlite3.Connection) -> None:
        _make_room(database, len(value))
        put(database, study, item, value)

    if len(value) <= LARGEST:
        _with_cache(work, None)


def forget(study: str) -> None:
    """Drops all values of a study."""
    _with_cache(lambda database: drop(database, study), None)


def _with_cache(work: Callable[[sqlite3.Connection], Result], otherwise: Result) -> Result:
    """The result of `work` in a transaction; `otherwise` where no file can be opened."""
    try:
        path = _private_folder() / "store.sqlite3"
        before = _identity(path)
        try:
            return _in_transaction(path, work)
        except sqlite3.Error as error:
            if _by_the_machine(path, error):
                raise
            if _identity(path) == before:  # else another process has replaced it already
                _replace(path, str(error))
            return _in_transaction(path, work)
    except (OSError, sqlite3.Error) as error:
        warn_once(f"results of studies are not stored: {error}; MBPROJ_CACHE chooses another folder")
        return otherwise


def _in_transaction(path: Path, work: Callable[[sqlite3.Connection], Result]) -> Result:
    with damage_as_sqlite_says_it(), closing(_connected(path, PATIENCE)) as database:
        # No write waits for the disk: a power cut may damage the store, whose values have checksums, but no study.
        database.execute("PRAGMA synchronous = OFF")
        with _transaction(database):
            _check(database)
            return work(database)


def _make_room(database: sqlite3.Connection, size: int) -> None:
    """Drops a tenth of the values, those used longest ago, until `size` bytes fit: SQLite fills free pages before the
    file grows."""
    page = database.execute("PRAGMA page_size").fetchone()[0]
    last = "SELECT used FROM kept ORDER BY used LIMIT 1 OFFSET (SELECT count(*) / 10 FROM kept)"
    while True:
        pages, free = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_count", "freelist_count"))
        needed = size + size // 50 + 16 * page  # with SQLite's overhead
        fits = (pages - free) * page + needed <= BOUND
        if fits or not database.execute(f"DELETE FROM kept WHERE used <= ({last})").rowcount:
            return


def _identity(path: Path) -> int | None:
    return path.stat().st_ino if path.exists() else None


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
# They are read as the type that the reader names: `tuple[Timing, ...]`, or a record with its fields. In a record
# `Annotated[Array, "T 3"]` tells the shape of an array. Its letters are sizes that all arrays of the value share.


class Keys:
    """The keys of values that `common` (any JSON data), further data, and the code of mbproj, its kernel and plug-ins
    determine. Two of 1e9 keys do not agree by chance."""

    SIZE = 16

    def __init__(self, common: Any) -> None:
        text = json.dumps([_code(), build_info(), common, *marks()], default=_plain)
        self._common = hashlib.blake2b(text.encode(), digest_size=self.SIZE)

    def of(self, more: Any) -> str:
        """The key in hexadecimal digits."""
        digest = self._common.copy()
        digest.update(json.dumps(more, default=_plain).encode())
        return digest.hexdigest()


def key_of(what: Any) -> str:
    """The key of values that `what` (any JSON data) and the code determine."""
    return Keys(what).of(None)


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


def encoded(value: Any) -> bytes:
    """The bytes of a value. Raises TypeError for other types of data."""
    arrays: list[bytes] = []
    text = json.dumps(_as_json(value, arrays)).encode()
    return b"".join([len(text).to_bytes(LENGTH, "little"), text, *arrays])


def decoded(data: bytes, kind: Any = Any, **sizes: int) -> Any:
    """The value of the type `kind`, with arrays of these sizes. Raises ValueError for bytes of anything else."""
    end = LENGTH + int.from_bytes(data[:LENGTH], "little")
    try:
        return _reader(kind)(json.loads(data[LENGTH:end]), Beside(memoryview(data)[end:], sizes))
    except WRONG as error:
        raise ValueError(f"it is not as mbproj writes it: {error!r}") from error


def _as_json(value: Any, arrays: list[bytes]) -> Any:
    """The value as JSON; the numbers of its arrays are added to `arrays`."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, Enum | np.generic):
        return _as_json(value.value if isinstance(value, Enum) else value.item(), arrays)
    if isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        if array.dtype.str not in NUMBERS:
            raise TypeError(f"arrays of {array.dtype} are not kept")
        start = sum(map(len, arrays))
        arrays.append(array.tobytes())
        return [array.dtype.str, list(value.shape), start]
    if is_dataclass(value) and not isinstance(value, type):
        return [_as_json(getattr(value, each.name), arrays) for each in fields(value)]
    if isinstance(value, Mapping):
        if not all(isinstance(key, str) for key in value):
            raise TypeError("keys that are not text are not kept")
        return {key: _as_json(each, arrays) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_as_json(each, arrays) for each in value]
    raise TypeError(f"a {type(value).__name__} is not kept")


class Beside(NamedTuple):
    """The numbers of the arrays of a value, and the sizes of these arrays as far as they are known."""

    arrays: memoryview
    sizes: dict[str, int]


#: A function that makes a value of JSON. It raises ValueError, or one of `WRONG`, for JSON of another type.
Reader: TypeAlias = "Callable[[Any, Beside], Any]"
WRONG = (AttributeError, KeyError, TypeError, RecursionError)


@cache
def _reader(kind: Any) -> Reader:
    """The reader of values of a type."""
    origin, args = get_origin(kind) or kind, get_args(kind)
    if kind is Any:
        return lambda tree, beside: tree
    if origin is Annotated:
        return partial(_shaped, _reader(args[0]), args[1].split())
    if origin is np.ndarray:
        return partial(_array, np.dtype(get_args(args[1])[0]))
    if origin in (Union, UnionType):
        return partial(_one_of, [_reader(each) for each in args])
    if origin is list or (origin is tuple and args[-1] is Ellipsis):
        every = _reader(args[0])
        return lambda tree, beside: origin(every(each, beside) for each in _fitting(tree, type(tree) is list))
    if origin is tuple:
        readers = [_reader(each) for each in args]
        return lambda tree, beside: tuple(read(each, beside) for read, each in zip(readers, tree, strict=True))
    if origin in (dict, Mapping):
        value = _reader(args[1])
        return lambda tree, beside: {key: value(each, beside) for key, each in tree.items()}
    if is_dataclass(kind):
        types = get_type_hints(kind, include_extras=True)
        return partial(_record, kind, [_reader(types[each.name]) for each in fields(kind)])
    if issubclass(kind, Enum):
        return lambda tree, beside: kind(tree)
    numbers = (int, float) if kind is float else (kind,)
    return lambda tree, beside: _fitting(tree, type(tree) in numbers)


def _fitting(value: Any, fits: bool) -> Any:
    if not fits:
        raise ValueError("it is of another type or shape")
    return value


def _shaped(reader: Reader, shape: Sequence[str], tree: Any, beside: Beside) -> Array:
    """An array of a shape, whose letters all arrays of the value share."""
    array: Array = reader(tree, beside)
    pairs = zip(shape, array.shape, strict=True)
    sizes = [int(size) if size.isdigit() else beside.sizes.setdefault(size, at) for size, at in pairs]
    return array if list(array.shape) == sizes else _fitting(array, False)


def _array(dtype: np.dtype[Any], tree: Any, beside: Beside) -> Array:
    """A writable copy of an array in the bytes."""
    number, shape, start = tree
    if number != dtype.str or not all(type(size) is int and size >= 0 for size in (*shape, start)):
        raise ValueError("an array is not described as such")
    return np.frombuffer(beside.arrays, dtype, prod(shape), start).reshape(shape).copy()


def _one_of(readers: Sequence[Reader], tree: Any, beside: Beside) -> Any:
    for reader in readers:
        with suppress(ValueError, *WRONG):
            tried = Beside(beside.arrays, dict(beside.sizes))
            value = reader(tree, tried)
            beside.sizes.update(tried.sizes)
            return value
    return _fitting(tree, False)


def _record(kind: Any, readers: Sequence[Reader], tree: Any, beside: Beside) -> Any:
    """A record of its fields in their order."""
    return kind(*(reader(each, beside) for reader, each in zip(readers, tree, strict=True)))
