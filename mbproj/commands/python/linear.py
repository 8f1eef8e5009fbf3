"""`mbproj.equilibrium`, `modes`, `traces` and `linearize`: the commands on equilibria and linear models, in one call
each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import SupportsFloat, TypeAlias

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.base.registry import LINEARISED_AT, SCENE_START, STEADY
from mbproj.commands.python.arguments import (
    Quantity,
    SceneLike,
    amount,
    by_arguments,
    count_of,
    names_of,
    scene_of,
)
from mbproj.commands.python.run import run
from mbproj.equations.assembly.assemble import State
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.rank.row_space import NO_CONDITIONS
from mbproj.linear import modes as of_modes
from mbproj.linear.equilibrium import find
from mbproj.linear.equilibrium.balance import SteadyTurn
from mbproj.linear.equilibrium.find import Equilibrium
from mbproj.linear.equilibrium.find import equilibrium as rest_of
from mbproj.linear.equilibrium.start import assembled_start, start_state
from mbproj.linear.equilibrium.steady import refuse_unsteady, steady_turn
from mbproj.linear.modes import Modes, RootLocus, trace
from mbproj.linear.reference import LinearReference, reference_at
from mbproj.linear.state_space import LinearModel, linear_model
from mbproj.linear.states import state_at, stored_state
from mbproj.model.system import Conditions, System
from mbproj.results.reader import open_results
from mbproj.results.record import Results
from mbproj.scene.fields.quantities import Number, given_number
from mbproj.scene.scene import Scene, read_scene_text
from mbproj.scene.settings import placed_in
from mbproj.studies.inverse.given_motion import GivenMotion, from_csv, from_results
from mbproj.studies.inverse.loads import ActuatorLoads, loads_of_given, loads_of_results

_NOTHING: Mapping[str, object] = {}


def equilibrium(
    scene: SceneLike, *, at: Quantity = 0.0, steady: str | None = None, parameters: Mapping[str, object] = _NOTHING
) -> Equilibrium:
    """Finds where a scene rests, downhill from its start. Motions keep the value that they have at the time `at` in s.

    With `steady`, such as "A.angle=60rpm", it is a steady turn about a joint. `scene` and `parameters` are as in `run`.
    Raises InputError where the scene is wrong. Raises `mbproj.linear.equilibrium.solve.NoEquilibrium`, a
    SimulationError, where nothing balances the forces.
    """
    return equilibria(scene, at=at, steady=steady, starts=0, parameters=parameters)[0]


def equilibria(
    scene: SceneLike,
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
    scene: SceneLike,
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
    scene: SceneLike,
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
    scene: SceneLike,
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


# --- `mbproj.loads` ---------------------------------------------------------------------------------------------------
# The forces with which actuators make a mechanism follow a motion, in one call.


_ALIKE: Mapping[str, float] = {}
#: The first bytes of an HDF5 file.
HDF5 = b"\x89HDF\r\n\x1a\n"
#: The forms in which a motion may be given.
Motion: TypeAlias = "GivenMotion | Results | str | Path"


def loads(
    scene: SceneLike | Results,
    given: Motion | None = None,
    *,
    actuators: Sequence[str] = (),
    weights: Mapping[str, float] = _ALIKE,
    smooth: Mapping[str, float] = _ALIKE,
    parameters: Mapping[str, object] = _NOTHING,
) -> ActuatorLoads:
    """The forces of actuators along a motion: inverse dynamics.

    `scene` is as in `run`, or results, whose recorded motion is used. Without `given`, a scene is run. `given` is a CSV
    file, results, or a `GivenMotion` of joint coordinates and components of markers. `actuators` are joint coordinates,
    motions, forces of the scene, components of forces on bodies. By default they are the scene's motions, or the given
    coordinates.

    Where the actuators are more than the freedoms that they reach, Σ w p² is least with these `weights`, 1 each by
    default. `smooth` gives, by unit ("rad", "m"), the root mean square change that a spline may make to the given
    motion. Where a unit has none, it is estimated.

    Raises InputError where the motion leaves a freedom open or takes a force that no actuator has. Raises
    SimulationError where the joints do not close along it.
    """
    with by_arguments():
        return loads_of(scene, given, actuators=actuators, weights=weights, smooth=smooth, parameters=parameters)


def loads_of(
    scene: SceneLike | Results,
    motion: Motion | None,
    *,
    actuators: Sequence[str],
    weights: Mapping[str, float],
    smooth: Mapping[str, float],
    parameters: Mapping[str, object],
) -> ActuatorLoads:
    """The loads as `loads` returns them, for the command: problems name its options."""
    if isinstance(scene, Results) or is_results(scene):
        if motion is not None or parameters:
            message = "results have their motion and their parameters"
            raise InputError(Problem(message, Place("--given"), "give the scene, or leave both out"))
        results = scene if isinstance(scene, Results) else open_results(Path(str(scene)))
        return loads_of_results(_stored(results), results, actuators, weights)
    what = scene_of(scene, parameters, {})
    if motion is None:
        return loads_of_results(what, run(what), actuators, weights)
    with placed_in(what):
        return loads_of_given(what, _motion(what, motion), actuators, weights, smooth)


def _motion(scene: Scene, motion: Motion) -> GivenMotion:
    system = compile_system(scene)
    if isinstance(motion, GivenMotion):
        return motion
    if isinstance(motion, Results):
        return from_results(system, motion)
    if is_results(motion):
        with open_results(Path(motion)) as opened:
            return from_results(system, opened)
    return from_csv(system, Path(motion))


def is_results(path: object) -> bool:
    """Whether `path` is the path of an HDF5 file."""
    if not isinstance(path, (str, Path)) or "\n" in str(path):
        return False
    try:
        with Path(path).open("rb") as file:
            return file.read(len(HDF5)) == HDF5
    except OSError:
        return False


def _stored(results: Results) -> Scene:
    """The scene of a run. Raises InputError where its bodies are not those of the results."""
    return read_scene_text(results.scene_text, str(results.scene_path or results.path), results.overrides)


# --- The state at which a mechanism is linearised, as --at, --from and --steady name it -------------------------------


def reference_of(
    scene: Scene, system: System, where: SupportsFloat | str, results: str | Path | None, steady: str | None
) -> LinearReference:
    """The motion that the options name. Raises InputError, at the option, where there is none."""
    if (steady is not None) != (where == STEADY):
        hint = "give both: --at steady --steady A.angle=60rpm"
        raise InputError(Problem("one of --at steady and --steady lacks the other", Place("--steady"), hint))
    if where in LINEARISED_AT and results is not None:
        raise InputError(Problem("it needs a time", Place("--from"), "give one of its samples: --at TIME"))
    if where == SCENE_START:
        return reference_at(system, start_state(scene, system), SCENE_START)
    if where in LINEARISED_AT:
        return _balanced(scene, system, steady)
    time = _time(where)
    at = where if isinstance(where, str) else f"{time:g} s"
    if results is None:
        return reference_at(system, state_at(scene, system, time), at)
    with placed_at(Place("--from")), open_results(results) as opened:
        return reference_at(system, stored_state(system, opened, time), at)


def _balanced(scene: Scene, system: System, steady: str | None) -> LinearReference:
    """The motion at the equilibrium, or in the steady turn."""
    start = assembled_start(scene, system)
    turning, held = steady_of(system, start, steady)
    rest = rest_of(system, start, 0.0, turning, held)
    if turning is not None:
        refuse_unsteady(rest, turning, held)
    return rest.reference


def steady_of(system: System, start: State, text: str | None) -> tuple[SteadyTurn | None, Conditions]:
    """The steady turn that NAME=RATE names, and the coordinates held in it; None without a text. Raises InputError at
    the option."""
    if text is None:
        return None, NO_CONDITIONS
    name, equals, rate = text.partition("=")
    if not equals or not name.strip() or not rate.strip():
        raise InputError(Problem(f"'{text}' is not NAME=RATE", Place("--steady"), "e.g. --steady A.angle=60rpm"))
    number = given_number(rate.strip(), f"--steady {name.strip()}", Number("rad/s"))
    if number == 0.0:
        raise InputError(Problem("a rate of 0 is no turn", Place("--steady"), "leave it out for an equilibrium"))
    with placed_at(Place("--steady")):
        return steady_turn(system, start, name.strip(), number)


def _time(where: SupportsFloat | str) -> float:
    try:
        return given_number(where, "--at", Number("s", minimum=0.0))
    except InputError as error:
        if any(letter.isdigit() for letter in str(where)):
            raise
        hint = f"give {', '.join(LINEARISED_AT)} or a time, 0.5 s say"
        raise InputError(Problem(f"unknown place '{where}'", Place("--at"), hint)) from error
