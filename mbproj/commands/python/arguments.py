"""The forms in which a caller gives a scene (a `Scene`, a path, a text of several lines, a mapping) and numbers."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import wraps
from operator import index
from pathlib import Path
from typing import Any, ParamSpec, SupportsFloat, TypeAlias, TypeVar

from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.base.settings import settings_taken
from mbproj.commands.options import RunSettings
from mbproj.scene.fields.quantities import Number, given_number
from mbproj.scene.scene import Scene, read_scene, read_scene_text
from mbproj.scene.settings import with_options

SceneLike: TypeAlias = "Scene | str | Path | Mapping[str, object]"
#: A number in SI units, or text with a unit: "1 ms".
Quantity: TypeAlias = "SupportsFloat | str"
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
#: The pattern of options of the command line in messages, which a caller of functions knows as arguments.
_OPTION = re.compile(r"--([a-z][a-z-]*)")
#: The names of arguments by those of earlier versions.
EARLIER = {"repetitions": "repeat", "processes": "jobs", "tell": "progress", "from_equilibrium": "start"}
#: Options whose argument has another name.
_RENAMED = {"from": "low", "to": "high", "limit": "limits", "set": "parameters"}


def scene_of(scene: SceneLike, parameters: Mapping[str, object], options: Mapping[str, object]) -> Scene:
    """Return the scene with other parameters (or values by their paths) and other settings, named as in `read_scene`.

    A text has line ends, a path has none. Raises InputError where the scene is wrong, TypeError where `scene` has no
    form of a scene.
    """
    if isinstance(scene, Scene):
        return with_options(scene.with_(parameters) if parameters else scene, options)
    if isinstance(scene, Mapping) or (isinstance(scene, str) and "\n" in scene):
        return read_scene_text(scene, "scene", parameters, options)
    if isinstance(scene, (str, Path)):
        return read_scene(scene, parameters, options)
    raise TypeError(f"a scene is a Scene, a path, a text or a mapping, found {type(scene).__name__}")


@contextmanager
def by_arguments() -> Iterator[None]:
    """Name arguments in the problems that the block raises, not options: `step`, not `--step`."""
    try:
        yield
    except InputError as error:
        raise InputError([_by_argument(problem) for problem in error.problems]) from None


def _by_argument(problem: Problem) -> Problem:
    place = problem.place
    if place is not None and place.file.startswith("--set "):
        place = Place(f"parameters['{place.file.removeprefix('--set ')}']")
    elif place is not None and place.line is None:
        place = replace(place, file=_argument(place.file))
    hint = None if problem.hint is None else _argument(problem.hint)
    return replace(problem, message=_argument(problem.message), place=place, hint=hint)


def _argument(text: str) -> str:
    return _OPTION.sub(lambda match: _RENAMED.get(match[1], match[1].replace("-", "_")), text)


def amount(
    value: Quantity, argument: str, unit: str | None, *, above: float | None = None, least: float | None = None
) -> float:
    """The number of an argument in SI units. Raises InputError where it is not above `above`, or not at least
    `least`."""
    return given_number(value, f"--{argument}", Number(unit, above=above, minimum=least))


def amounts(values: Sequence[Quantity] | Quantity | None, argument: str, unit: str | None) -> tuple[float, ...] | None:
    """The positive numbers of an argument, given as a list, an array, one number, or a text such as "0.01,5 ms"; None
    stays None."""
    if values is None:
        return None
    if isinstance(values, str):
        parts: Sequence[Any] = values.split(",")
    else:
        parts = [*values] if isinstance(values, Iterable) else [values]
    return tuple(amount(value, argument, unit, above=0.0) for value in parts)


def time_of(value: Quantity | None, argument: str) -> float | None:
    """The positive time of an argument, in s; None stays None."""
    return None if value is None else amount(value, argument, "s", above=0.0)


def count_of(value: int, argument: str, *, least: int = 0) -> int:
    """The whole number of an argument, also NumPy's. Raises InputError where it is below `least`, TypeError where it is
    not whole."""
    if index(value) < least:
        raise InputError(Problem(f"it must be at least {least}, found {value}", Place(argument)))
    return index(value)


def names_of(names: str | Sequence[str]) -> tuple[str, ...]:
    """The names in a list of words, or in a text such as "gopm,gpopm"."""
    return tuple(part.strip() for part in names.split(",")) if isinstance(names, str) else tuple(map(str, names))


def refuse_earlier_names(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Decorate a command: names that its arguments had in earlier versions raise a TypeError with the current name."""

    @wraps(function)
    def called(*values: Arguments.args, **named: Arguments.kwargs) -> Result:
        for old in EARLIER.keys() & named.keys():
            raise TypeError(f"{function.__name__}() has no argument '{old}': its name is '{EARLIER[old]}'")
        return function(*values, **named)

    return called


# --- The settings that functions take, named as the options of `mbproj run` -------------------------------------------
# One typed list for all functions.


Function = TypeVar("Function", bound=Callable[..., Any])


def options_of(settings: Mapping[str, Any], function: str, *others: str) -> dict[str, object]:
    """The settings that are not None. Raises TypeError for one that the function does not take, with the most similar
    name; `others` are the function's own arguments."""
    known = [*settings_taken(function), *others]
    for name in settings:
        if name not in known:
            raise TypeError(f"{function}() has no argument '{name}'; {choose_from(name, known)}")
    return {name: value for name, value in settings.items() if value is not None}


def with_settings(function: Function) -> Function:
    """Give a function a signature that lists each setting, so that prompts complete them and `help` shows them."""
    signature = inspect.signature(function)
    named = [each for each in signature.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
    each = (
        inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=None,
            annotation=RunSettings.__annotations__[name].__forward_arg__,
        )
        for name in settings_taken(function.__name__)
    )
    function.__signature__ = signature.replace(parameters=[*named, *each])  # type: ignore[attr-defined]
    return function
