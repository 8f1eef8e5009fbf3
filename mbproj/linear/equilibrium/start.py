"""The initial state of a run: the assembled start, or the equilibrium that the scene asks for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.base.registry import EQUILIBRIUM
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, assemble, moved_by
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.recorded import Block, Observer
from mbproj.equations.samples import Sample, stack
from mbproj.linear.equilibrium.find import Equilibrium
from mbproj.model.compile.mechanism import Guess, initial_guess
from mbproj.model.system import System
from mbproj.results.layout import COUNTERS
from mbproj.results.output_files import SCENE, check_rewritable, write_text
from mbproj.scene.changes import Changes, text_with_changes
from mbproj.scene.records import Body
from mbproj.scene.scene import Scene, read_scene_text
from mbproj.scene.text.document import read_text


def assembled_start(scene: Scene, system: System) -> State:
    """Return the assembled start of the scene, from which an equilibrium is sought."""
    return assemble(system, initial_guess(scene, system))


def start_state(scene: Scene, system: System) -> State:
    """Return the initial state of runs of the scene. Raises NoEquilibrium where the scene asks for one and there is
    none."""
    state = assembled_start(scene, system)
    if scene.settings.start != EQUILIBRIUM:
        return state
    from mbproj.linear.equilibrium.find import equilibrium

    return equilibrium(system, state, state.t).state


def beside(scene: Scene, system: System, guess: Guess) -> State:
    """Return the consistent start nearest to a guess. Conditions on joints at the scene's own start apply only
    there."""
    return consistent(system, guess) if scene.settings.start == EQUILIBRIUM else assemble(system, guess)


def consistent(system: System, guess: Guess) -> State:
    """Return the consistent state nearest to a guess, without the scene's conditions on its own start."""
    from mbproj.equations.rank.row_space import NO_CONDITIONS

    return assemble(system, replace(guess, start=NO_CONDITIONS, speed=NO_CONDITIONS))


# --- An equilibrium as the one sample of a results file ---------------------------------------------------------------


def observed(rest: Equilibrium) -> Block:
    """Return the content of a results file with this one sample."""
    system, state, reference = rest.whole, rest.state, rest.reference
    none = {path.removeprefix("diagnostics/"): 0 for path in COUNTERS}
    rows, frictions = reference.system.joints.size, len(system.names.frictions)
    multipliers = np.delete(reference.multipliers, np.arange(rows - len(reference.held), rows))
    work = np.zeros(2 + frictions)
    sample = Sample(state, rest.acceleration, multipliers, 0.0, work, none)
    force = rest.friction_force[None]
    samples = replace(stack([sample]), rub=(lambda: (force, np.zeros_like(force))) if frictions else None)
    return Observer(system, state).at(samples)


# --- Writes an equilibrium into its scene file ------------------------------------------------------------------------
# The joints' coordinates at the start. The other text stays as it was.
# A scene gives points and axes at the pose of its bodies. So that pose stays, and the joints' coordinates give the
# displacement from it.


HINT = "begin runs there with 'start: equilibrium' in its simulation block, or with run --start equilibrium"


def write_pose(scene: Scene, rest: Equilibrium) -> Path:
    """Write the pose into the scene's file; comments stay. Raises InputError where the scene is no file, parameters
    were changed, or the joints' coordinates do not determine the poses."""
    path = check_rewritable(scene.path)
    place = Place(str(path))
    if scene.overrides:
        raise InputError(Problem("--set has changed parameters, which the file does not have", place, "write them in"))
    try:
        text = text_with_changes(scene.text, _changes(scene, rest))
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
