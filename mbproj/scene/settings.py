"""The `Settings` of a scene: options of the command line replace the scene's, which replace defaults; their checks.

Code that does not know the file raises problems by their keys; `placed_in` gives them their places in the scene.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, replace
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.registry import AUTOMATIC, PROJECTIONS, integrator_choices, is_embedded
from mbproj.scene.blocks.simulation import LIST_OPTIONS, OPTIONS, SIMULATION
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath, ProjectionSettings, Scene, Settings
from mbproj.scene.sampling import too_many
from mbproj.scene.text.nodes import MappingNode, Node, from_value

#: Values by their path within the `simulation` block.
Values = Mapping[KeyPath, Any]

METHOD: KeyPath = ("projection", "method")
#: The options of every projection method that corrects the state.
CORRECTION_OPTIONS = (
    "tolerance",
    "test",
    "every",
    "threshold",
    "position",
    "velocity",
    "max_iterations",
    "fallback",
    "energy",
    "momentum",
)
#: The options that add rows for conserved quantities to the velocity projection.
ROWS = ("energy", "momentum")
#: The defaults of options that only some methods have.
DEFAULTS: Mapping[str, Any] = {"alpha": 1e7, "gains": (25.0, 25.0)}
#: The integrator of a scene that gives a tolerance, but no integrator.
BY_TOLERANCE = "dopri5"
#: How far output_step / step may be from a whole number, relative to it.
MULTIPLE = 1e-9


@dataclass(frozen=True)
class Merged:
    """The values of scene and command line together. `commanded` are the paths that the command line gave, `places` the
    places by path in the scene."""

    values: Values
    commanded: frozenset[KeyPath]
    places: Mapping[KeyPath, Place]

    def place(self, *paths: KeyPath) -> Place | None:
        """The place of the first of `paths` that the command line gave, or else of the first."""
        chosen = next((path for path in paths if path in self.commanded), paths[0])
        return self.places.get(("simulation", *chosen))


def read_options(options: Mapping[str, object], reading: Reading) -> dict[KeyPath, Any] | None:
    """The settings that the command line gives, by path, read by the fields of the scene's own keys. An option that is
    None is not given. The result is None where one is wrong, which is reported."""
    values: dict[str, Node] = {}
    projection: dict[str, Node] = {}
    for name, value in options.items():
        place = Place(option_name(name))
        if name not in OPTIONS:
            reading.report(f"unknown option '{name}'", place, choose_from(name, OPTIONS))
        elif value is not None:
            if name in LIST_OPTIONS and isinstance(value, str) and "," in value:
                value = value.split(",")
            (projection if len(OPTIONS[name]) > 1 else values)[str(OPTIONS[name][-1])] = from_value(value, place)
    if projection:
        values["projection"] = _mapping(projection)
    blocks = SIMULATION.read(_mapping(values), ("simulation",), reading)
    return None if blocks is None else flatten(blocks)


def option_name(name: str) -> str:
    """The option of the command line for a key of OPTIONS, as "--output-step"."""
    return "--" + name.replace("_", "-")


def _mapping(values: dict[str, Node]) -> MappingNode:
    return MappingNode(values, {key: node.place for key, node in values.items()}, Place("command line"))


def flatten(block: Mapping[str, Any]) -> dict[KeyPath, Any]:
    """The values of a `simulation` block as read, by their path within it."""
    inner = block.get("projection", {})
    flat: dict[KeyPath, Any] = {(key,): value for key, value in block.items() if key != "projection"}
    return flat | {("projection", key): value for key, value in inner.items()}


def merge(scene: Values, options: Values) -> Values:
    """The values of the scene, with options in their place. `step` and `tolerance` replace each other. Where an option
    changes the method, options of the scene's method that the new one does not have are dropped. A tolerance without an
    integrator gets one with error control."""
    kept = dict(scene)
    if ("step",) in options or ("tolerance",) in options:
        kept.pop(("step",), None)
        kept.pop(("tolerance",), None)
    method = options.get(METHOD)
    if method not in (None, scene.get(METHOD, ProjectionSettings.method)):
        kept = {path: value for path, value in kept.items() if path[0] != "projection" or takes(method, str(path[1]))}
    merged = {**kept, **options}
    if ("tolerance",) in merged:
        merged.setdefault(("integrator",), BY_TOLERANCE)
    return merged


def takes(method: str, option: str) -> bool:
    """Whether the projection method has this option."""
    entry = PROJECTIONS[method]
    return option == "method" or option in entry.options or (entry.corrects and option in CORRECTION_OPTIONS)


def check_settings(merged: Merged) -> Iterator[Problem]:
    """The problems of values that do not fit each other."""
    for check in _CHECKS:
        yield from check(merged)


def _tolerance_needs_an_estimate(merged: Merged) -> Iterator[Problem]:
    name = merged.values.get(("integrator",), Settings.integrator)
    if ("tolerance",) in merged.values and not is_embedded(name):
        able = ", ".join(other for other in integrator_choices() if is_embedded(other))
        place = merged.place(("tolerance",), ("integrator",))
        yield Problem(f"'{name}' has no error estimate, which 'tolerance' needs", place, f"these have one: {able}")


def _auto_needs_a_tolerance(merged: Merged) -> Iterator[Problem]:
    name = merged.values.get(("integrator",), Settings.integrator)
    if name == AUTOMATIC and ("step",) in merged.values:
        place = merged.place(("step",), ("integrator",))
        yield Problem(f"'{name}' chooses its steps by their error: it takes no 'step'", place, "give a 'tolerance'")


def _output_is_a_multiple(merged: Merged) -> Iterator[Problem]:
    step, output_step = merged.values.get(("step",)), merged.values.get(("output_step",))
    if step is None or output_step is None:
        return
    ratio = output_step / step
    if not (0.5 < ratio < 1e15 and abs(ratio - round(ratio)) <= MULTIPLE * ratio):
        place = merged.place(("output_step",), ("step",))
        yield Problem(
            f"'output_step' ({output_step:.10g} s) is not a whole multiple of 'step' ({step:.10g} s)",
            place,
            f"set 'output_step' to {max(round(min(ratio, 1e15)), 1) * step:.10g} s",
        )


def _method_takes_its_options(merged: Merged) -> Iterator[Problem]:
    method = merged.values.get(METHOD, ProjectionSettings.method)
    for path in merged.values:
        if path[0] == "projection" and not takes(method, str(path[1])):
            able = ", ".join(other for other in PROJECTIONS if takes(other, str(path[1])))
            yield Problem(
                f"projection method '{method}' has no '{path[1]}'", merged.place(path, METHOD), f"these have: {able}"
            )


def _rows_need_velocities(merged: Merged) -> Iterator[Problem]:
    for row in ROWS:
        path: KeyPath = ("projection", row)
        if merged.values.get(path) and merged.values.get(("projection", "velocity")) is False:
            place = merged.place(path, ("projection", "velocity"))
            yield Problem(f"'{row}' is a row of the velocity projection, which is off", place, "leave out 'velocity'")


def _steps_can_be_counted(merged: Merged) -> Iterator[Problem]:
    duration, step, output_step = (merged.values.get((name,)) for name in ("duration", "step", "output_step"))
    problem = too_many(Settings(duration=duration, step=step, output_step=output_step))
    if problem is not None:
        shorter = "output_step" if step is None else "step"
        yield replace(problem, place=merged.place((shorter,), ("duration",)))


_CHECKS: tuple[Callable[[Merged], Iterable[Problem]], ...] = (
    _tolerance_needs_an_estimate,
    _auto_needs_a_tolerance,
    _output_is_a_multiple,
    _steps_can_be_counted,
    _rows_need_velocities,
    _method_takes_its_options,
)


def settings_of(values: Values) -> Settings:
    """The settings of these values, with defaults for the others."""
    top = {str(path[0]): value for path, value in values.items() if len(path) == 1}
    inner = {str(path[1]): value for path, value in values.items() if len(path) == 2}
    method = inner.get("method", ProjectionSettings.method)
    own = {option: DEFAULTS[option] for option in PROJECTIONS[method].options}
    return Settings(**top, projection=ProjectionSettings(**{**own, **inner}))


def with_options(scene: Scene, options: Mapping[str, object]) -> Scene:
    """The scene with other settings, by the names in `OPTIONS`; None: not given. Raises InputError as `read_scene`."""
    reading = Reading()
    commanded = read_options(options, reading)
    merged = None
    if commanded:
        places = {**scene.places, **reading.places}
        merged = Merged(merge(values_of(scene), commanded), frozenset(commanded), places)
        reading.problems.extend(check_settings(merged))
    if reading.problems:
        raise InputError(reading.problems)
    return scene if merged is None else replace(scene, settings=settings_of(merged.values))


def values_of(scene: Scene) -> dict[KeyPath, Any]:
    """The settings of a scene, by path, that differ from the defaults or are given in its text."""
    values: dict[KeyPath, Any] = {}
    inner = scene.settings.projection
    for way, record, plain in (((), scene.settings, Settings()), (("projection",), inner, ProjectionSettings())):
        for each in fields(record):
            path, value = (*way, each.name), getattr(record, each.name)
            is_given = value != getattr(plain, each.name) or ("simulation", *path) in scene.places
            if value is not None and is_given and path != ("projection",):
                values[path] = value
    return values


def settings_to_run(scene: Scene, *, by_options: bool = True) -> Settings:
    """The settings of a scene, complete for a run. `by_options`: hints may name --duration, --step and --tolerance.

    Raises InputError where the duration is missing, or step and tolerance, which a kinematic scene does not need.
    """
    settings, place = scene.settings, scene.place("simulation")
    problems = []
    if settings.duration is None:
        hint = "add 'duration' to 'simulation'" + (", or --duration" if by_options else "")
        problems.append(Problem("the scene has no duration", place, hint))
    if settings.step is None and settings.tolerance is None and settings.kinematic is not True:
        hint = "add one of them to 'simulation'" + (", or --step or --tolerance" if by_options else "")
        problems.append(Problem("the scene has neither step nor tolerance", place, hint))
    if problems:
        raise InputError(problems)
    return settings


#: The key that a problem is placed at where it has neither a place nor a key.
UNPLACED: KeyPath = ("simulation", "projection", "method")


def placed(problem: Problem, scene: Scene) -> Problem:
    """The problem with its place in the scene, found by its key."""
    return problem if problem.place else replace(problem, place=scene.place(*(problem.key or UNPLACED)))


@contextmanager
def placed_in(scene: Scene) -> Iterator[None]:
    """Give problems that are raised in this block their places in the scene."""
    try:
        yield
    except InputError as error:
        raise InputError([placed(problem, scene) for problem in error.problems]) from error
