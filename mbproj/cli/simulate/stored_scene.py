"""What `rerun` and `continue` take from a results file: its scene, with the settings of the run."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mbproj.errors import InputError, Place, Problem

if TYPE_CHECKING:
    from mbproj.results import Results
    from mbproj.scene import Scene


def stored_scene(results: Results) -> tuple[Scene, str]:
    """The scene of a run, and what to call it: the name of its file, or of the results. Raises InputError where the
    file is damaged there."""
    from mbproj.scene import read_scene_text

    name = str(results.scene_path or results.path)
    scene = read_scene_text(results.scene_text, name, results.overrides)
    _require_all(scene, results)
    return replace(scene, path=results.scene_path, settings=results.settings), name


def _require_all(scene: Scene, results: Results) -> None:
    """Raises InputError where the run had joints, forces or states that its scene does not have."""
    from mbproj.model import compile_system

    own = compile_system(scene).names
    for kind, names in {"joints": own.joints, "forces": own.forces, "states": own.states}.items():
        others = [name for name in results.names(kind) if name not in names]
        if others:
            said = f"'{results.path}' has {kind} that its scene does not have: {', '.join(others)}"
            raise InputError(Problem(said, hint="elements from Python are not in the scene: go on in Python"))


def require_another(output: str, source: Path, what: str) -> None:
    """Raises InputError where new results would replace those that they come from."""
    if os.path.realpath(output) == os.path.realpath(source):
        problem = Problem(f"'{output}' is the results file {what}", Place("--output"), "choose another name")
        raise InputError(problem)
