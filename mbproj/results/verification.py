"""The /verification group of a results file (`verify --store`): the findings of the checks of a mechanism."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from math import inf, isfinite, nan
from pathlib import Path
from typing import Any

import h5py

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.sandbox import try_in_sandbox
from mbproj.base.version import __version__
from mbproj.results.crash_safety import part_path
from mbproj.results.faults import ELSEWHERE, cannot_write, damaged, not_ours
from mbproj.results.file.checksums import create_text, stamp_attributes
from mbproj.results.file.contents import DAMAGE, Contents
from mbproj.results.file.opening import open_file
from mbproj.results.layout import FORMAT
from mbproj.results.output_files import check_replaceable, hdf5
from mbproj.results.views import Table, Tabled
from mbproj.scene.scene import Scene

GROUP = "verification"
PASSED, FAILED, DOES_NOT_APPLY = "passed", "failed", "does not apply"


@dataclass(frozen=True)
class Check:
    """The finding of a check: its name and claim, the `measured` and the `allowed` number, the verdict ("passed",
    "failed", "does not apply"), and why. The numbers are relative errors or orders; NaN where they do not apply.
    `at_least`: the measured number must be at least the allowed one, as for an order."""

    name: str
    claim: str
    measured: float
    allowed: float
    verdict: str
    remark: str = ""
    at_least: bool = False

    @property
    def share(self) -> float:
        """The measured number relative to its bound, above 1 where the check fails. Infinite where the check failed
        without a number, NaN where it does not apply."""
        part, whole = (self.allowed, self.measured) if self.at_least else (self.measured, self.allowed)
        if self.verdict == DOES_NOT_APPLY:
            return nan
        return part / whole if whole > 0.0 else 0.0 if part <= whole else inf

    def as_numbers(self) -> dict[str, Any]:
        """The finding as plain data for JSON, with None for NaN."""
        values = asdict(self)
        return {**values, **{key: values[key] if isfinite(values[key]) else None for key in ("measured", "allowed")}}

    @classmethod
    def from_numbers(cls, values: Mapping[str, Any]) -> Check:
        """The finding from the result of `as_numbers`. Raises ValueError or the like for other data."""
        numbers = {key: float("nan") if values[key] is None else float(values[key]) for key in ("measured", "allowed")}
        check = cls(**{**values, **numbers})
        texts = (check.name, check.claim, check.remark)
        if not all(isinstance(text, str) for text in texts) or check.verdict not in (PASSED, FAILED, DOES_NOT_APPLY):
            raise ValueError("not a check")
        return check


@dataclass(frozen=True)
class Verification(Tabled):
    """All checks of a mechanism, the formulation of its runs, and the version of mbproj that made them."""

    checks: tuple[Check, ...]
    formulation: str
    version: str = __version__

    def of(self, verdict: str) -> list[Check]:
        """The checks with this verdict."""
        return [check for check in self.checks if check.verdict == verdict]

    @property
    def holds(self) -> bool:
        """Whether no check has failed."""
        return not self.of(FAILED)

    @property
    def table(self) -> Table:
        """The table with a row for each check."""
        return Table.of((asdict(check) for check in self.checks), "name", "claim", "measured", "allowed", "verdict")

    @property
    def line(self) -> str:
        """The number of checks with each verdict, in one line."""
        told = (f"{len(self.of(verdict))} {verdict}" for verdict in (PASSED, FAILED, DOES_NOT_APPLY))
        return f"{', '.join(told)}; {self.formulation} formulation"

    __repr__ = Tabled.__repr__


def store(path: Path, scene: Scene, verification: Verification) -> None:
    """Add a verification to the results of the same scene; it replaces an earlier one.

    A copy is changed and renamed over the file, so that a kill leaves it whole. Raises InputError where there is no
    such file, or it is of another scene."""
    import shutil

    from mbproj.results.output_files import replacing

    check_store(path, scene)
    with replacing(path, hdf5(FORMAT), force=True, hint=ELSEWHERE) as copy:
        shutil.copyfile(path, copy)
        if not try_in_sandbox(lambda: _add(copy, path, verification), copy):
            _add(copy, path, verification)


def _add(copy: Path, path: Path, verification: Verification) -> None:
    """Write the group into a copy of the file at `path`. A child process does it, since HDF5 may not return."""
    try:
        with h5py.File(copy, "r+") as file:
            if GROUP in file:
                del file[GROUP]
            group = file.create_group(GROUP)
            records = [json.dumps(check.as_numbers()) for check in verification.checks]
            create_text(group, "checks", records, "a check a line (JSON): name, claim, measured, allowed, verdict")
            group.attrs.update({"formulation": verification.formulation, "mbproj_version": verification.version})
            stamp_attributes(group)
    except DAMAGE as error:
        if isinstance(error, OSError) and error.errno:
            raise cannot_write(path, error) from error
        raise damaged(path, "nothing can be added to it") from error


def read(contents: Contents) -> Verification | None:
    """Read the verification; None where the file has no such group."""
    if not contents.has(GROUP):
        return None
    attributes = contents.attributes(GROUP)
    formulation, version = (attributes.get(name) for name in ("formulation", "mbproj_version"))
    try:
        checks = tuple(Check.from_numbers(json.loads(record)) for record in contents.texts(f"{GROUP}/checks"))
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
        raise contents.damaged(f"{GROUP}/checks", "has a line that is no check") from error
    if not (isinstance(formulation, str) and isinstance(version, str)):
        raise contents.damaged(GROUP, "does not say of which formulation and version it is")
    return Verification(checks, formulation, version)


def check_store(path: Path, scene: Scene) -> None:
    """Raises InputError unless the file holds finished results of this scene, and can be replaced."""
    if not path.exists():
        still = f"its run is not at its end: '{part_path(path)}'" if part_path(path).exists() else "there is none yet"
        raise InputError(Problem(f"cannot store in '{path}': {still}", hint=f"mbproj run SCENE -o {path}"))
    with open_file(path, _run_of, "run") as contents:
        text, changed = _run_of(contents)
    if (text, changed) != (scene.text, dict(scene.overrides)):
        message = f"'{path}' holds results of another scene, or of other parameters"
        raise InputError(Problem(message, hint="verify the scene and --set that it was run with, or run it again"))
    check_replaceable(path, hdf5(FORMAT), force=True, hint=ELSEWHERE)


def _run_of(contents: Contents) -> tuple[str, Any]:
    """The text of the scene that was run, and the changes of --set."""
    if contents.attributes().get("format") != FORMAT:
        raise not_ours(contents.path)
    try:
        return contents.text("scene/text"), json.loads(contents.text("scene/overrides"))
    except (ValueError, RecursionError) as error:
        raise contents.damaged("scene/overrides", "is not JSON") from error
