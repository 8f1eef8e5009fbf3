"""The run behind results: the results themselves, its scene, and whether it can be repeated."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from mbproj.base.errors import InputError, Place, Problem
from mbproj.equations.assembly.compiled import compile_system
from mbproj.results import record
from mbproj.results.reader import open_results
from mbproj.scene.scene import Scene, read_scene_text


@contextmanager
def opened(results: record.Results | str | Path) -> Iterator[record.Results]:
    """Yield results; open their file where a path is given."""
    if isinstance(results, record.Results):
        yield results
        return
    with open_results(results) as opened_results:
        yield opened_results


def stored_scene(results: record.Results) -> Scene:
    """The scene of a run. Messages name its file, or else the results. Raises InputError where it is damaged."""
    name = str(results.scene_path or results.path)
    scene = read_scene_text(results.scene_text, name, results.overrides)
    _require_all(scene, results)
    return replace(scene, path=results.scene_path, settings=results.settings)


def require_whole(results: record.Results) -> None:
    """Raises InputError where a Python function acted on the run, because the file does not contain the function."""
    if "controller_period" in results.attributes:
        message = f"'{results.path}': a function in Python acted on the run, and is not in the file"
        raise InputError(Problem(message, hint="run it again in Python, with controller=f"))


def _require_all(scene: Scene, results: record.Results) -> None:
    """Raises InputError where the run had joints, forces or states that its scene does not have."""
    known = compile_system(scene).names
    for kind, names in {"joints": known.joints, "forces": known.forces, "states": known.states}.items():
        others = [name for name in results.names(kind) if name not in names]
        if others:
            said = f"'{results.path}' has {kind} that its scene does not have: {', '.join(others)}"
            raise InputError(Problem(said, hint="elements from Python are not in the scene: go on in Python"))


def require_another(output: str, source: Path, what: str) -> None:
    """Raises InputError where new results would replace the results that they come from."""
    if os.path.realpath(output) == os.path.realpath(source):
        problem = Problem(f"'{output}' is the results file {what}", Place("--output"), "choose another name")
        raise InputError(problem)
