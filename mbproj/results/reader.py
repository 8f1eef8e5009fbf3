"""`open_results`: a results file opened and checked; what is wrong with it is said with a next step."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np

from mbproj.errors import InputError, Problem
from mbproj.results.faults import damaged, not_ours
from mbproj.results.files import DAMAGE, open_file, part_path
from mbproj.results.layout import DATASETS, FORMAT, NAMES, SCHEMA_VERSION, trailing
from mbproj.results.record import Results, View

#: What is wrong with a file that HDF5 can read.
UNFINISHED = "the run that wrote it was killed before its first samples, or the file was cut short"


def open_results(path: Path | str) -> Results:
    """The results at `path`, or those at `path`.part where a run was killed or still goes on (then `.partial`).

    Raises InputError where there is no file, it is not ours, of another schema version, cut short or damaged.
    """
    actual = _existing(Path(path))
    try:
        file = open_file(actual)
    except DAMAGE as error:
        raise _unreadable(actual) from error
    try:
        return _checked(file, actual)
    except BaseException:
        file.close()
        raise


def _existing(path: Path) -> Path:
    try:
        found = next((candidate for candidate in (path, part_path(path)) if candidate.exists()), None)
        is_directory = found is not None and found.is_dir()
    except (OSError, ValueError) as error:  # a name too long, or that cannot be one
        raise InputError(Problem(f"cannot read '{path}': {error}", hint="give the path of a results file")) from error
    if found is None:
        hint = f"write it with: mbproj run SCENE -o {path}"
        raise InputError(Problem(f"there is no results file '{path}'", hint=hint))
    if is_directory:
        raise InputError(Problem(f"'{found}' is a directory", hint="give a results file in it"))
    return found


def _unreadable(path: Path) -> InputError:
    try:
        with path.open("rb") as file:
            signature = file.read(8)
    except OSError as error:
        return InputError(Problem(f"cannot read '{path}': {error.strerror}", hint="check who may read it"))
    if signature == b"\x89HDF\r\n\x1a\n":
        return damaged(path, UNFINISHED)
    return not_ours(path)


def _checked(file: h5py.File, path: Path) -> Results:
    try:
        attributes = {name: _plain(value) for name, value in file.attrs.items()}
    except DAMAGE as error:
        raise damaged(path, "its attributes cannot be read") from error
    if attributes.get("format") != FORMAT:
        raise not_ours(path)
    version = attributes.get("schema_version")
    if version != SCHEMA_VERSION:
        message = f"'{path}' has schema version {version}, and this mbproj reads version {SCHEMA_VERSION}"
        raise InputError(Problem(message, hint="repeat the run, or read it with the mbproj that wrote it"))
    if "status" not in attributes:
        raise damaged(path, "it has no status")
    names = {kind: _names(file, path, kind) for kind in NAMES}
    samples = _samples(file, path, {entry.symbol: len(names[kind]) for kind, entry in NAMES.items()})
    return Results(file, path, MappingProxyType(attributes), names, View(slice(0, samples), {}))


def _plain(value: Any) -> Any:
    """A Python number or string for NumPy's."""
    return value.item() if isinstance(value, np.generic) else value


def _names(file: h5py.File, path: Path, kind: str) -> tuple[str, ...]:
    entry = NAMES[kind]
    try:
        return tuple(bytes(name).decode() for name in file[entry.path][:])
    except DAMAGE as error:
        raise damaged(path, f"'{entry.path}' cannot be read") from error


def _samples(file: h5py.File, path: Path, sizes: dict[str, int]) -> int:
    """The number of samples that every dataset has: after a kill some may be longer than others."""
    lengths = []
    for dataset in DATASETS:
        try:
            found = file[dataset.path]
            fits = found.shape[1:] == trailing(dataset, sizes) and found.dtype == dataset.dtype
            lengths.append(int(found.shape[0]))
        except DAMAGE as error:
            raise damaged(path, f"it has no '{dataset.path}'") from error
        if not fits:
            raise damaged(path, f"'{dataset.path}' has the wrong shape or type")
    return min(lengths)
