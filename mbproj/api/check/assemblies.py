"""`mbproj.branches`: all assemblies of a scene, in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mbproj.api.arguments import Given, by_arguments, scene_of
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.assembly.assemblies import Assemblies, assemblies, conditions, freedom_left
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.linear.equilibrium.started import assembled_start
from mbproj.model import System, initial_guess
from mbproj.model.system import Conditions
from mbproj.scene.fields.option_numbers import given_number
from mbproj.scene.fields.quantities import Number
from mbproj.scene.read import Scene
from mbproj.scene.settings import placed_in

_NOTHING: Mapping[str, object] = {}
#: The most coordinates that a message names.
NAMED = 8


def branches(
    scene: Given,
    *,
    hold: Sequence[str] = (),
    starts: int | None = None,
    parameters: Mapping[str, object] = _NOTHING,
) -> Assemblies:
    """Finds all assemblies of a scene: the poses that satisfy its joints, its motions at the start, and the held
    coordinates.

    `hold` names joint coordinates to hold: "A.angle=30deg", or "A.angle" at its value at the start. `starts` is the
    number of random poses from which assemblies are searched. `scene` and `parameters` are as in `run`. Raises
    InputError where the scene is wrong or degrees of freedom are left.
    """
    with by_arguments():
        what = scene_of(scene, parameters, {})
        system, state, held = ready(what, [hold] if isinstance(hold, str) else hold)
        return assemblies(system.at_positions, state, held, starts)


def ready(scene: Scene, hold: Sequence[str]) -> tuple[System, State, Conditions]:
    """Compile and assemble a scene, and return also the held coordinates. Raises InputError where degrees of freedom
    are left."""
    with placed_in(scene):
        system = compile_system(scene)
        state = assembled_start(scene, system)
    return system, state, _held_coordinates(scene, system, state, hold)


def _held_coordinates(scene: Scene, system: System, state: State, hold: Sequence[str]) -> Conditions:
    """The coordinates that the scene's joints fix at the start, and those of `hold`. Raises InputError where degrees of
    freedom are left."""
    names, units = list(system.names.coordinates), system.names.coordinate_units
    start = initial_guess(scene, system).start
    wanted: dict[int, float | None] = dict(zip(start.index.tolist(), start.value.tolist(), strict=True))
    for text in hold:
        name, equals, value = (part.strip() for part in text.partition("="))
        if name not in names:
            raise InputError(Problem(f"there is no coordinate '{name}'", Place("--hold"), choose_from(name, names)))
        index = names.index(name)
        wanted[index] = given_number(value, f"--hold {name}", Number(units[index])) if equals else None
    made = conditions(system, state, iter(wanted.items()))
    left = freedom_left(system.at_positions, state, made)
    if left:
        count = f"{left} degrees of freedom are" if left > 1 else "1 degree of freedom is"
        free = [name for index, name in enumerate(names) if index not in wanted]
        able = f"hold {left} of the coordinates {', '.join(free[:NAMED])}" if free else "drive them by 'motions'"
        raise InputError(Problem(f"{count} left: assemblies cannot be counted", Place("--hold"), able))
    return made
