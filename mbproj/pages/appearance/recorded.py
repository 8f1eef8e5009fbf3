"""The scene and the motion that a results file holds, and the scene of a file of modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from mbproj.errors import InputError, Problem
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.results import Results
from mbproj.results.linear.parts import scene_in
from mbproj.scene import read_scene_text
from mbproj.scene.meshes import TriangleMesh
from mbproj.scene.records import Scene


def scene_of(results: Results) -> Scene:
    """The scene of a run, read again. Raises InputError where its bodies are not those of the results."""
    return _read(results.scene_text, results.scene_path, results.overrides, results.names("bodies"), results.path)


def scene_of_modes(path: Path, bodies: Sequence[str]) -> tuple[Scene, Mapping[str, TriangleMesh]]:
    """The scene of the file of modes at `path`, whose shapes are of these bodies, and their meshes."""
    found = scene_in(path)
    return _read(found.text, found.path, found.overrides, bodies, path), found.meshes


def _read(text: str, stood: Path | None, overrides: Mapping[str, str], bodies: Sequence[str], path: Path) -> Scene:
    scene = read_scene_text(text, str(stood or path), overrides)
    if tuple(body.name for body in scene.bodies) != tuple(bodies):
        message = f"the bodies of '{path}' are not those of the scene in it"
        raise InputError(Problem(message, hint="repeat the run: the file is damaged, or was put together by hand"))
    return scene


def motion_of(results: Results) -> PoseHistory:
    """The motion of all bodies. Raises InputError where no sample has them all somewhere."""
    motion = PoseHistory(results.time, results["bodies/position"], results["bodies/orientation"])
    if not len(motion.finite):
        message = f"'{results.path}' has no sample to show"
        raise InputError(Problem(message, hint=f"its status: {results.status}"))
    return motion
