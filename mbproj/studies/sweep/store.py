"""The store of a sweep: the result of each case, a row of the table, in one file of `mbproj.studies.store`.

The sweep's main process writes it. A row is on the disk when `add` returns, so that a killed sweep loses only the cases
in work. The file is locked as long as it is open: two sweeps never share a folder.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from enum import Enum
from math import isnan
from pathlib import Path

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode, InputError, MbprojError, Problem
from mbproj.results.file.checksums import as_text
from mbproj.scene.records import Expectation
from mbproj.studies.store import BESIDE, decoded, drop, encoded, opened_alone, put, rows


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


#: The studies in the file: the sweep's facts, and its cases by their keys.
ABOUT, CASES = "about", "cases"
OTHER = "choose another folder with -o"
#: A row without its values, and these by the identities of their measures.
STORED = tuple[CaseRow, dict[str, float]]


class StoreLost(MbprojError):
    """The error for a store that cannot be read or written any more: the disk is full or gone, or another program has
    changed it."""

    exit_code = ExitCode.FAILED


class Store:
    """Rows by the keys of their cases, and facts about the sweep by name. `measures` are the identities of the
    measures, in the order of a row's values. Methods raise StoreLost."""

    def __init__(self, path: Path, measures: Sequence[str]) -> None:
        """Opens the file, or makes it. Raises InputError where it is of another program, or another sweep has it
        open."""
        self.path, self._measures = path, tuple(measures)
        check_no_links(path)
        try:
            self._database = opened_alone(path)
        except sqlite3.Error as error:
            raise refused(path, error) from error
        except OSError as error:
            raise InputError(Problem(f"cannot write '{path}': {error.strerror or error}", hint=OTHER)) from error

    def close(self) -> None:
        """Closes the file, which ends the lock."""
        self._database.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def about(self) -> dict[str, str]:
        """The stored facts, by name."""
        with self._at_work():
            return about(self._database)

    def describe(self, facts: Mapping[str, str]) -> None:
        """Stores facts."""
        with self._at_work():
            put(self._database, ABOUT, "", encoded({**about(self._database), **facts}))

    def forget(self) -> None:
        """Drops all rows."""
        with self._at_work():
            drop(self._database, CASES)

    def add(self, key: str, row: CaseRow) -> None:
        """Stores a row, in place of an earlier one of the same case."""
        time = None if row.time is None or isnan(row.time) else row.time
        bare = replace(row, values=(), message=as_text(row.message), time=time, by_arrays=False)
        with self._at_work():
            put(self._database, CASES, key, encoded([bare, dict(zip(self._measures, row.values, strict=False))]))

    def row(self, key: str) -> CaseRow | None:
        """The row of a case; None where there is none, or it lacks a present measure."""
        return dict(self.rows(key)).get(key)

    def rows(self, key: str | None = None) -> Iterator[tuple[str, CaseRow]]:
        """All rows with all present measures, by their keys; or the row of one case."""
        with self._at_work():
            for found, data in rows(self._database, CASES, key):
                row = self._row(data)
                if row is not None:
                    yield found, row

    def _row(self, data: bytes) -> CaseRow | None:
        with suppress(ValueError):  # written by a version with other fields
            row, values = decoded(data, STORED)
            if row.status != Status.DONE:
                return row
            if values.keys() >= {*self._measures}:
                return replace(row, values=tuple(values[name] for name in self._measures))
        return None

    @contextmanager
    def _at_work(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            next_step = "make room, and start the sweep again" if "full" in str(error) else "start the sweep again"
            what = f"cannot go on with '{self.path}': {error}; {next_step}: what is whole in it is not computed again"
            raise StoreLost(what) from error


def about(database: sqlite3.Connection) -> dict[str, str]:
    """The facts about a sweep, by name."""
    facts: dict[str, str] = {}
    for _, data in rows(database, ABOUT):
        with suppress(ValueError):
            facts = decoded(data, dict[str, str])
    return facts


def check_no_links(path: Path) -> None:
    """Raises InputError where the database at `path`, or a file that SQLite writes beside it, is a link."""
    for each in (path, *(path.with_name(path.name + ending) for ending in BESIDE)):
        if each.is_symlink():
            what = f"'{each}' is a link, and a sweep keeps its rows in its own folder"
            raise InputError(Problem(what, hint=f"remove it, or {OTHER}"))


def refused(path: Path, error: sqlite3.Error) -> InputError:
    """The error for a database that cannot be opened."""
    if "locked" in str(error):
        hint = f"wait until it has ended, or {OTHER}"
        return InputError(Problem(f"another sweep is at work in '{path.parent}'", hint=hint))
    if isinstance(error, sqlite3.OperationalError):
        return InputError(Problem(f"cannot open '{path}': {error}", hint=OTHER))
    return InputError(Problem(f"'{path}' is not the store of a sweep: {error}", hint=OTHER))


def identity(measure: Expectation) -> str:
    """The identity of a measure, which does not depend on its name: its object, quantity, component and time."""
    further = [measure.over, *measure.between] if measure.over or measure.between else []
    return json.dumps([measure.of, measure.item, measure.quantity, measure.component, measure.at, *further])
