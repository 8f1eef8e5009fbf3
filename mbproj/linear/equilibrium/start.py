"""Writes an equilibrium into its scene file: the joints' coordinates at the start. The other text stays as it was.

A scene gives points and axes at the pose of its bodies. So that pose stays, and the joints' coordinates give the
displacement from it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.dynamics.assembly.assemble import State, assemble, moved_by
from mbproj.errors import InputError, Place, Problem, placed_at
from mbproj.linear.equilibrium.find import Equilibrium
from mbproj.model import initial_guess
from mbproj.output_files import SCENE, check_rewritable, write_text
from mbproj.scene import read_scene_text
from mbproj.scene.read import Scene
from mbproj.scene.records import Body
from mbproj.scene.text.rewrite import Changes, with_changes
from mbproj.scene.text.source import read_text
from mbproj.thresholds import THRESHOLDS

HINT = "begin runs there with 'start: equilibrium' in its simulation block, or with run --start equilibrium"


def write_pose(scene: Scene, rest: Equilibrium) -> Path:
    """Write the pose into the scene's file; comments stay. Raises InputError where the scene is no file, parameters
    were changed, or the joints' coordinates do not determine the poses."""
    path = check_rewritable(scene.path)
    place = Place(str(path))
    if scene.overrides:
        raise InputError(Problem("--set has changed parameters, which the file does not have", place, "write them in"))
    try:
        text = with_changes(scene.text, _changes(scene, rest))
        state = _start(text, scene)
    except (ValueError, InputError) as error:
        raise InputError(Problem("the pose cannot be written in place", place, HINT)) from error
    if max(moved_by(state.q, rest.state.q)) > THRESHOLDS.same_written or np.abs(state.v).max(initial=0.0) > 0.0:
        said = "the joints' coordinates do not say where all bodies are, or bodies have velocities"
        raise InputError(Problem(f"the pose cannot be written: {said}", place, HINT))
    if read_text(path) != scene.text:
        raise InputError(Problem("has changed since it was read", place, "find the equilibrium again"))
    mark = "\ufeff" if path.read_bytes().startswith(b"\xef\xbb\xbf") else ""
    with placed_at(place):
        return write_text(path, mark + text, SCENE, force=True, hint="write by hand")


def _start(text: str, scene: Scene) -> State:
    read = read_scene_text(text, str(scene.path))
    system = compile_system(read)
    return assemble(system, initial_guess(read, system))


def _changes(scene: Scene, rest: Equilibrium) -> Changes:
    """Return the changes of the text: the joints' coordinates, and no speeds. Motions determine the start of their
    coordinates."""
    system = rest.reference.system
    driven = system.motions.joint_coordinate.tolist()
    joints: dict[str, dict[str, str | None]] = {joint.name: {"speed": None} for joint in scene.joints if joint.speed}
    values = rest.reference.motion.expected.tolist()
    for index, (name, value) in enumerate(zip(system.names.coordinates, values, strict=True)):
        joint, _, coordinate = name.rpartition(".")
        if index not in driven:
            joints.setdefault(joint, {})[coordinate] = repr(value)
    bodies = {body.name: _without_velocity(body) for body in scene.bodies if _moves(body)}
    return {"joints": joints, **({"bodies": bodies} if bodies else {})}


def _moves(body: Body) -> bool:
    return any((*body.velocity, *body.angular_velocity))


def _without_velocity(body: Body) -> Changes:
    return {name: None for name in ("velocity", "angular_velocity") if any(getattr(body, name))}
