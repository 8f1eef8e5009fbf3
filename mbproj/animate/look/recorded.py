"""The scene and the motion that a results file holds."""

from __future__ import annotations

from mbproj.animate.look.motion import Motion
from mbproj.errors import InputError, Problem
from mbproj.results import Results
from mbproj.scene import read_scene_text
from mbproj.scene.records import Scene


def scene_of(results: Results) -> Scene:
    """The scene of a run, read again. Raises InputError where its bodies are not those of the results."""
    scene = read_scene_text(results.scene_text, str(results.scene_path or results.path), results.overrides)
    if tuple(body.name for body in scene.bodies) != results.names("bodies"):
        message = f"the bodies of '{results.path}' are not those of the scene in it"
        raise InputError(Problem(message, hint="repeat the run: the file is damaged, or was put together by hand"))
    return scene


def motion_of(results: Results) -> Motion:
    """The motion of all bodies. Raises InputError where no sample has them all somewhere."""
    motion = Motion(results.time, results["bodies/position"], results["bodies/orientation"])
    if not len(motion.finite):
        message = f"'{results.path}' has no sample to show"
        raise InputError(Problem(message, hint=f"its status: {results.status}"))
    return motion
