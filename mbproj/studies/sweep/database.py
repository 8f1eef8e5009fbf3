"""The file of a sweep's store: an SQLite database that one process has at a time. Every row has a checksum.

What is whole of a file that is damaged, or of format 1, goes into a new one, which takes its place.
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from itertools import count
from pathlib import Path
from typing import Any
from zlib import crc32

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem, warn_once
from mbproj.studies.sweep.row import from_stored

#: What SQLite keeps in the file's header for the program: whose file it is ("mbsw"), and in which format. Format 1 has
#: no checksums.
OURS, FORMAT, WITHOUT_CHECKSUMS = 0x6D627377, 2, 1
#: Where the first of these stands in a file.
OURS_AT = slice(68, 72)
#: The columns of format 1, by table; after them stands the checksum of a row.
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
#: Words of SQLite's where the machine is in the way, not the bytes of the file.
MACHINE = ("locked", "full", "I/O", "unable to open")


#: What a damaged store is called from then on.
ASIDE = "store.damaged"


class Foreign(sqlite3.DatabaseError):
    """A database of another program, or of another format."""


@dataclass(frozen=True)
class Looked:
    """What a look at all rows has found: the format, how many cases there are, how many of them are damaged, and what
    else is wrong."""

    version: int
    cases: int
    damaged: int
    faults: tuple[str, ...]

    @property
    def is_whole(self) -> bool:
        """Whether nothing is damaged."""
        return not (self.damaged or self.faults)


def locked(path: Path) -> sqlite3.Connection:
    """The database at `path`, made where there is none, for this process alone. Raises sqlite3.Error."""
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
    """Damaged text is read, too: its checksum then differs."""
    database.text_factory = lambda data: data.decode(errors="replace")


def make(database: sqlite3.Connection) -> None:
    """The tables of a new file."""
    about = (f"PRAGMA application_id = {OURS}", f"PRAGMA user_version = {FORMAT}")
    for statement in ("BEGIN IMMEDIATE", *schema(FORMAT), *about, "COMMIT"):
        database.execute(statement)


def schema(version: int) -> list[str]:
    """The statements that make the tables of a format."""
    last = "" if version == WITHOUT_CHECKSUMS else CHECKSUM
    return [f"CREATE TABLE {name} ({columns}{last}) WITHOUT ROWID" for name, columns in TABLES.items()]


def version_of(database: sqlite3.Connection) -> int:
    """The format of a file; 0 where there is nothing in it. Raises Foreign where it is none of ours."""
    owner, version = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
    if not owner and not database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
        return 0
    if owner != OURS or version not in (WITHOUT_CHECKSUMS, FORMAT):
        raise Foreign("it is that of another program, or version")
    return int(version)


def look(database: sqlite3.Connection) -> Looked:
    """Reads all of a database. Raises sqlite3.Error where that does not come to an end."""
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
    """The values of a row without its checksum; None where it is damaged, as far as the format can tell."""
    if version == FORMAT:
        return row[:-1] if sealed(row[:-1])[-1] == row[-1] else None
    try:
        if table == "cases":
            from_stored(row)
    except (ValueError, RecursionError):
        return None
    return row


def sealed(values: Sequence[Any]) -> list[Any]:
    """A row with its checksum: text that can be written, numbers as SQLite gives them back."""
    row = [_storable(value) for value in values]
    return [*row, crc32(json.dumps(row, default=repr).encode())]


def _storable(value: Any) -> Any:
    if isinstance(value, str):
        return value.encode(errors="backslashreplace").decode()
    return value + 0.0 if isinstance(value, float) else value  # -0.0 comes back as 0.0


def check_no_links(path: Path) -> None:
    """Raises InputError where the database at `path` would be written somewhere else."""
    for each in (path, *(path.with_name(path.name + ending) for ending in BESIDE)):
        if each.is_symlink():
            what = f"'{each}' is a link, and a sweep keeps its rows in its own folder"
            raise InputError(Problem(what, hint=f"remove it, or {OTHER}"))


def is_damage(path: Path, error: sqlite3.Error) -> bool:
    """Whether SQLite complains of the bytes of a file that is ours. May raise OSError."""
    said = str(error)
    by_the_machine = any(word in said for word in MACHINE) or ("readonly" in said and not os.access(path, os.W_OK))
    if isinstance(error, Foreign) or by_the_machine:
        return False
    with path.open("rb") as file:
        return file.read(OURS_AT.stop)[OURS_AT] == OURS.to_bytes(4, "big")


def refused(path: Path, error: sqlite3.Error) -> InputError:
    """A database that cannot be opened."""
    if "locked" in str(error):
        hint = f"wait until it has ended, or {OTHER}"
        return InputError(Problem(f"another sweep is at work in '{path.parent}'", hint=hint))
    if isinstance(error, sqlite3.OperationalError):
        return InputError(Problem(f"cannot open '{path}': {error}", hint=OTHER))
    return InputError(Problem(f"'{path}' is not the store of a sweep: {error}", hint=OTHER))


def open_whole(path: Path) -> sqlite3.Connection:
    """The database at `path`, which no other process has and in which nothing is damaged; made where there is none.
    Raises InputError where it is not ours, or another sweep has it open."""
    check_no_links(path)
    try:
        return _opened(path)
    except sqlite3.Error as error:
        raise refused(path, error) from error
    except OSError as error:
        raise InputError(Problem(f"cannot write '{path}': {error.strerror or error}", hint=OTHER)) from error


def _opened(path: Path) -> sqlite3.Connection:
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
    """Puts a new database in the place of an old one, which may be set aside. The old connection is closed."""
    draft = path.with_name(f".mbproj-{os.urandom(8).hex()}.sqlite")
    try:
        with closing(sqlite3.connect(draft, isolation_level=None)) as new:
            make(new)
            kept = _copy(old, new)
        if old is not None:
            old.close()
        name = next(name for name in _names(path) if not name.exists())
        for ending in ("", *BESIDE):  # a log of the old file would be played back into the new one
            with suppress(FileNotFoundError):
                left = path.with_name(path.name + ending)
                left.replace(name.with_name(name.name + ending)) if aside else left.unlink()
        draft.replace(path)
    finally:
        if old is not None:
            old.close()
        draft.unlink(missing_ok=True)
    if aside:
        what = f"is damaged: {kept} of its cases are whole, and all others are computed again"
        warn_once(f"'{path}' {what}; the damaged file is now '{name.name}'")
    elif kept:
        what = f"is of format 1, without checksums: its {kept} cases are taken as they are, and have one from now on"
        warn_once(f"'{path}' {what}")


def _names(path: Path) -> Iterator[Path]:
    yield path.with_name(ASIDE)
    yield from (path.with_name(f"{ASIDE}.{number}") for number in count(1))


def _copy(old: sqlite3.Connection | None, new: sqlite3.Connection) -> int:
    """How many whole cases were found and copied."""
    new.execute("BEGIN")
    for table in TABLES:
        for values in () if old is None else _whole(old, table):
            row = sealed(values)
            new.execute(f"INSERT OR REPLACE INTO {table} VALUES ({', '.join('?' * len(row))})", row)
    new.execute("COMMIT")
    kept: int = new.execute("SELECT count(*) FROM cases").fetchone()[0]
    return kept


def _whole(old: sqlite3.Connection, table: str) -> Iterator[Sequence[Any]]:
    """The rows that are whole, from both ends: what SQLite cannot read may stand between them."""
    first = TABLES[table].partition(" ")[0]
    for order in ("ASC", "DESC"):
        with suppress(sqlite3.DatabaseError):
            version = version_of(old)
            for row in old.execute(f"SELECT * FROM {table} ORDER BY {first} {order}"):
                values = whole_values(table, version, row)
                if values is not None:
                    yield values
            return
