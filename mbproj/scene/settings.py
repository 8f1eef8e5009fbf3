"""The `Settings` of a scene: options of the command line replace the scene's, which replace defaults; their checks.

Code that does not know the file raises problems by their keys; `placed_in` gives them their places in the scene.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.base.registry import AUTOMATIC, PROJECTIONS, integrator_choices, is_embedded
from mbproj.base.settings import SETTINGS, ProjectionSettings, Settings, option_name
from mbproj.scene.fields.reading import Reading
from mbproj.scene.grammar import SIMULATION
from mbproj.scene.records import KeyPath
from mbproj.scene.sampling import too_many
from mbproj.scene.text.nodes import MappingNode, Node, from_value

if TYPE_CHECKING:
    from mbproj.scene.scene import Scene

#: Values of settings by their names in `SETTINGS`.
Values = Mapping[str, Any]

#: The integrator of a scene that gives a tolerance, but no integrator.
BY_TOLERANCE = "dopri5"
#: How far output_step / step may be from a whole number, relative to it.
MULTIPLE = 1e-9


@dataclass(frozen=True)
class Merged:
    """The values of scene and command line together. `commanded` are the names that the command line gave, `places` the
    places by path in the scene."""

    values: Values
    commanded: Iterable[str]
    places: Mapping[KeyPath, Place]

    def place(self, *names: str) -> Place | None:
        """The place of the first of `names` that the command line gave, or else of the first."""
        return self.places.get(place_of(next((name for name in names if name in self.commanded), names[0])))

    def get(self, name: str) -> Any:
        """The value of a setting, or its default."""
        return self.values.get(name, SETTINGS[name].usual)


def place_of(name: str) -> tuple[str, ...]:
    """The path of a setting in a scene."""
    return ("simulation", *SETTINGS[name].path)


def read_options(options: Mapping[str, object], reading: Reading) -> dict[str, Any] | None:
    """The settings that the command line gives, read by the fields of the scene's own keys. An option that is None is
    not given. The result is None where one is wrong, which is reported."""
    values: dict[str, Node] = {}
    projection: dict[str, Node] = {}
    for name, value in options.items():
        place = Place(option_name(name))
        if name not in SETTINGS:
            reading.report(f"unknown option '{name}'", place, choose_from(name, SETTINGS))
        elif value is not None:
            entry = SETTINGS[name]
            if entry.kind.startswith("tuple") and isinstance(value, str) and "," in value:
                value = value.split(",")
            (projection if len(entry.path) > 1 else values)[entry.key] = from_value(value, place)
    if projection:
        values["projection"] = _mapping(projection)
    block = SIMULATION.read(_mapping(values), ("simulation",), reading)
    return None if block is None else by_name(block)


def _mapping(values: dict[str, Node]) -> MappingNode:
    return MappingNode(values, {key: node.place for key, node in values.items()}, Place("command line"))


def by_name(block: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a `simulation` block as read, by the names of their settings."""
    inner = block.get("projection", {})
    parts = ((entry, block if len(entry.path) == 1 else inner) for entry in SETTINGS.values())
    return {entry.name: part[entry.key] for entry, part in parts if entry.key in part}


def merge(scene: Values, options: Values) -> Values:
    """The values of the scene, with options in their place. `step` and `tolerance` replace each other. Where an option
    changes the method, options of the scene's method that the new one does not have are dropped. A tolerance without an
    integrator gets one with error control."""
    values = dict(scene)
    if "step" in options or "tolerance" in options:
        values.pop("step", None)
        values.pop("tolerance", None)
    method = options.get("projection")
    if method not in (None, scene.get("projection", SETTINGS["projection"].usual)):
        values = {name: value for name, value in values.items() if takes(method, name)}
    merged = {**values, **options}
    if "tolerance" in merged:
        merged.setdefault("integrator", BY_TOLERANCE)
    return merged


def takes(method: str, name: str) -> bool:
    """Whether a run with this projection method has this setting."""
    setting, entry = SETTINGS[name], PROJECTIONS[method]
    of_run = len(setting.path) == 1 or name == "projection"
    return of_run or setting.key in entry.options or (entry.corrects and setting.where_taken is None)


def check_settings(merged: Merged) -> Iterator[Problem]:
    """The problems of values that do not fit each other."""
    for check in _CHECKS:
        yield from check(merged)


