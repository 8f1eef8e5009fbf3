"""What a sweep has done: one SQLite file in its folder, a row a case, written by the sweep's leading process.

A row is on the disk when `add` returns, so that a sweep that is killed loses only what was at work. The file is locked
as long as it is open: two sweeps never share a folder.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from math import isnan
from pathlib import Path
from typing import Any

from mbproj.errors import InputError, Problem
from mbproj.studies.sweep.row import Row, Status

#: What SQLite keeps in the file's header for the program: whose file it is ("mbsw"), and in which format.
OURS, FORMAT = 0x6D627377, 1
SCHEMA = (
    "CREATE TABLE about (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
    "CREATE TABLE cases (key TEXT PRIMARY KEY, parameters TEXT NOT NULL, status TEXT NOT NULL, measures TEXT NOT NULL, "
    "message TEXT NOT NULL, time REAL, joint TEXT NOT NULL, formulation TEXT NOT NULL, seconds REAL NOT NULL, "
    "kept INTEGER NOT NULL) WITHOUT ROWID",
)
COLUMNS = "status, measures, message, time, joint, formulation, seconds, kept"


class Store:
    """Rows by the keys of their cases, and facts about the sweep by name. `measures` are the identities of what is
    measured, in the order of a row's values."""

    def __init__(self, path: Path, measures: Sequence[str]) -> None:
        """Opens the file, or makes it. Raises InputError where it is not ours, or another sweep has it open."""
        self.path, self._measures = path, tuple(measures)
        try:
            self._database = sqlite3.connect(path, timeout=0.0, isolation_level=None)
            self._open()
        except sqlite3.OperationalError as error:
            if "locked" not in str(error):
                raise InputError(
                    Problem(f"cannot open '{path}': {error}", hint="choose another folder with -o")
                ) from error
            hint = "wait until it has ended, or choose another folder with -o"
            raise InputError(Problem(f"another sweep is at work in '{path.parent}'", hint=hint)) from error
        except sqlite3.DatabaseError as error:
            hint = "choose another folder with -o"
            raise InputError(Problem(f"'{path}' is not the store of a sweep: {error}", hint=hint)) from error

    def _open(self) -> None:
        # The lock is held as long as the file is open, so that no memory is shared: network file systems have none.
        self._database.execute("PRAGMA locking_mode = EXCLUSIVE")
        self._database.execute("PRAGMA journal_mode = WAL")
        self._database.execute("PRAGMA synchronous = NORMAL")
        self._database.execute("BEGIN IMMEDIATE")
        owner, version = (self._pragma(name) for name in ("application_id", "user_version"))
        tables = self._database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
        if not tables and not owner:
            for statement in (*SCHEMA, f"PRAGMA application_id = {OURS}", f"PRAGMA user_version = {FORMAT}"):
                self._database.execute(statement)
        elif (owner, version) != (OURS, FORMAT):
            raise sqlite3.DatabaseError("it is that of another program, or version")
        self._database.execute("COMMIT")

    def _pragma(self, name: str) -> int:
        found: int = self._database.execute(f"PRAGMA {name}").fetchone()[0]
        return found

    def close(self) -> None:
        """Ends the lock."""
        self._database.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def about(self) -> dict[str, str]:
        """The facts."""
        return dict(self._database.execute("SELECT name, value FROM about").fetchall())

    def describe(self, facts: Mapping[str, str]) -> None:
        """Keeps facts."""
        self._database.executemany("INSERT OR REPLACE INTO about VALUES (?, ?)", facts.items())

    def forget(self) -> None:
        """Drops all rows."""
        self._database.execute("DELETE FROM cases")

    def add(self, key: str, parameters: Mapping[str, Any], row: Row) -> None:
        """Keeps a row, in place of one of the same case."""
        values = {
            name: None if isnan(value) else value for name, value in zip(self._measures, row.values, strict=False)
        }
        texts = [key, json.dumps(dict(parameters)), row.status.value, json.dumps(values)]
        rest = [row.message, row.time, row.joint, row.formulation, row.seconds, int(row.kept)]
        self._database.execute(f"INSERT OR REPLACE INTO cases VALUES ({', '.join('?' * 10)})", [*texts, *rest])

    def row(self, key: str) -> Row | None:
        """The row of a case; None where there is none, or it has not all that is measured now."""
        found = self._database.execute(f"SELECT {COLUMNS} FROM cases WHERE key = ?", [key]).fetchone()
        return None if found is None else self._row(found)

    def rows(self) -> Iterator[tuple[str, Row]]:
        """All rows that have what is measured now, by their keys."""
        for key, *found in self._database.execute(f"SELECT key, {COLUMNS} FROM cases"):
            row = self._row(found)
            if row is not None:
                yield key, row

    def _row(self, found: Sequence[Any]) -> Row | None:
        status, measures, *rest = found
        values: dict[str, float | None] = json.loads(measures)
        if status == Status.DONE and not values.keys() >= {*self._measures}:
            return None
        numbers = (values.get(name) for name in self._measures) if status == Status.DONE else ()
        known = tuple(float("nan") if value is None else value for value in numbers)
        message, time, joint, formulation, seconds, kept = rest
        return Row(Status(status), known, message, time, joint, formulation, seconds, bool(kept))
