"""The folder of a sweep: its spec and store, the results files that are kept, the summary.

The store holds the results of a sweep: one SQLite file with a row for each case, written by the sweep's main process. A
row is on the disk when `add` returns, so that a killed sweep loses only the cases in work. The file is locked as long
as it is open: two sweeps never share a folder.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from time import strftime
from typing import Any
from zlib import crc32

from mbproj.base.errors import ExitCode, InputError, MbprojError, Problem
from mbproj.base.version import __version__
from mbproj.kernel import build_info
from mbproj.results.file.checksums import as_text
from mbproj.results.file.opening import is_locked
from mbproj.results.output_files import make_folder
from mbproj.results.sweep_table import NAME
from mbproj.studies.sweep.spec import SweepSpec
from mbproj.studies.sweep.store import (
    FORMAT,
    CaseRow,
    Status,
    as_stored,
    from_stored,
    identity,
    open_whole,
    sealed,
    whole_values,
)

STORE, CASES, TABLE = "store.sqlite", "cases", "summary.csv"
#: Names of the results files of cases, complete and unfinished.
CASE_FILE = re.compile(r"\.?[0-9a-f]{32}(-[0-9a-f]{8})?\.h5(\.part)?")
PRIVATE = re.compile(r"\.[0-9a-f]{32}-[0-9a-f]{8}\.h5(\.part)?")
OTHER = "choose another folder with -o"


class Folder:
    """The folder at `path`. Raises InputError where it holds files that are not of this sweep. `fresh` drops all
    earlier results."""

    def __init__(self, path: Path, spec: SweepSpec, fresh: bool) -> None:
        self.path = make_folder(path, OTHER)
        self.cases, self.table, self.arrays = (self.path / name for name in (CASES, TABLE, NAME))
        if not (self.path / STORE).exists():
            self._require_empty()
        self.store = Store(self.path / STORE, [identity(measure) for measure in spec.measures])
        try:
            self._take(spec, fresh)
        except BaseException:
            self.store.close()
            raise

    def _require_empty(self) -> None:
        others = sorted(item.name for item in self.path.iterdir())
        if others:
            problem = Problem(f"'{self.path}' is not the folder of a sweep: it holds '{others[0]}'", hint=OTHER)
            raise InputError(problem)

    def _take(self, spec: SweepSpec, fresh: bool) -> None:
        about = self.store.about()
        before = about.get("scene", _scene_of(spec))
        if not fresh and before != _scene_of(spec):
            hint = f"{OTHER}, or begin anew with --fresh"
            message = f"'{self.path}' holds a sweep of '{before}', not of '{_scene_of(spec)}'"
            raise InputError(Problem(message, hint=hint))
        if fresh:
            self.store.forget()
        self._remove(CASE_FILE if fresh else PRIVATE)
        self.store.describe(_facts(spec) | ({} if "begun" in about and not fresh else {"begun": _time_stamp()}))
        if spec.keep != "none":
            make_folder(self.cases, OTHER)

    def remove_unfinished(self) -> None:
        """Removes unfinished results files, whose processes have ended."""
        self._remove(PRIVATE)

    def _remove(self, names: re.Pattern[str]) -> None:
        for file in self.cases.glob("*") if self.cases.is_dir() else ():
            if names.fullmatch(file.name) and file.is_file() and not is_locked(file):
                file.unlink(missing_ok=True)

    def file_of(self, key: str) -> Path:
        """The results file of a case."""
        return self.cases / f"{key}.h5"


def checksum_of(table: Path) -> str:
    """CRC-32 of a table, as the store has it."""
    return f"{crc32(table.read_bytes()):08x}"


def _scene_of(spec: SweepSpec) -> str:
    """The name of the scene's file, which identifies a sweep wherever its folder is moved."""
    return as_text(spec.scene.path.name) if spec.scene.path is not None else ""


def _facts(spec: SweepSpec) -> dict[str, str]:
    return {
        "scene": _scene_of(spec),
        "scene_text": spec.scene.text,
        "spec": spec.path.name,
        "spec_text": spec.text,
        "mbproj_version": __version__,
        "kernel": str(build_info()),
        "updated": _time_stamp(),
    }


def _time_stamp() -> str:
    return strftime("%Y-%m-%dT%H:%M:%S%z")


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
        self._database = open_whole(path)

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
            return dict(self._database.execute("SELECT name, value FROM about").fetchall())

    def describe(self, facts: Mapping[str, str]) -> None:
        """Stores facts."""
        with self._at_work():
            self._database.executemany("INSERT OR REPLACE INTO about VALUES (?, ?, ?)", map(sealed, facts.items()))

    def forget(self) -> None:
        """Drops all rows."""
        with self._at_work():
            self._database.execute("DELETE FROM cases")

    def add(self, key: str, parameters: Mapping[str, Any], row: CaseRow) -> None:
        """Stores a row, in place of an earlier one of the same case."""
        values = sealed(as_stored(key, parameters, self._measures, row))
        with self._at_work():
            self._database.execute(f"INSERT OR REPLACE INTO cases VALUES ({', '.join('?' * len(values))})", values)

    def row(self, key: str) -> CaseRow | None:
        """The row of a case; None where there is none, or it lacks a present measure."""
        with self._at_work():
            stored = self._database.execute("SELECT * FROM cases WHERE key = ?", [key]).fetchone()
            return None if stored is None else self._row(stored)

    def rows(self) -> Iterator[tuple[str, CaseRow]]:
        """All rows with all present measures, by their keys."""
        with self._at_work():
            for record in self._database.execute("SELECT * FROM cases"):
                row = self._row(record)
                if row is not None:
                    yield record[0], row

    def _row(self, record: Sequence[Any]) -> CaseRow | None:
        whole = whole_values("cases", FORMAT, record)
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
