"""A case of a sweep: its key, a hash of all data that determine its numbers; its result, a row of the table; and the
stored form of this row.
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from enum import Enum
from itertools import count
from math import isnan
from pathlib import Path
from typing import Any
from zlib import crc32

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, warn_once
from mbproj.base.plugins import marks
from mbproj.base.version import __version__
from mbproj.kernel import build_info
from mbproj.scene.ranges import Item
from mbproj.scene.records import Expectation

#: The bytes of a key: two of 1e9 cases do not agree by chance.
SIZE = 16


class Status(str, Enum):
    """The end of a case. A restarted sweep runs cases again that took too long, or lost their process, memory or disk
    space. Failed cases would fail again."""

    DONE = "done"
    FAILED = "failed"
    TIMEOUT = "timeout"
    CRASHED = "crashed"


@dataclass(frozen=True)
class CaseRow:
    """The result of a case: its status, and its measures in their order, empty for a case that is not done. For a
    failure: `message`, `time` in s and `joint`, where known. `seconds` is the duration by the clock, `kept` whether the
    results file is kept. `by_arrays` tells whether the case ran in arrays, and is not stored."""

    status: Status
    values: tuple[float, ...] = ()
    message: str = ""
    time: float | None = None
    joint: str = ""
    formulation: str = ""
    seconds: float = 0.0
    kept: bool = False
    by_arrays: bool = False


#: The columns of a stored case, with the types that SQLite may return.
_KINDS: Mapping[str, tuple[type, ...]] = {
    "key": (str,),
    "parameters": (str,),
    "status": (str,),
    "measures": (str,),
    "message": (str,),
    "time": (float, type(None)),
    "joint": (str,),
    "formulation": (str,),
    "seconds": (float,),
    "kept": (int,),
}


def as_stored(key: str, parameters: Mapping[str, Any], names: Sequence[str], row: CaseRow) -> list[Any]:
    """The columns of a case, whose measures have these names in the store."""
    values = {name: None if isnan(value) else value for name, value in zip(names, row.values, strict=False)}
    time = None if row.time is None or isnan(row.time) else float(row.time)
    texts = [key, json.dumps(dict(parameters)), row.status.value, json.dumps(values)]
    return [*texts, row.message, time, row.joint, row.formulation, float(row.seconds), int(row.kept)]


def from_stored(columns: Sequence[Any]) -> tuple[dict[str, float | None], CaseRow]:
    """The measures of a stored case by their names, and its row without them. Raises ValueError for columns that
    `as_stored` has not made."""
    kinds = _KINDS.values()
    if len(columns) != len(kinds) or not all(map(isinstance, columns, kinds)):
        raise ValueError("a column has another type")
    _, parameters, status, measures, message, time, joint, formulation, seconds, has_file = columns
    values = json.loads(measures)
    numbers = values.values() if isinstance(values, dict) else [""]
    if not isinstance(json.loads(parameters), dict) or not all(isinstance(each, float | None) for each in numbers):
        raise ValueError("parameters or measures are not what they should be")
    return values, CaseRow(Status(status), (), message, time, joint, formulation, seconds, bool(has_file))


class Keys:
    """The keys of cases of a scene's text in which these paths vary; mbproj's version and build are part of them."""

    def __init__(self, text: str, paths: Sequence[str]) -> None:
        common = json.dumps([__version__, build_info(), text, *marks()])
        self._common = hashlib.blake2b(common.encode(), digest_size=SIZE)
        self._paths = tuple(paths)

    def of(self, values: Sequence[Item]) -> str:
        """The key of the case with these values, in hexadecimal digits; it does not depend on the order of the
        paths."""
        digest = self._common.copy()
        digest.update(json.dumps(sorted(zip(self._paths, values, strict=True))).encode())
        return digest.hexdigest()


def identity(measure: Expectation) -> str:
    """The identity of a measure, which does not depend on its name: its object, quantity, component and time."""
    further = [measure.over, *measure.between] if measure.over or measure.between else []
    return json.dumps([measure.of, measure.item, measure.quantity, measure.component, measure.at, *further])


# --- The file of a sweep's store --------------------------------------------------------------------------------------
# An SQLite database that only one process can open.
# Every row has a checksum. A damaged file, or one of format 1, is replaced by a new one with its undamaged rows.


#: The application id ("mbsw") and the format, which SQLite stores in the file's header. Format 1 has no checksums.
OURS, FORMAT, WITHOUT_CHECKSUMS = 0x6D627377, 2, 1
#: The bytes of a file with the application id.
OURS_AT = slice(68, 72)
#: The columns of format 1, by table. Format 2 has the row's checksum after them.
TABLES: Mapping[str, str] = {
    "about": "name TEXT PRIMARY KEY, value TEXT NOT NULL",
    "cases": "key TEXT PRIMARY KEY, parameters TEXT NOT NULL, status TEXT NOT NULL, measures TEXT NOT NULL, "
    "message TEXT NOT NULL, time REAL, joint TEXT NOT NULL, formulation TEXT NOT NULL, seconds REAL NOT NULL, "
    "kept INTEGER NOT NULL",
}
CHECKSUM = ", checksum INTEGER NOT NULL"
#: Endings of the files that SQLite writes beside its own.
BESIDE = ("-wal", "-journal", "-shm")
OTHER = "choose another folder with -o"
#: Words in SQLite's messages whose cause is the machine, not the content of the file.
MACHINE = ("locked", "full", "I/O", "unable to open")


#: The name to which a damaged store is renamed.
ASIDE = "store.damaged"


class Foreign(sqlite3.DatabaseError):
    """The error for a database of another program, or of another format."""


@dataclass(frozen=True)
class Looked:
    """The result of reading all rows: the format, the numbers of cases and of damaged cases, and other faults."""

    version: int
    cases: int
    damaged: int
    faults: tuple[str, ...]

    @property
    def is_whole(self) -> bool:
        """Whether no row is damaged and there is no other fault."""
        return not (self.damaged or self.faults)


@contextmanager
def _damage_as_sqlite_says_it() -> Iterator[None]:
    """Raises sqlite3.DatabaseError where SQLite's message quotes a damaged text, which Python cannot decode."""
    try:
        yield
    except UnicodeDecodeError as error:
        raise sqlite3.DatabaseError("a text in it is damaged") from error


