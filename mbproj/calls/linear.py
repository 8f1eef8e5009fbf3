"""`mbproj.equilibrium`, `mbproj.modes` and `mbproj.linearize`: the commands of these names, in one call each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mbproj.calls.given import Given, by_arguments, scene_of
from mbproj.errors import InputError, Place, Problem
from mbproj.linear import modes as of_modes
from mbproj.linear.equilibrium import find
from mbproj.linear.equilibrium.find import Equilibrium
from mbproj.linear.equilibrium.started import assembled_start, start_state
from mbproj.linear.modes import Modes
from mbproj.linear.reference import Reference, reference_at
from mbproj.linear.state_space.model import LinearModel, linear_model
from mbproj.linear.states import state_at
from mbproj.model import compile_system
from mbproj.scene.problem_places import placed_in
from mbproj.scene.records import Scene

_NOTHING: Mapping[str, object] = {}
START, REST = "start", "equilibrium"


def equilibrium(scene: Given, *, at: float = 0.0, parameters: Mapping[str, object] = _NOTHING) -> Equilibrium:
    """Where a scene rests, downhill from its start; motions are held where they are at the time `at` in s.

    `scene` and `parameters` are as in `run`. Raises InputError where the scene is wrong, and
    `mbproj.linear.equilibrium.solve.NoEquilibrium`, a SimulationError, where nothing balances the forces.
    """
    with by_arguments():
        what = scene_of(scene, parameters, {})
        system = compile_system(what)
        with placed_in(what):
            return find.equilibrium(system, assembled_start(what, system), float(at))


def modes(
    scene: Given, *, at: float | str = START, count: int | None = None, parameters: Mapping[str, object] = _NOTHING
) -> Modes:
    """The modes of a scene, the slowest `count` of them: frequencies, damping and shapes of small motions.

    `at` says where: "start", "equilibrium", or a time in s of a run. `scene` and `parameters` are as in `run`.
    """
    with by_arguments():
        if count is not None and count < 1:
            raise InputError(Problem(f"it must be at least 1, found {count}", Place("count")))
        what = scene_of(scene, parameters, {})
        with placed_in(what):
            return of_modes.modes(_reference(what, at), count)


def linearize(
    scene: Given,
    inputs: Sequence[str],
    outputs: Sequence[str],
    *,
    at: float | str = START,
    parameters: Mapping[str, object] = _NOTHING,
) -> LinearModel:
    """The linear model x' = A x + B u, y = C x + D u of a scene, from `inputs` to `outputs`, named as in the command.

    `at` says where, as in `modes`. Raises InputError for a name that is no input or output.
    """
    with by_arguments():
        what = scene_of(scene, parameters, {})
        with placed_in(what):
            return linear_model(_reference(what, at), _names(inputs), _names(outputs))


def _names(given: Sequence[str]) -> tuple[str, ...]:
    return (given,) if isinstance(given, str) else tuple(given)


def _reference(scene: Scene, at: float | str) -> Reference:
    """The motion to linearise about. Raises InputError for a word that is no place."""
    system = compile_system(scene)
    if at == START:
        return reference_at(system, start_state(scene, system), START)
    if at == REST:
        return find.equilibrium(system, assembled_start(scene, system)).reference
    if isinstance(at, str):
        raise InputError(Problem(f"unknown place '{at}'", Place("at"), f"give '{START}', '{REST}' or a time in s"))
    return reference_at(system, state_at(scene, system, float(at)), f"{float(at):g} s")
