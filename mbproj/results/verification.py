"""The /verification group of a results file (`verify --store`): what the checks of a mechanism found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import Any

import h5py

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.rehearsal import rehearse
from mbproj.results.faults import ELSEWHERE, cannot_write, damaged, not_ours
from mbproj.results.file.checksums import stamp_attributes
from mbproj.results.file.contents import Contents
from mbproj.results.file.dataset import DAMAGE
from mbproj.results.file.opening import open_rehearsed
from mbproj.results.file.whole import create_text
from mbproj.results.files import part_path
from mbproj.results.layout import FORMAT
from mbproj.results.views.table import Table, Tabled
from mbproj.scene.records import Scene
from mbproj.version import __version__

GROUP = "verification"
PASSED, FAILED, DOES_NOT_APPLY = "passed", "failed", "does not apply"


@dataclass(frozen=True)
class Check:
    """What a check found: its name and claim, what was `measured` and what is `allowed` (parts of what is compared,
    or orders; NaN where it does not apply), the verdict ("passed", "failed", "does not apply"), and why. `at_least`:
    whether the measured number is to be at least the allowed one, as an order is."""

    name: str
    claim: str
    measured: float
    allowed: float
    verdict: str
    remark: str = ""
    at_least: bool = False

    def as_numbers(self) -> dict[str, Any]:
        """For JSON: None for what is not a number."""
        values = asdict(self)
        return {**values, **{key: values[key] if isfinite(values[key]) else None for key in ("measured", "allowed")}}

    @classmethod
    def from_numbers(cls, values: Mapping[str, Any]) -> Check:
        """What `as_numbers` gave. Raises ValueError or the like for anything else."""
        numbers = {key: float("nan") if values[key] is None else float(values[key]) for key in ("measured", "allowed")}
        check = cls(**{**values, **numbers})
        texts = (check.name, check.claim, check.remark)
        if not all(isinstance(text, str) for text in texts) or check.verdict not in (PASSED, FAILED, DOES_NOT_APPLY):
            raise ValueError("not a check")
        return check


@dataclass(frozen=True)
class Verification(Tabled):
    """All checks of a mechanism, the formulation that its runs take, and the version of mbproj that made them."""

    checks: tuple[Check, ...]
    formulation: str
    version: str = __version__

    def of(self, verdict: str) -> list[Check]:
        """The checks that ended so."""
        return [check for check in self.checks if check.verdict == verdict]

    @property
    def holds(self) -> bool:
        """Whether none has failed."""
        return not self.of(FAILED)

    @property
    def table(self) -> Table:
        """A row a check."""
        return Table.of((asdict(check) for check in self.checks), "name", "claim", "measured", "allowed", "verdict")

    @property
    def line(self) -> str:
        """How many checks ended how."""
        told = (f"{len(self.of(verdict))} {verdict}" for verdict in (PASSED, FAILED, DOES_NOT_APPLY))
        return f"{', '.join(told)}; {self.formulation} formulation"

    __repr__ = Tabled.__repr__


def store(path: Path, scene: Scene, verification: Verification) -> None:
    """Adds a verification to the results of the same scene, in place of one that is there.

    A copy is changed and renamed over the file, so that a kill leaves it whole. Raises InputError where there is no
    such file, or it is of another scene."""
    import shutil

    from mbproj.outputs import hdf5, replacing

    check_store(path, scene)
    with replacing(path, hdf5(FORMAT), force=True, hint=ELSEWHERE) as copy:
        shutil.copyfile(path, copy)
        if not rehearse(lambda: _add(copy, path, verification), copy):
            _add(copy, path, verification)


def _add(copy: Path, path: Path, verification: Verification) -> None:
    """Write the group into a copy of the file at `path`. A child does it: HDF5 may not come back."""
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
    """The group's content; None where there is none."""
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
    """Raises InputError unless the file holds finished results of this scene."""
    if not path.exists():
        still = f"its run is not at its end: '{part_path(path)}'" if part_path(path).exists() else "there is none yet"
        raise InputError(Problem(f"cannot store in '{path}': {still}", hint=f"mbproj run SCENE -o {path}"))
    with open_rehearsed(path, _run_of) as contents:
        text, changed = _run_of(contents)
    if (text, changed) != (scene.text, dict(scene.overrides)):
        message = f"'{path}' holds results of another scene, or of other parameters"
        raise InputError(Problem(message, hint="verify the scene and --set that it was run with, or run it again"))


def _run_of(contents: Contents) -> tuple[str, Any]:
    """The text of the scene that was run, and what --set changed."""
    if contents.attributes().get("format") != FORMAT:
        raise not_ours(contents.path)
    try:
        return contents.text("scene/text"), json.loads(contents.text("scene/overrides"))
    except (ValueError, RecursionError) as error:
        raise contents.damaged("scene/overrides", "is not JSON") from error