@_damage_as_sqlite_says_it()
def locked(path: Path) -> sqlite3.Connection:
    """The database at `path`, locked for this process and made where there is none. Raises sqlite3.Error."""
    database = sqlite3.connect(path, timeout=0.0, isolation_level=None)
    try:
        prepare(database)
        # The lock is held as long as the file is open, so that no memory is shared: network file systems have none.
        for statement in ("locking_mode = EXCLUSIVE", "journal_mode = WAL", "synchronous = NORMAL"):
            database.execute(f"PRAGMA {statement}")
        database.execute("BEGIN IMMEDIATE")
        database.execute("COMMIT")
    except BaseException:
        database.close()
        raise
    return database


def prepare(database: sqlite3.Connection) -> None:
    """Let damaged text be read, too: its checksum then differs."""
    database.text_factory = lambda data: data.decode(errors="replace")


def make(database: sqlite3.Connection) -> None:
    """Make the tables of a new file."""
    about = (f"PRAGMA application_id = {OURS}", f"PRAGMA user_version = {FORMAT}")
    for statement in ("BEGIN IMMEDIATE", *schema(FORMAT), *about, "COMMIT"):
        database.execute(statement)


def schema(version: int) -> list[str]:
    """The statements that make the tables of a format."""
    last = "" if version == WITHOUT_CHECKSUMS else CHECKSUM
    return [f"CREATE TABLE {name} ({columns}{last}) WITHOUT ROWID" for name, columns in TABLES.items()]


def version_of(database: sqlite3.Connection) -> int:
    """The format of a file; 0 for an empty file. Raises Foreign for a file of another program, or of an unknown
    format."""
    owner, version = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
    if not owner and not database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
        return 0
    if owner != OURS or version not in (WITHOUT_CHECKSUMS, FORMAT):
        raise Foreign("it is that of another program, or version")
    return int(version)


