"""The /verification group of a results file (`verify --store`): what the checks of a mechanism found."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import h5py

from mbproj.errors import InputError, Problem
from mbproj.outputs import hdf5, replacing
from mbproj.results.faults import ELSEWHERE
from mbproj.results.files import DAMAGE, is_ours, part_path
from mbproj.results.layout import FORMAT
from mbproj.results.provenance import create_text
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
        """What `as_numbers` gave."""
        numbers = {key: float("nan") if values[key] is None else values[key] for key in ("measured", "allowed")}
        return cls(**{**values, **numbers})


@dataclass(frozen=True)
class Verification:
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


def store(path: Path, scene: Scene, verification: Verification) -> None:
    """Adds a verification to the results of the same scene, in place of one that is there.

    A copy is changed and renamed over the file, so that a kill leaves it whole. Raises InputError where there is no
    such file, or it is of another scene."""
    check_store(path, scene)
    with replacing(path, hdf5(FORMAT), force=True, hint=ELSEWHERE) as copy:
        shutil.copyfile(path, copy)
        with h5py.File(copy, "r+") as file:
            if GROUP in file:
                del file[GROUP]
            group = file.create_group(GROUP)
            records = [json.dumps(check.as_numbers()) for check in verification.checks]
            create_text(group, "checks", records, "a check a line (JSON): name, claim, measured, allowed, verdict")
            group.attrs.update({"formulation": verification.formulation, "mbproj_version": verification.version})


def read(file: h5py.File) -> Verification | None:
    """The group's content; None where there is none."""
    if GROUP not in file:
        return None
    group = file[GROUP]
    checks = tuple(Check.from_numbers(json.loads(bytes(record))) for record in group["checks"][:])
    return Verification(checks, str(group.attrs["formulation"]), str(group.attrs["mbproj_version"]))


def check_store(path: Path, scene: Scene) -> None:
    """Raises InputError unless the file holds finished results of this scene."""
    if not path.exists():
        still = f"its run is not at its end: '{part_path(path)}'" if part_path(path).exists() else "there is none yet"
        raise InputError(Problem(f"cannot store in '{path}': {still}", hint=f"mbproj run SCENE -o {path}"))
    if not is_ours(path):
        raise InputError(Problem(f"'{path}' is not a results file of mbproj", hint="give what 'mbproj run' wrote"))
    try:
        with h5py.File(path, "r") as file:
            text, changed = bytes(file["scene/text"][()]).decode(), json.loads(bytes(file["scene/overrides"][()]))
    except DAMAGE as error:
        raise InputError(Problem(f"'{path}' is damaged", hint="repeat the run")) from error
    if (text, changed) != (scene.text, dict(scene.overrides)):
        message = f"'{path}' holds results of another scene, or of other parameters"
        raise InputError(Problem(message, hint="verify the scene and --set that it was run with, or run it again"))
