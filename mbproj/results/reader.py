"""`open_results`: opens and checks a results file; its faults are errors with a next step."""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType

from mbproj.base.errors import InputError, Problem
from mbproj.base.registry import load
from mbproj.results.crash_safety import part_path
from mbproj.results.faults import damaged, just_begun, not_ours
from mbproj.results.file.contents import Contents
from mbproj.results.file.opening import is_locked, open_file
from mbproj.results.layout import ALL_NAMES, CONSTANTS, FORMAT, NAMES, SCHEMA_VERSION, UNITS, datasets_for, trailing
from mbproj.results.record import Results, Same, ShownPart
from mbproj.results.trust import better_samples

#: A run that begins or ends changes its file within milliseconds: so often it is opened again, after a pause in s.
TRIALS, PAUSE = 10, 0.02

#: Properties of Results beside the samples, which are read from the file when they are asked for.
BESIDE_SAMPLES = (
    "title",
    "scene_text",
    "scene_path",
    "overrides",
    "settings",
    "gravity",
    "certified",
    "checkpoint",
    "events",
    "notes",
    "stored_loads",
    "trust",
    "verification",
)


def open_results(path: Path | str) -> Results:
    """Open the results at `path`; see `opened`."""
    return opened(path, Results)


def opened(path: Path | str, kind: type[Same]) -> Same:
    """Open the results at `path`, or those at `path`.part where a run was killed or still goes on (then `.partial`).

    Raises InputError where there is no file, or it is no results file, of another schema version, cut short or damaged.
    """
    load("mbproj.results.verification:Verification")  # here: a child would import it anew for each file

    for more in reversed(range(TRIALS)):
        existing = _existing(Path(path))
        try:
            return _results(
                open_file(existing, lambda contents: _look_at_all(_checked(contents, Results)), "results"), kind
            )
        except InputError as error:
            is_changing = is_locked(existing) or not existing.exists()
            if is_changing and not more:
                raise just_begun(existing) from error
            if not is_changing:
                raise
        time.sleep(PAUSE)
    raise AssertionError


def open_own_results(path: Path | str) -> Results:
    """Open results that this process has just written; see `opened_own`."""
    return opened_own(path, Results)


def opened_own(path: Path | str, kind: type[Same]) -> Same:
    """Open results that this process has just written, without the child process that reads others first."""
    return _results(open_file(Path(path), lambda contents: None), kind, just_written=True)


def _results(contents: Contents, kind: type[Same], *, just_written: bool = False) -> Same:
    try:
        return _checked(contents, kind, just_written=just_written)
    except BaseException:
        contents.close()
        raise


def _look_at_all(results: Results) -> None:
    """Read everything that a reader may ask for, and of the samples each place where the file stores some. Damage
    beside the samples is reported when a reader asks for that part."""
    for dataset in results.datasets:
        results.contents.check_room(dataset.path, results.shape(dataset.path)[0])
    for name in BESIDE_SAMPLES:
        with suppress(InputError):
            getattr(results, name)
    with suppress(InputError):
        better_samples(results.contents, len(results.names("bodies")))
    with suppress(InputError):
        results.meshes()
    for entry in CONSTANTS:
        with suppress(InputError):
            results.constant(entry.path)


def _existing(path: Path) -> Path:
    try:  # `path` twice: between the first look and the second the run may have ended, and renamed its file
        existing = next((candidate for candidate in (path, part_path(path), path) if candidate.exists()), None)
        is_directory = existing is not None and existing.is_dir()
    except (OSError, ValueError) as error:  # a name that is too long or not valid
        raise InputError(Problem(f"cannot read '{path}': {error}", hint="give the path of a results file")) from error
    if existing is None:
        hint = f"write it with: mbproj run SCENE -o {path}"
        raise InputError(Problem(f"there is no results file '{path}'", hint=hint))
    if is_directory:
        raise InputError(Problem(f"'{existing}' is a directory", hint="give a results file in it"))
    return existing


def _checked(contents: Contents, kind: type[Same], *, just_written: bool = False) -> Same:
    """The results. Raises InputError where parts are missing or do not fit together. In a file of this process,
    `just_written`, datasets are checked only when they are read."""
    attributes, path = contents.attributes(), contents.path
    if attributes.get("format") != FORMAT:
        raise not_ours(path)
    version = attributes.get("schema_version")
    if version != SCHEMA_VERSION:
        message = f"'{path}' has schema version {version}, and this mbproj reads version {SCHEMA_VERSION}"
        raise InputError(Problem(message, hint="repeat the run, or read it with the mbproj that wrote it"))
    if not isinstance(attributes.get("status"), str):
        raise damaged(path, "it has no status")
    names = {kind: _names(contents, kind) for kind in ALL_NAMES}
    samples = contents.rows("time", ()) if just_written else _samples(contents, _sizes(contents, names))
    return kind(contents, MappingProxyType(attributes), names, ShownPart(slice(0, samples), {}))


def _names(contents: Contents, kind: str) -> tuple[str, ...]:
    """The names of a kind. Raises InputError where one is not valid: names become file names and reach terminals."""
    path = ALL_NAMES[kind].path
    names = contents.texts(path) if kind in NAMES or contents.has(path) else ()
    for name in names:
        if not _fits(kind, name):
            raise contents.damaged(path, f"has {name!r}, which is not one")
    return names


def _sizes(contents: Contents, names: dict[str, tuple[str, ...]]) -> dict[str, int]:
    """The number of columns by symbol of the layout. Raises InputError where names and their units differ in number."""
    sizes: dict[str, int] = {}
    for kind, entry in ALL_NAMES.items():
        size = len(names[kind])
        if sizes.setdefault(entry.symbol, size) != size:
            raise contents.damaged(entry.path, f"has {size} entries for {sizes[entry.symbol]} columns")
    return sizes


def _fits(kind: str, name: str) -> bool:
    if kind in ("state_units", "signal_units"):
        return name.isprintable()
    return name in UNITS if kind.endswith("_units") else _can_be_a_name(name)


def _can_be_a_name(name: str) -> bool:
    return bool(name) and name.isprintable() and not set(name) & {"/", "\\"}


def _samples(contents: Contents, sizes: dict[str, int]) -> int:
    """The number of samples that all datasets have: after a kill some may be longer than others."""
    samples = min(contents.rows(entry.path, trailing(entry, sizes), entry.dtype) for entry in datasets_for(sizes))
    contents.grows_from = samples if contents.unfinished else None
    return samples
