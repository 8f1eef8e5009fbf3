"""What a sweep has done: one SQLite file in its folder, a row a case, written by the sweep's leading process.

A row is on the disk when `add` returns, so that a sweep that is killed loses only what was at work. The file is locked
as long as it is open: two sweeps never share a folder.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from mbproj.errors import ExitCode, MbprojError
from mbproj.studies.sweep.database import FORMAT, open_whole, sealed, whole_values
from mbproj.studies.sweep.row import CaseRow, Status, as_stored, from_stored


class StoreLost(MbprojError):
    """The store cannot be read or written any more: the disk is full or gone, or something else has changed it."""

    exit_code = ExitCode.FAILED


class Store:
    """Rows by the keys of their cases, and facts about the sweep by name. `measures` are the identities of what is
    measured, in the order of a row's values. Methods raise StoreLost."""

    def __init__(self, path: Path, measures: Sequence[str]) -> None:
        """Opens the file, or makes it. Raises InputError where it is not ours, or another sweep has it open."""
        self.path, self._measures = path, tuple(measures)
        self._database = open_whole(path)

    def close(self) -> None:
        """Ends the lock."""
        self._database.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def about(self) -> dict[str, str]:
        """The facts."""
        with self._at_work():
            return dict(self._database.execute("SELECT name, value FROM about").fetchall())

    def describe(self, facts: Mapping[str, str]) -> None:
        """Keeps facts."""
        with self._at_work():
            self._database.executemany("INSERT OR REPLACE INTO about VALUES (?, ?, ?)", map(sealed, facts.items()))

    def forget(self) -> None:
        """Drops all rows."""
        with self._at_work():
            self._database.execute("DELETE FROM cases")

    def add(self, key: str, parameters: Mapping[str, Any], row: CaseRow) -> None:
        """Keeps a row, in place of one of the same case."""
        values = sealed(as_stored(key, parameters, self._measures, row))
        with self._at_work():
            self._database.execute(f"INSERT OR REPLACE INTO cases VALUES ({', '.join('?' * len(values))})", values)

    def row(self, key: str) -> CaseRow | None:
        """The row of a case; None where there is none, or it has not all that is measured now."""
        with self._at_work():
            found = self._database.execute("SELECT * FROM cases WHERE key = ?", [key]).fetchone()
            return None if found is None else self._row(found)

    def rows(self) -> Iterator[tuple[str, CaseRow]]:
        """All rows that have what is measured now, by their keys."""
        with self._at_work():
            for found in self._database.execute("SELECT * FROM cases"):
                row = self._row(found)
                if row is not None:
                    yield found[0], row

    def _row(self, found: Sequence[Any]) -> CaseRow | None:
        whole = whole_values("cases", FORMAT, found)
        if whole is None:
            raise sqlite3.DatabaseError("a row is not what was written")
        values, row = from_stored(whole)
        if row.status != Status.DONE:
            return row
        if not values.keys() >= {*self._measures}:
            return None
        known = (values[name] for name in self._measures)
        return replace(row, values=tuple(float("nan") if value is None else value for value in known))

    @contextmanager
    def _at_work(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            next_step = "make room, and start the sweep again" if "full" in str(error) else "start the sweep again"
            what = f"cannot go on with '{self.path}': {error}; {next_step}: what is whole in it is not computed again"
            raise StoreLost(what) from error
