"""The store's file: values of bytes by two names in an SQLite database, which many processes may use at once.

Its size is bounded: values used longest ago are dropped. A file that is damaged, or of another program, is renamed, and
a new one begun. Where no file can be opened, nothing is stored. A warning tells each of these once, and none of them
stops a study.
"""

from __future__ import annotations

import os
import sqlite3
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from time import time
from typing import TypeVar

from mbproj.errors import warn_once

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
    if given := os.environ.get("MBPROJ_CACHE"):
        return Path(given)
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
