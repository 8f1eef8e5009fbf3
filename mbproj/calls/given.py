"""What a caller gives as a scene: a `Scene`, the path of a file, a text of several lines, or a mapping."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

from mbproj.errors import InputError, Place, Problem
from mbproj.scene.read import read_scene, read_scene_text
from mbproj.scene.records import Scene
from mbproj.scene.settings import with_options

Given: TypeAlias = "Scene | str | Path | Mapping[str, object]"
#: Options of the command line in a message, which a caller knows as arguments.
_OPTION = re.compile(r"--([a-z][a-z-]*)")


def scene_of(given: Given, parameters: Mapping[str, object], options: Mapping[str, object]) -> Scene:
    """The scene with other parameters (or values by their paths) and other settings, named as in `read_scene`.

    A text is told from a path by its end of line. Raises InputError where the scene is wrong, TypeError where `given`
    is nothing that a scene could be.
    """
    if isinstance(given, Scene):
        return with_options(given.with_(parameters) if parameters else given, options)
    if isinstance(given, Mapping) or (isinstance(given, str) and "\n" in given):
        return read_scene_text(given, "scene", parameters, options)
    if isinstance(given, (str, Path)):
        return read_scene(given, parameters, options)
    raise TypeError(f"a scene is a Scene, a path, a text or a mapping, found {type(given).__name__}")


@contextmanager
def by_arguments() -> Iterator[None]:
    """Problems name the arguments of a function where they would name options: `step`, not `--step`."""
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
    return _OPTION.sub(lambda found: found[1].replace("-", "_"), text)