@_damage_as_sqlite_says_it()
def look(database: sqlite3.Connection) -> Looked:
    """Reads a whole database. Raises sqlite3.Error where it cannot be read to its end."""
    version = version_of(database)
    statements = {sql for (sql,) in database.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")}
    faults = [] if statements == {*schema(version)} else ["its tables are not those of a sweep"]
    faults += [said for (said,) in database.execute("PRAGMA quick_check(3)") if said != "ok"]
    counts = {}
    for table in TABLES:
        whole = [whole_values(table, version, row) is not None for row in database.execute(f"SELECT * FROM {table}")]
        counts[table] = len(whole), whole.count(False)
    if counts["about"][1]:
        faults.append("what it says of the sweep is damaged")
    return Looked(version, *counts["cases"], tuple(faults))


def whole_values(table: str, version: int, row: Sequence[Any]) -> Sequence[Any] | None:
    """The values of a row without its checksum; None where the row is damaged. Without checksums only wrong types count
    as damage."""
    if version == FORMAT:
        return row[:-1] if sealed(row[:-1])[-1] == row[-1] else None
    try:
        if table == "cases":
            from_stored(row)
    except (ValueError, RecursionError):
        return None
    return row


def sealed(values: Sequence[Any]) -> list[Any]:
    """A row with its checksum, in the form in which SQLite returns it."""
    row = [_storable(value) for value in values]
    return [*row, crc32(json.dumps(row, default=repr).encode())]


def _storable(value: Any) -> Any:
    if isinstance(value, str):
        return value.encode(errors="backslashreplace").decode()
    return value + 0.0 if isinstance(value, float) else value  # SQLite returns -0.0 as 0.0


def check_no_links(path: Path) -> None:
    """Raises InputError where the database at `path`, or a file that SQLite writes beside it, is a link."""
    for each in (path, *(path.with_name(path.name + ending) for ending in BESIDE)):
        if each.is_symlink():
            what = f"'{each}' is a link, and a sweep keeps its rows in its own folder"
            raise InputError(Problem(what, hint=f"remove it, or {OTHER}"))


def is_damage(path: Path, error: sqlite3.Error) -> bool:
    """Whether the cause of SQLite's error is damage of a file of ours. May raise OSError."""
    said = str(error)
    by_the_machine = any(word in said for word in MACHINE) or ("readonly" in said and not os.access(path, os.W_OK))
    if isinstance(error, Foreign) or by_the_machine:
        return False
    with path.open("rb") as file:
        return file.read(OURS_AT.stop)[OURS_AT] == OURS.to_bytes(4, "big")


def refused(path: Path, error: sqlite3.Error) -> InputError:
    """The error for a database that cannot be opened."""
    if "locked" in str(error):
        hint = f"wait until it has ended, or {OTHER}"
        return InputError(Problem(f"another sweep is at work in '{path.parent}'", hint=hint))
    if isinstance(error, sqlite3.OperationalError):
        return InputError(Problem(f"cannot open '{path}': {error}", hint=OTHER))
    return InputError(Problem(f"'{path}' is not the store of a sweep: {error}", hint=OTHER))


def open_whole(path: Path) -> sqlite3.Connection:
    """The undamaged database at `path`, locked for this process, and made where there is none. Raises InputError where
    it is of another program, or another sweep has it open."""
    check_no_links(path)
    try:
        return _open_or_replace(path)
    except sqlite3.Error as error:
        raise refused(path, error) from error
    except OSError as error:
        raise InputError(Problem(f"cannot write '{path}': {error.strerror or error}", hint=OTHER)) from error


def _open_or_replace(path: Path) -> sqlite3.Connection:
    database, looked = None, None
    try:
        database = locked(path)
        if not version_of(database):
            make(database)
        looked = look(database)
        if looked.is_whole and looked.version == FORMAT:
            return database
    except sqlite3.Error as error:
        if not is_damage(path, error):
            if database is not None:
                database.close()
            raise
    _replace(path, database, aside=looked is None or not looked.is_whole)
    return locked(path)


def _replace(path: Path, old: sqlite3.Connection | None, aside: bool) -> None:
    """Replaces a database by a new one with its undamaged rows, and closes the `old` connection. With `aside` the old
    files are renamed, else deleted."""
    draft = path.with_name(f".mbproj-{os.urandom(8).hex()}.sqlite")
    try:
        with closing(sqlite3.connect(draft, isolation_level=None)) as new:
            make(new)
            cases = _copy(old, new)
        if old is not None:
            old.close()
        name = next(name for name in _names(path) if not name.exists())
        for ending in ("", *BESIDE):  # SQLite would play back a log of the old file into the new one
            with suppress(FileNotFoundError):
                left = path.with_name(path.name + ending)
                left.replace(name.with_name(name.name + ending)) if aside else left.unlink()
        draft.replace(path)
    finally:
        if old is not None:
            old.close()
        draft.unlink(missing_ok=True)
    if aside:
        what = f"is damaged: {cases} of its cases are whole, and all others are computed again"
        warn_once(f"'{path}' {what}; the damaged file is now '{name.name}'")
    elif cases:
        what = f"is of format 1, without checksums: its {cases} cases are taken as they are, and have one from now on"
        warn_once(f"'{path}' {what}")


def _names(path: Path) -> Iterator[Path]:
    yield path.with_name(ASIDE)
    yield from (path.with_name(f"{ASIDE}.{number}") for number in count(1))


def _copy(old: sqlite3.Connection | None, new: sqlite3.Connection) -> int:
    """Copy the undamaged rows, and return the number of cases among them."""
    new.execute("BEGIN")
    for table in TABLES:
        for values in () if old is None else _whole(old, table):
            row = sealed(values)
            new.execute(f"INSERT OR REPLACE INTO {table} VALUES ({', '.join('?' * len(row))})", row)
    new.execute("COMMIT")
    cases: int = new.execute("SELECT count(*) FROM cases").fetchone()[0]
    return cases


def _whole(old: sqlite3.Connection, table: str) -> Iterator[Sequence[Any]]:
    """Yield the undamaged rows, read from both ends: SQLite may fail at a part between them."""
    first = TABLES[table].partition(" ")[0]
    for order in ("ASC", "DESC"):
        with suppress(sqlite3.DatabaseError), _damage_as_sqlite_says_it():
            version = version_of(old)
            for row in old.execute(f"SELECT * FROM {table} ORDER BY {first} {order}"):
                values = whole_values(table, version, row)
                if values is not None:
                    yield values
            return
