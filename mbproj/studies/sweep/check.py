"""Checks all files of a sweep against their checksums (`info --check DIR`). Nothing is changed."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.results import check_results, open_results
from mbproj.results.sweep.layout import NAME, WITHOUT_CHECKSUMS
from mbproj.results.sweep.table import read_table, version_of_table
from mbproj.studies.sweep import database
from mbproj.studies.sweep.folder import CASES, STORE, TABLE, checksum_of
from mbproj.studies.sweep.summary import KIND


@dataclass(frozen=True)
class SweepSoundness:
    """The result of the check. `faults`: a sentence for each. `rows`: the number of rows of the store; `files`: of
    results files read. `unguarded`: the files of older versions of mbproj, without checksums. `damaged`: the damaged
    results files, which a sweep keeps until they are deleted."""

    faults: tuple[str, ...]
    rows: int
    files: int
    unguarded: tuple[str, ...]
    damaged: tuple[str, ...]


def check_sweep(folder: Path) -> SweepSoundness:
    """Reads the store, both tables and all results files. Raises InputError where there is no sweep."""
    store, table, arrays = folder / STORE, folder / TABLE, folder / NAME
    if not store.is_file():
        hint = "give a results file, or the folder that 'mbproj sweep SPEC' has written"
        raise InputError(Problem(f"'{folder}' is not the folder of a sweep: it has no '{STORE}'", hint=hint))
    faults, unguarded, rows, checksum = [], [], 0, None
    try:
        looked, checksum = _look_at(store)
        rows = looked.cases
        faults += [f"{STORE}: {fault}" for fault in looked.faults]
        faults += [f"{STORE}: {looked.damaged} of {rows} rows are damaged"] if looked.damaged else []
        unguarded += [STORE] if looked.version == database.WITHOUT_CHECKSUMS else []
    except sqlite3.Error as error:
        if not database.is_damage(store, error):
            raise database.refused(store, error) from error
        faults.append(f"{STORE}: {error}")
    if table.is_file():
        unguarded += [TABLE] if checksum is None else []
        if checksum not in (None, checksum_of(table)):
            next_step = "" if KIND.is_ours(table) else ", and not to be told from another program's: remove it"
            faults.append(f"{TABLE}: it is not as it was written{next_step}")
    if arrays.is_file():
        try:
            read_table(folder)
            unguarded += [NAME] if version_of_table(folder) == WITHOUT_CHECKSUMS else []
        except InputError as error:
            faults += [f"{NAME}: {problem.message}" for problem in error.problems]
    cases = sorted((folder / CASES).glob("[0-9a-f]*.h5"))
    of_cases = {f"{CASES}/{case.name}": list(_of_results(case)) for case in cases}
    faults += [f"{name}: {fault}" for name, case_faults in of_cases.items() for fault in case_faults]
    damaged = tuple(name for name, case_faults in of_cases.items() if case_faults)
    return SweepSoundness(tuple(faults), rows, len(cases), tuple(unguarded), damaged)


def _look_at(store: Path) -> tuple[database.Looked, str | None]:
    """The check of the store, and the table's checksum, if any. A log of SQLite beside the store means that a sweep is
    running, or was killed: then the store is opened with a lock."""
    database.check_no_links(store)
    if store.with_name(store.name + "-wal").exists():
        with closing(database.locked(store)) as opened:
            return database.look(opened), _checksum(opened)
    with closing(sqlite3.connect(f"{store.absolute().as_uri()}?mode=ro&immutable=1", uri=True)) as opened:
        database.prepare(opened)
        return database.look(opened), _checksum(opened)


def _checksum(opened: sqlite3.Connection) -> str | None:
    row = opened.execute("SELECT value FROM about WHERE name = ?", [TABLE]).fetchone()
    return None if row is None else str(row[0])


def _of_results(case: Path) -> Iterator[str]:
    try:
        with open_results(case) as results:
            yield from check_results(results).faults
    except InputError as error:
        yield from (problem.message for problem in error.problems)
