"""The forms in which a caller gives a scene (a `Scene`, a path, a text of several lines, a mapping) and numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import SupportsFloat, TypeAlias

from mbproj.base.errors import InputError, Place, Problem
from mbproj.scene.scene import Scene, read_scene, read_scene_text
from mbproj.scene.settings import with_options

SceneLike: TypeAlias = "Scene | str | Path | Mapping[str, object]"
#: A number in SI units, or text with a unit: "1 ms".
Quantity: TypeAlias = "SupportsFloat | str"
#: The pattern of options of the command line in messages, which a caller of functions knows as arguments.
_OPTION = re.compile(r"--([a-z][a-z-]*)")


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
def by_arguments(names: Mapping[str, str] = MappingProxyType({})) -> Iterator[None]:
    """Name arguments in the problems that the block raises, not options: `step`, not `--step`. `names` are those of the
    arguments by the options that have other ones."""
    names = {**names, "--set": "parameters"}
    try:
        yield
    except InputError as error:
        raise InputError([_by_argument(problem, names) for problem in error.problems]) from None


def _by_argument(problem: Problem, names: Mapping[str, str]) -> Problem:
    def named(text: str) -> str:
        return _OPTION.sub(lambda match: names.get(match[0], match[1].replace("-", "_")), text)

    place = problem.place
    if place is not None and place.file.startswith("--set "):
        place = Place(f"parameters['{place.file.removeprefix('--set ')}']")
    elif place is not None and place.line is None:
        place = replace(place, file=named(place.file))
    hint = None if problem.hint is None else named(problem.hint)
    return replace(problem, message=named(problem.message), place=place, hint=hint)
