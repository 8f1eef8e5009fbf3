"""The forms in which a caller gives a scene (a `Scene`, a path, a text of several lines, a mapping) and numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from operator import index
from pathlib import Path
from typing import Any, SupportsFloat, TypeAlias

from mbproj.base.errors import InputError, Place, Problem
from mbproj.scene.fields.quantities import Number, given_number
from mbproj.scene.scene import Scene, read_scene, read_scene_text
from mbproj.scene.settings import with_options

SceneLike: TypeAlias = "Scene | str | Path | Mapping[str, object]"
#: A number in SI units, or text with a unit: "1 ms".
Quantity: TypeAlias = "SupportsFloat | str"
#: The pattern of options of the command line in messages, which a caller of functions knows as arguments.
_OPTION = re.compile(r"--([a-z][a-z-]*)")
#: Options whose argument has another name.
_RENAMED = {"from": "low", "to": "high", "limit": "limits", "set": "parameters"}


def scene_of(scene: SceneLike, parameters: Mapping[str, object], options: Mapping[str, object]) -> Scene:
    """Return the scene with other parameters (or values by their paths) and other settings, named as in `read_scene`.

    A text has line ends, a path has none. Raises InputError where the scene is wrong, TypeError where `scene` has no
    form of a scene, or `parameters` is no mapping.
    """
    if not isinstance(parameters, Mapping):
        raise TypeError(f"parameters are a mapping of names and values, found {type(parameters).__name__}")
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
    """The names in a list of words, or in a text such as "gopm,gpopm". Raises TypeError where it is neither."""
    if not isinstance(names, Iterable):
        raise TypeError(f"names are a text or a list of texts, found {type(names).__name__}")
    return tuple(part.strip() for part in names.split(",")) if isinstance(names, str) else tuple(map(str, names))
