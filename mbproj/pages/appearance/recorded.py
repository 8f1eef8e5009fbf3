"""The scene and the motion in a results file, and the scene in a file of modes."""

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
    """Read the scene of a run again. Raises InputError where its bodies are not those of the results."""
    return _read(results.scene_text, results.scene_path, results.overrides, results.names("bodies"), results.path)


def scene_of_modes(path: Path, bodies: Sequence[str]) -> tuple[Scene, Mapping[str, TriangleMesh]]:
    """The scene in the file of modes at `path`, and its meshes. Raises InputError where its bodies are not `bodies`."""
    recorded = scene_in(path)
    return _read(recorded.text, recorded.path, recorded.overrides, bodies, path), recorded.meshes


def _read(text: str, stood: Path | None, overrides: Mapping[str, str], bodies: Sequence[str], path: Path) -> Scene:
    scene = read_scene_text(text, str(stood or path), overrides)
    if tuple(body.name for body in scene.bodies) != tuple(bodies):
        message = f"the bodies of '{path}' are not those of the scene in it"
        raise InputError(Problem(message, hint="repeat the run: the file is damaged, or was put together by hand"))
    return scene


def motion_of(results: Results) -> PoseHistory:
    """The motion of all bodies. Raises InputError where at no sample all poses are finite."""
    motion = PoseHistory(results.time, results["bodies/position"], results["bodies/orientation"])
    if not len(motion.finite):
        message = f"'{results.path}' has no sample to show"
        raise InputError(Problem(message, hint=f"its status: {results.status}"))
    return motion
