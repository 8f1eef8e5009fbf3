"""The store's file: values of bytes by two names in an SQLite database, which many processes may use at once.

It is bounded: what was used longest ago makes room. A file that is damaged, or not of mbproj, is set aside and a new
one begun; where none can be had, nothing is kept. Each of these is said once, and none of them stops a study.
"""

from __future__ import annotations

import os
import sqlite3
import stat
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from time import time
from typing import TypeVar

from platformdirs import user_cache_path

from mbproj.errors import warn_once

Result = TypeVar("Result")

#: Size of the file at most, and of one value, bytes.
BOUND, LARGEST = 256 << 20, 64 << 20
#: For another process that writes, s.
PATIENCE = 10.0
#: What SQLite keeps in the file's header for the program: whose file it is ("mbpr"), and in which format.
OURS, FORMAT = 0x6D627072, 1
SCHEMA = (
    "CREATE TABLE kept (study TEXT NOT NULL, item TEXT NOT NULL, used REAL NOT NULL, value BLOB NOT NULL, "
    "PRIMARY KEY (study, item))",
    "CREATE INDEX kept_by_use ON kept (used)",
)


class ForeignStore(sqlite3.DatabaseError):
    """A database, and not one of ours."""


def read(study: str) -> dict[str, bytes]:
    """All values of a study by the names of its items."""

    def work(database: sqlite3.Connection) -> dict[str, bytes]:
        items = dict(database.execute("SELECT item, value FROM kept WHERE study = ?", [study]).fetchall())
        if items:
            database.execute("UPDATE kept SET used = ? WHERE study = ?", [time(), study])
        return items

    return _done(work, {})


def write(study: str, item: str, value: bytes) -> None:
    """Keeps a value, in place of one of the same names, until its room is needed."""

    def work(database: sqlite3.Connection) -> None:
        _make_room(database, len(value))
        row = [study, item, time(), value]
        database.execute("INSERT OR REPLACE INTO kept (study, item, used, value) VALUES (?, ?, ?, ?)", row)

    if len(value) <= LARGEST:
        _done(work, None)


def forget(study: str) -> None:
    """Drops all values of a study."""
    _done(lambda database: database.execute("DELETE FROM kept WHERE study = ?", [study]) and None, None)


def _done(work: Callable[[sqlite3.Connection], Result], otherwise: Result) -> Result:
    """What `work` gives, in a transaction of its own; `otherwise` where there is no store to be had."""
    try:
        path = _private_folder() / "store.sqlite3"
        before = _identity(path)
        try:
            return _in_transaction(path, work)
        except sqlite3.OperationalError:
            raise
        except sqlite3.DatabaseError as error:
            if _identity(path) == before:  # or another process has set it aside already
                _set_aside(path, str(error))
            return _in_transaction(path, work)
    except (OSError, sqlite3.Error) as error:
        warn_once(f"studies keep nothing for the next time: {error}; MBPROJ_CACHE chooses another folder")
        return otherwise


def _in_transaction(path: Path, work: Callable[[sqlite3.Connection], Result]) -> Result:
    if path.exists() and not path.is_file():
        raise ForeignStore("it is no file")
    with closing(sqlite3.connect(path, timeout=PATIENCE, isolation_level=None)) as database:
        # Nothing waits for the disk: a power cut may cost the store, whose values have checksums, and no study.
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
        with suppress(sqlite3.Error):  # the database may be what is wrong
            database.execute("ROLLBACK")
        raise


def _check(database: sqlite3.Connection) -> None:
    """Makes the tables of a new file. Raises ForeignStore where the file has others."""
    tables = database.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL").fetchall()
    owner, version = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
    if not tables and not owner and not version:
        for statement in (*SCHEMA, f"PRAGMA application_id = {OURS}", f"PRAGMA user_version = {FORMAT}"):
            database.execute(statement)
    elif (owner, version) != (OURS, FORMAT) or {sql for (sql,) in tables} != set(SCHEMA):
        raise ForeignStore("it is the database of another program, or version")


def _make_room(database: sqlite3.Connection, size: int) -> None:
    """Drops what was used longest ago until so many bytes fit: pages that are free are filled before the file grows."""
    page = database.execute("PRAGMA page_size").fetchone()[0]
    oldest = "DELETE FROM kept WHERE rowid = (SELECT rowid FROM kept ORDER BY used LIMIT 1)"
    while True:
        pages, free = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_count", "freelist_count"))
        needed = size + size // 50 + 16 * page  # with what SQLite adds to them
        if (pages - free) * page + needed <= BOUND or not database.execute(oldest).rowcount:
            return


def _identity(path: Path) -> int | None:
    return path.stat().st_ino if path.exists() else None


def _set_aside(path: Path, why: str) -> None:
    """Renames what stands where the store is to be, in place of what was renamed before."""
    aside = path.with_name("store.aside")
    journal = path.with_name(f"{path.name}-journal")  # of this file: played back into the next it would destroy that
    journal.unlink(missing_ok=True)
    path.replace(aside)
    warn_once(f"'{path}' is not what mbproj has kept there ({why}): it is now '{aside.name}', and studies begin anew")


def _folder() -> Path:
    """MBPROJ_CACHE, or `mbproj` in the user's folder for caches."""
    given = os.environ.get("MBPROJ_CACHE")
    return Path(given) if given else user_cache_path("mbproj", appauthor=False)


def _private_folder() -> Path:
    """The folder `studies` in there, made where it is missing, that nobody else can read or write. Raises OSError where
    it cannot be made, or belongs to somebody else."""
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
