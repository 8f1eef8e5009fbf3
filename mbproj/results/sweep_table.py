"""`read_table`: reads the summary of a sweep as columns, with one row for each case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import prod
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.results.faults import REPEAT
from mbproj.results.file.contents import Contents
from mbproj.results.file.opening import open_file

# --- The layout of summary.h5: arrays over the quantities that vary, and the ending of each case ----------------------

#: The file in the folder of a sweep.
NAME = "summary.h5"
FORMAT, SCHEMA_VERSION = "mbproj sweep", 2
#: The version of files without checksums.
WITHOUT_CHECKSUMS = 1
#: The dimension of designs that are not grids.
CASE = "case"
#: The endings of cases that were measured, and of those that have not run yet.
DONE, NOT_RUN = "done", "not run"
#: The texts on each case beside its measures, by name, with their descriptions.
ENDINGS: Mapping[str, str] = MappingProxyType(
    {
        "status": "how the case ended: done, failed, timeout, crashed, not run",
        "message": "why it failed",
        "time": "when it failed, in simulated time",
        "joint": "where it failed",
        "seconds": "how long it took, by the clock",
    }
)


# --- `read_table` -----------------------------------------------------------------------------------------------------

#: What a user may do where a path is no sweep, and where its file is of no use.
WANTED = "give the folder that 'mbproj sweep SPEC' has written"
AGAIN = "write it again with: mbproj sweep SPEC"
#: The design in which every value of a quantity meets every value of the others.
GRID = "grid"


@dataclass(frozen=True, eq=False)
class Column:
    """A quantity of a sweep: its values (N,), numbers or texts, and their SI unit, "1" or "" for none."""

    name: str
    unit: str
    values: npt.NDArray[Any]

    @property
    def is_number(self) -> bool:
        """Whether the values are numbers."""
        return bool(self.values.dtype.kind == "f")

    @property
    def varies(self) -> bool:
        """Whether the column has more than one value; NaN does not count."""
        known = self.values[np.isfinite(self.values)] if self.is_number else self.values
        return len(known) > 0 and bool(np.any(known != known[0]))


@dataclass(frozen=True, eq=False)
class SweepCases:
    """N cases: the columns that vary, those measured (NaN where a case has no value), and the ending of each in a word.
    `shape` has the lengths of a grid, the last axis fastest, and is (N,) for other designs. `samples` is the number of
    samples that were asked for."""

    name: str
    title: str
    combine: str
    samples: int
    shape: tuple[int, ...]
    varied: tuple[Column, ...]
    measured: tuple[Column, ...]
    status: npt.NDArray[Any]

    @property
    def failed(self) -> npt.NDArray[np.bool_]:
        """Whether each case (N,) was run and failed."""
        is_failed: npt.NDArray[np.bool_] = (self.status != DONE) & (self.status != NOT_RUN)
        return is_failed


def read_table(path: Path) -> SweepCases:
    """Read the summary in a sweep's folder, or the file at `path`. Raises InputError where there is none, or it is
    damaged."""
    file = path / NAME if path.is_dir() else path
    if not file.is_file():
        raise InputError(Problem(f"'{path}' is not the folder of a sweep: it has no '{NAME}'", hint=WANTED))
    name = (path if path.is_dir() else file.absolute().parent).absolute().name
    try:
        with open_file(file, lambda contents: _read(contents, name), "sweep") as contents:
            return _read(contents, name)
    except InputError as error:
        raise InputError(
            [replace(each, hint=AGAIN) if each.hint == REPEAT else each for each in error.problems]
        ) from error


def version_of_table(path: Path) -> object:
    """The schema version of the summary in a sweep's folder, as the file has it."""
    with open_file(path / NAME) as contents:
        return contents.attributes().get("schema_version")


def _read(contents: Contents, name: str) -> SweepCases:
    about = contents.attributes()
    if about.get("format") != FORMAT:
        raise InputError(Problem(f"'{contents.path}' is not the summary of a sweep", hint=WANTED))
    version = about.get("schema_version")
    if version not in (WITHOUT_CHECKSUMS, SCHEMA_VERSION):
        cause = f"'{contents.path}' has schema version {version}, and this mbproj reads 1 and 2"
        raise InputError(Problem(cause, hint=AGAIN))
    for dataset in contents.datasets() if version == SCHEMA_VERSION else ():
        contents.check_whole(dataset)
    varied, measured = (contents.names_in(key) for key in ("varied", "measured"))
    combine = str(about.get("combine", ""))
    axes = varied if combine == GRID else (CASE,)
    shape = tuple(contents.length(axis) for axis in axes)
    # In a grid the file has each value of a coordinate once, not once for each case.
    coordinates = [contents.column(each, (shape[k],) if combine == GRID else shape) for k, each in enumerate(varied)]
    if combine == GRID and coordinates:
        indices = np.indices(shape).reshape(len(shape), -1)
        coordinates = [values[index] for values, index in zip(coordinates, indices, strict=True)]
    return SweepCases(
        name=name,
        title=str(about.get("title", "")),
        combine=combine,
        samples=int(about.get("samples", prod(shape))),
        shape=shape,
        varied=tuple(
            Column(each, _unit(contents, each), values) for each, values in zip(varied, coordinates, strict=True)
        ),
        measured=tuple(Column(each, _unit(contents, each), _numbers(contents, each, shape)) for each in measured),
        status=contents.column("status", shape).reshape(-1),
    )


def _unit(contents: Contents, name: str) -> str:
    """The unit of a dataset; "" for none, or one that no figure can show."""
    unit = contents.unit(name)
    return unit if isinstance(unit, str) and unit.isprintable() else ""


def _numbers(contents: Contents, name: str, shape: tuple[int, ...]) -> Array:
    return contents.array(name, shape).reshape(-1)
