"""The summary of a sweep: a CSV table with a row for each case, and arrays over the varied values in HDF5, in the
layout of netCDF-4.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.text import escaped
from mbproj.base.version import __version__
from mbproj.results.check import check_results
from mbproj.results.file.checksums import crc32, describe, stamp, stamp_attributes
from mbproj.results.output_files import FileKind, check_replaceable, csv, hdf5, replacing
from mbproj.results.reader import open_results
from mbproj.results.sweep_table import (
    CASE,
    ENDINGS,
    FORMAT,
    NAME,
    NOT_RUN,
    SCHEMA_VERSION,
    WITHOUT_CHECKSUMS,
    read_table,
    version_of_table,
)
from mbproj.results.table_files import write_csv
from mbproj.scene.ranges import column_of, with_unit
from mbproj.studies.store import faults_of, is_damage, only_read
from mbproj.studies.sweep.folder import CASES, STORE, TABLE, Folder, checksum_of
from mbproj.studies.sweep.spec import COLUMNS, Case, Grid, Sampled, SweepSpec
from mbproj.studies.sweep.store import CASES as STORED_CASES
from mbproj.studies.sweep.store import OTHER, CaseRow, Status, about, check_no_links, refused

if TYPE_CHECKING:
    import h5py


#: The kind of our table, recognised for any varied values.
KIND: FileKind = csv(COLUMNS[:1], COLUMNS[1:])
ARRAYS = hdf5(FORMAT)
SECONDS = frozenset({"time", "seconds"})
#: The value where nothing is known, and its type: for texts, for seconds.
MISSING: tuple[tuple[Any, Any], ...] = (("", object), (np.nan, float))


@dataclass(frozen=True)
class CaseEntry:
    """A case, its row (None where it has not run), and the name of its results file ("" where it is not kept)."""

    values: Case
    row: CaseRow | None
    file: str

    @property
    def status(self) -> str:
        """The status in a word."""
        return NOT_RUN if self.row is None else self.row.status.value


def entries(spec: SweepSpec, folder: Folder) -> Iterator[CaseEntry]:
    """All cases in the order of the design."""
    for number in range(spec.design.count):
        values = spec.design.case(number)
        key = spec.key_of(values)
        row = folder.store.row(key)
        file = folder.file_of(key)
        has_file = row is not None and row.kept and file.exists()
        yield CaseEntry(values, row, str(file.relative_to(folder.path)) if has_file else "")


def headings(spec: SweepSpec) -> list[str]:
    """The columns of the CSV table: the varied values and the measures, with units in brackets, and the ends of
    cases."""
    varied = [with_unit(column_of(path), spec.units[path]) for path in spec.design.paths]
    measured = [with_unit(each.name, each.unit) for each in spec.measures]
    first, *others = COLUMNS
    return [first, *varied, *measured, *others]


def check_summary(folder: Folder, force: bool) -> None:
    """Raises InputError where a file of another kind is in the way of the summary, unless `force`."""
    for path, kind in ((folder.table, KIND), (folder.arrays, ARRAYS)):
        check_replaceable(path, kind, force=force, hint=OTHER)


def write_summary(spec: SweepSpec, folder: Folder, force: bool = False) -> list[Path]:
    """Writes summary.csv and summary.h5, whose checksums the store keeps. The cases are read once for both. Raises
    InputError as `check_summary`."""
    columns = _Columns(spec)
    rows = cells(spec, columns.taken(entries(spec, folder)))
    table = write_csv(folder.table, headings(spec), rows, kind=KIND, force=force, hint=OTHER)
    arrays = _write_arrays(spec, folder, columns, force)
    folder.store.describe({TABLE: checksum_of(table), NAME: checksum_of(arrays)})
    return [table, arrays]


def cells(spec: SweepSpec, cases: Iterable[CaseEntry]) -> Iterator[Sequence[Any]]:
    """Yield the rows of the table with the columns of `headings`; None where a case has no number."""
    for number, entry in enumerate(cases):
        row = entry.row or CaseRow(Status.DONE)
        numbers = row.values or (None,) * len(spec.measures)
        known = [None if value is None or value != value else value for value in numbers]
        ended = [entry.status, row.message, row.time, row.joint, row.formulation, row.seconds, entry.file]
        yield [number, *entry.values, *known, *ended]


def _write_arrays(spec: SweepSpec, folder: Folder, columns: _Columns, force: bool) -> Path:
    """Writes summary.h5. Arrays of a grid have a dimension for each varied quantity, those of other designs one for the
    cases."""
    import h5py

    path = folder.arrays
    with (
        replacing(path, ARRAYS, force=force, hint=OTHER) as draft,
        h5py.File(draft, "w", track_order=True) as file,
    ):
        file.attrs.update(_about(spec))
        axes = _axes(file, spec, columns)
        shape = tuple(len(axis) for axis in axes)
        for measure, values in zip(spec.measures, columns.measured, strict=True):
            words = (measure.of, measure.item, measure.quantity, measure.component, f"at {measure.at}")
            said = " ".join(word for word in words if word)
            _variable(file, measure.name, np.reshape(values, shape), axes, measure.unit or "1", said)
        for name, said in ENDINGS.items():
            column = np.reshape(columns.endings[name], shape)
            _variable(file, name, column, axes, "s" if name in SECONDS else "", said)
        stamp_attributes(file)
    return path


class _Columns:
    """All cases by columns; a million cases take tens of megabytes. `measured` (m, N) are the measures, `endings` the
    ends of cases. `varied` are the varied values, empty for a grid."""

    def __init__(self, spec: SweepSpec) -> None:
        count = spec.design.count
        self.measured = np.full((len(spec.measures), count), np.nan)
        self.endings = {name: np.full(count, *MISSING[name in SECONDS]) for name in ENDINGS}
        self.varied = [] if isinstance(spec.design, Grid) else [np.empty(count, object) for _ in spec.design.paths]

    def taken(self, cases: Iterable[CaseEntry]) -> Iterator[CaseEntry]:
        """Yield the cases again, in order, when they are in the columns."""
        texts: dict[str, str] = {}  # equal texts of many cases share one object
        for number, entry in enumerate(cases):
            for column, item in zip(self.varied, entry.values, strict=bool(self.varied)):
                column[number] = item
            self.endings["status"][number] = entry.status
            row = entry.row
            if row is not None and row.values:
                self.measured[:, number] = row.values
            for name, column in self.endings.items() if row is not None else ():
                value = None if name == "status" else getattr(row, name)
                if value is not None:
                    column[number] = texts.setdefault(value, value) if isinstance(value, str) else value
            yield entry


def _about(spec: SweepSpec) -> dict[str, Any]:
    design = spec.design
    sampled = {"samples": design.samples, "seed": design.seed} if isinstance(design, Sampled) else {}
    return {
        "format": FORMAT,
        "schema_version": SCHEMA_VERSION,
        "Conventions": "CF-1.8",
        "title": f"Sweep of {spec.scene.path.name if spec.scene.path else 'a scene'}",
        "source": f"mbproj {__version__}",
        "combine": design.name,
        "varied": [column_of(path) for path in design.paths],
        "measured": [each.name for each in spec.measures],
        "spec": spec.text,
        "scene": spec.scene.text,
        **sampled,
    }


def _axes(file: h5py.File, spec: SweepSpec, columns: _Columns) -> list[h5py.Dataset]:
    """The dimensions; the varied values are written as coordinates on them."""
    design = spec.design
    if isinstance(design, Grid):
        axes = []
        for path, each in design.ranges.items():
            axis = _variable(file, column_of(path), _column(each.items), (), spec.units[path] or "1", path)
            axis.make_scale(column_of(path))
            axes.append(axis)
        return axes
    axis = _variable(file, CASE, np.arange(design.count), (), "", "number of the case")
    axis.make_scale(CASE)
    for path, values in zip(design.paths, columns.varied, strict=True):
        _variable(file, column_of(path), _column(values), [axis], spec.units[path] or "1", path)
    file.attrs["coordinates"] = " ".join(map(column_of, design.paths))
    return [axis]


def _column(values: Iterable[float | str]) -> npt.NDArray[Any]:
    """An array of numbers, or of texts without line ends, as in the table."""
    items = list(values)
    if all(isinstance(value, float) for value in items):
        return np.array(items, dtype=float)
    return np.array([escaped(str(value)) for value in items], dtype=object)


def _variable(
    file: h5py.File, name: str, values: npt.NDArray[Any], axes: Sequence[h5py.Dataset], unit: str, said: str
) -> h5py.Dataset:
    import h5py

    kind = h5py.string_dtype() if values.dtype == object else None
    variable = file.create_dataset(name, data=values, dtype=kind, track_order=True)
    stamp(variable, crc32(values))
    describe(variable, {"long_name": said, **({"units": unit} if unit else {})})
    for number, axis in enumerate(axes):
        variable.dims[number].attach_scale(axis)
    return variable


# --- Checks all files of a sweep against their checksums (`info --check DIR`) -----------------------------------------
# Nothing is changed.


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
    faults, unguarded, rows, checksums = [], [], 0, dict[str, str]()
    try:
        check_no_links(store)
        wrong, rows, checksums = only_read(store, _looked_at)
        faults += [f"{STORE}: {fault}" for fault in wrong]
    except sqlite3.Error as error:
        if not is_damage(store, error):
            raise refused(store, error) from error
        faults.append(f"{STORE}: {error}")
    if table.is_file():
        unguarded += [] if TABLE in checksums else [TABLE]
        if checksums.get(TABLE, known := checksum_of(table)) != known:
            next_step = "" if KIND.is_ours(table) else ", and not to be told from another program's: remove it"
            faults.append(f"{TABLE}: it is not as it was written{next_step}")
    if arrays.is_file():
        try:
            read_table(folder)
            unguarded += [NAME] if version_of_table(folder) == WITHOUT_CHECKSUMS else []
            if checksums.get(NAME, known := checksum_of(arrays)) != known:
                faults.append(f"{NAME}: it is not as it was written, or that of another sweep")
        except InputError as error:
            faults += [f"{NAME}: {problem.message}" for problem in error.problems]
    cases = sorted((folder / CASES).glob("[0-9a-f]*.h5"))
    of_cases = {f"{CASES}/{case.name}": list(_of_results(case)) for case in cases}
    faults += [f"{name}: {fault}" for name, case_faults in of_cases.items() for fault in case_faults]
    damaged = tuple(name for name, case_faults in of_cases.items() if case_faults)
    return SweepSoundness(tuple(faults), rows, len(cases), tuple(unguarded), damaged)


def _looked_at(store: sqlite3.Connection) -> tuple[list[str], int, dict[str, str]]:
    """The faults of the store, the number of its cases, and the known checksums of both tables by name."""
    (count,) = store.execute("SELECT count(*) FROM kept WHERE study = ?", [STORED_CASES]).fetchone()
    return faults_of(store), count, {name: known for name, known in about(store).items() if name in (TABLE, NAME)}


def _of_results(case: Path) -> Iterator[str]:
    try:
        with open_results(case) as results:
            yield from check_results(results).faults
    except InputError as error:
        yield from (problem.message for problem in error.problems)
