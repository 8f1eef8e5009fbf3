"""`Scene.build`: a scene of parts, without a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from mbproj.errors import InputError, Place, Problem
from mbproj.scene.grammar import SCENE
from mbproj.scene.read import Scene, read_scene_text

#: The name in messages of a scene that was built.
NAME = "Scene.build"


def build(blocks: Mapping[str, Any]) -> Scene:
    """The scene that has these blocks; `None` is left out. Raises InputError, whose problems name the
    arguments by their paths, as 'bodies.rod.mass'."""
    given = {name: blocks[name] for name in SCENE.keys if blocks.get(name) is not None}
    try:
        return read_scene_text({"mbproj": 1, **given}, NAME)
    except InputError as error:
        raise InputError([_at_argument(problem) for problem in error.problems]) from None


def _at_argument(problem: Problem) -> Problem:
    """The problem with the item as its place: lines of a generated text mean nothing to the user."""
    place = problem.place
    if place is None or place.file != NAME or place.line is None:
        return problem
    item = (place.text or "").strip().partition(":")[0]
    return replace(problem, place=Place(f"{NAME}: {item}" if item else NAME))