def _tolerance_needs_an_estimate(merged: Merged) -> Iterator[Problem]:
    name = merged.get("integrator")
    if "tolerance" in merged.values and not is_embedded(name):
        able = ", ".join(other for other in integrator_choices() if is_embedded(other))
        place = merged.place("tolerance", "integrator")
        yield Problem(f"'{name}' has no error estimate, which 'tolerance' needs", place, f"these have one: {able}")


def _auto_needs_a_tolerance(merged: Merged) -> Iterator[Problem]:
    name = merged.get("integrator")
    if name == AUTOMATIC and "step" in merged.values:
        place = merged.place("step", "integrator")
        yield Problem(f"'{name}' chooses its steps by their error: it takes no 'step'", place, "give a 'tolerance'")


def _output_is_a_multiple(merged: Merged) -> Iterator[Problem]:
    step, output_step = merged.get("step"), merged.get("output_step")
    if step is None or output_step is None:
        return
    ratio = output_step / step
    if not (0.5 < ratio < 1e15 and abs(ratio - round(ratio)) <= MULTIPLE * ratio):
        yield Problem(
            f"'output_step' ({output_step:.10g} s) is not a whole multiple of 'step' ({step:.10g} s)",
            merged.place("output_step", "step"),
            f"set 'output_step' to {max(round(min(ratio, 1e15)), 1) * step:.10g} s",
        )


def _method_takes_its_options(merged: Merged) -> Iterator[Problem]:
    method = merged.get("projection")
    for name in merged.values:
        if not takes(method, name):
            key, able = SETTINGS[name].key, ", ".join(other for other in PROJECTIONS if takes(other, name))
            place = merged.place(name, "projection")
            yield Problem(f"projection method '{method}' has no '{key}'", place, f"these have: {able}")


def _rows_need_velocities(merged: Merged) -> Iterator[Problem]:
    for name in ("energy_row", "momentum_row"):
        if merged.get(name) and not merged.get("project_velocity"):
            said = f"'{SETTINGS[name].key}' is a row of the velocity projection, which is off"
            yield Problem(said, merged.place(name, "project_velocity"), "leave out 'velocity'")


def _steps_can_be_counted(merged: Merged) -> Iterator[Problem]:
    step = merged.get("step")
    problem = too_many(Settings(duration=merged.get("duration"), step=step, output_step=merged.get("output_step")))
    if problem is not None:
        yield replace(problem, place=merged.place("output_step" if step is None else "step", "duration"))


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
    method = values.get("projection", SETTINGS["projection"].usual)
    complete = {**{name: SETTINGS[name].where_taken for name in PROJECTIONS[method].options}, **values}
    top, inner = (
        {SETTINGS[name].key: value for name, value in complete.items() if len(SETTINGS[name].path) == length}
        for length in (1, 2)
    )
    return Settings(**top, projection=ProjectionSettings(**inner))


def with_options(scene: Scene, options: Mapping[str, object]) -> Scene:
    """The scene with other settings, by the names in `SETTINGS`; None: not given. Raises InputError as `read_scene`."""
    reading = Reading()
    commanded = read_options(options, reading)
    merged = None
    if commanded:
        merged = Merged(merge(values_of(scene), commanded), commanded, {**scene.places, **reading.places})
        reading.problems.extend(check_settings(merged))
    if reading.problems:
        raise InputError(reading.problems)
    return scene if merged is None else replace(scene, settings=settings_of(merged.values))


def values_of(scene: Scene) -> dict[str, Any]:
    """The settings of a scene that differ from the defaults or are given in its text."""
    values = {name: entry.of(scene.settings) for name, entry in SETTINGS.items()}
    return {
        name: value
        for name, value in values.items()
        if value is not None and (value != SETTINGS[name].usual or place_of(name) in scene.places)
    }


def settings_to_run(scene: Scene, *, by_options: bool = True) -> Settings:
    """The settings of a scene, complete for a run. `by_options`: hints may name --duration, --step and --tolerance.

    Raises InputError where the duration is missing, or step and tolerance. A kinematic run needs neither: where motions
    may leave no degree of freedom, `motion.formulations.choice` decides.
    """
    settings, place = scene.settings, scene.place("simulation")
    problems = []
    if settings.duration is None:
        hint = "add 'duration' to 'simulation'" + (", or --duration" if by_options else "")
        problems.append(Problem("the scene has no duration", place, hint))
    may_be_kinematic = settings.kinematic is True or (settings.kinematic is None and scene.motions)
    if settings.step is None and settings.tolerance is None and not may_be_kinematic:
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
