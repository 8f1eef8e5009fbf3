"""The folder of a sweep: its spec and store, the results files that are kept, the summary."""

from __future__ import annotations

import re
from pathlib import Path
from time import strftime
from zlib import crc32

from mbproj.base.errors import InputError, Problem
from mbproj.base.version import __version__
from mbproj.kernel import build_info
from mbproj.results.file.checksums import as_text
from mbproj.results.file.opening import is_locked
from mbproj.results.output_files import make_folder
from mbproj.results.sweep_table import NAME
from mbproj.studies.sweep.spec import SweepSpec
from mbproj.studies.sweep.store import OTHER, Store, identity

STORE, CASES, TABLE = "store.sqlite", "cases", "summary.csv"
#: Names of the results files of cases, complete and unfinished.
CASE_FILE = re.compile(r"\.?[0-9a-f]{32}(-[0-9a-f]{8})?\.h5(\.part)?")
PRIVATE = re.compile(r"\.[0-9a-f]{32}-[0-9a-f]{8}\.h5(\.part)?")


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
