"""`mbproj.equilibrium`, `modes`, `traces` and `linearize`: the commands on equilibria and linear models, in one call
each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from mbproj.api.arguments import Given, Quantity, amount, by_arguments, count_of, names_of, scene_of
from mbproj.api.places import reference_of, steady_of
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.errors import InputError, Place, Problem
from mbproj.linear import modes as of_modes
from mbproj.linear.equilibrium import find
from mbproj.linear.equilibrium.find import Equilibrium
from mbproj.linear.equilibrium.started import assembled_start
from mbproj.linear.equilibrium.steady import refuse_unsteady
from mbproj.linear.modes import Modes
from mbproj.linear.root_loci import RootLocus, trace
from mbproj.linear.state_space.model import LinearModel, linear_model
from mbproj.registry import SCENE_START
from mbproj.scene.read import Scene
from mbproj.scene.settings import placed_in

_NOTHING: Mapping[str, object] = {}


def equilibrium(
    scene: Given, *, at: Quantity = 0.0, steady: str | None = None, parameters: Mapping[str, object] = _NOTHING
) -> Equilibrium:
    """Finds where a scene rests, downhill from its start. Motions keep the value that they have at the time `at` in s.

    With `steady`, such as "A.angle=60rpm", it is a steady turn about a joint. `scene` and `parameters` are as in `run`.
    Raises InputError where the scene is wrong. Raises `mbproj.linear.equilibrium.solve.NoEquilibrium`, a
    SimulationError, where nothing balances the forces.
    """
    return equilibria(scene, at=at, steady=steady, starts=0, parameters=parameters)[0]


def equilibria(
    scene: Given,
    *,
    starts: int = 20,
    at: Quantity = 0.0,
    steady: str | None = None,
    parameters: Mapping[str, object] = _NOTHING,
) -> tuple[Equilibrium, ...]:
    """Finds the equilibrium, and others from as many other `starts`. The other arguments are as in `equilibrium`."""
    with by_arguments():
        what, time, others = (
            scene_of(scene, parameters, {}),
            amount(at, "at", "s", least=0.0),
            count_of(starts, "starts"),
        )
        with placed_in(what):
            system = compile_system(what)
            start = assembled_start(what, system)
            turning, held = steady_of(system, start, steady)
            rest = find.equilibrium(system, start, time, turning, held)
            if turning is not None:
                refuse_unsteady(rest, turning, held)
            return (rest, *find.other_equilibria(system, rest, others, turning, held))


def modes(
    scene: Given,
    *,
    at: Quantity = SCENE_START,
    count: int | None = None,
    steady: str | None = None,
    results: str | Path | None = None,
    parameters: Mapping[str, object] = _NOTHING,
) -> Modes:
    """The slowest `count` modes of a scene: frequencies, damping and shapes of small motions.

    `at` tells where: "start", "equilibrium", "steady" (with `steady`, such as "A.angle=60rpm"), or a time in s, of a
    run or of the file `results`. `scene` and `parameters` are as in `run`.
    """
    with by_arguments():
        few = None if count is None else count_of(count, "count", least=1)
        return _modes(scene_of(scene, parameters, {}), at, results, steady, few)


def traces(
    scene: Given,
    name: str,
    values: Sequence[Quantity],
    *,
    at: Quantity = SCENE_START,
    count: int | None = None,
    steady: str | None = None,
    parameters: Mapping[str, object] = _NOTHING,
) -> RootLocus:
    """The modes over `values` of the parameter `name`, as `modes --vary` traces them. The other arguments are as in
    `modes`."""
    with by_arguments():
        few = None if count is None else count_of(count, "count", least=1)
        numbers = [amount(value, "values", None) for value in values]
        if not numbers:
            raise InputError(Problem("there are none", Place("values"), "give at least one"))

        def modes_at(value: float) -> Modes:
            return _modes(scene_of(scene, {**parameters, name: value}, {}), at, None, steady, few)

        return trace(name, numbers, modes_at)[0]


def linearize(
    scene: Given,
    inputs: str | Sequence[str],
    outputs: str | Sequence[str],
    *,
    at: Quantity = SCENE_START,
    steady: str | None = None,
    results: str | Path | None = None,
    parameters: Mapping[str, object] = _NOTHING,
) -> LinearModel:
    """The linear model x' = A x + B u, y = C x + D u of a scene, from `inputs` to `outputs`, named as in the command.

    `at`, `steady` and `results` tell where, as in `modes`. Raises InputError for a name that is no input or output.
    """
    with by_arguments():
        what = scene_of(scene, parameters, {})
        with placed_in(what):
            reference = reference_of(what, compile_system(what), at, results, steady)
            return linear_model(reference, names_of(inputs), names_of(outputs))


def _modes(scene: Scene, at: Quantity, results: str | Path | None, steady: str | None, count: int | None) -> Modes:
    with placed_in(scene):
        return of_modes.modes(reference_of(scene, compile_system(scene), at, results, steady), count)
