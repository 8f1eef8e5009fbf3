"""The summary of a sweep as tables: a row a case in CSV, and arrays over what varies in HDF5 as netCDF-4 has it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.outputs import FileKind, csv, write_csv
from mbproj.results.sweep.layout import NOT_RUN
from mbproj.scene.ranges.family import column_of, with_unit
from mbproj.studies.sweep.design import Case
from mbproj.studies.sweep.folder import OTHER, TABLE, Folder, checksum_of
from mbproj.studies.sweep.row import CaseRow, Keys, Status
from mbproj.studies.sweep.spec import COLUMNS, Spec

#: How our table is known, whatever varies in it.
KIND: FileKind = csv(COLUMNS[:1], COLUMNS[1:])


@dataclass(frozen=True)
class CaseEntry:
    """A case, its row (None: it has not run), and its results file's name where that is kept."""

    values: Case
    row: CaseRow | None
    file: str

    @property
    def status(self) -> str:
        """In a word."""
        return NOT_RUN if self.row is None else self.row.status.value


def entries(spec: Spec, folder: Folder) -> Iterator[CaseEntry]:
    """All cases in the order of the design."""
    keys = Keys(spec.scene.whole, spec.design.paths)
    for number in range(spec.design.count):
        values = spec.design.case(number)
        key = keys.of(values)
        row = folder.store.row(key)
        file = folder.file_of(key)
        kept = row is not None and row.kept and file.exists()
        yield CaseEntry(values, row, str(file.relative_to(folder.path)) if kept else "")


def headings(spec: Spec) -> list[str]:
    """The columns of the CSV table: what varies and what is measured, with units in brackets, and how cases ended."""
    varied = [with_unit(column_of(path), spec.units[path]) for path in spec.design.paths]
    measured = [with_unit(each.name, each.unit) for each in spec.measures]
    first, *others = COLUMNS
    return [first, *varied, *measured, *others]


def write_table(spec: Spec, folder: Folder, force: bool = False) -> Path:
    """Writes summary.csv, whose checksum the store keeps. Raises InputError where it must not be replaced, unless
    `force`."""
    rows = cells(spec, folder)
    path = write_csv(folder.table, headings(spec), rows, kind=KIND, force=force, hint=OTHER)
    folder.store.describe({TABLE: checksum_of(path)})
    return path


def cells(spec: Spec, folder: Folder) -> Iterator[Sequence[Any]]:
    """The rows of the table, as `headings` has the columns; None where a case has no number."""
    for number, entry in enumerate(entries(spec, folder)):
        row = entry.row or CaseRow(Status.DONE)
        numbers = row.values or (None,) * len(spec.measures)
        known = [None if value is None or value != value else value for value in numbers]
        ended = [entry.status, row.message, row.time, row.joint, row.formulation, row.seconds, entry.file]
        yield [number, *entry.values, *known, *ended]
