"""Where problems stand that are found after the reading, by code that knows no file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from mbproj.errors import InputError, Problem
from mbproj.scene.records import KeyPath, Scene

#: What a problem is about that says neither its place nor its key.
METHOD: KeyPath = ("simulation", "projection", "method")


def placed(problem: Problem, scene: Scene) -> Problem:
    """The problem at its place in the scene."""
    return problem if problem.place else replace(problem, place=scene.place(*(problem.key or METHOD)))


@contextmanager
def placed_in(scene: Scene) -> Iterator[None]:
    """Gives problems of the scene's run their places."""
    try:
        yield
    except InputError as error:
        raise InputError([placed(problem, scene) for problem in error.problems]) from error
