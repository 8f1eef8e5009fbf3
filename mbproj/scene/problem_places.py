"""The places of problems that are found after the reading, by code that does not know the file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from mbproj.errors import InputError, Problem
from mbproj.scene.records import KeyPath, Scene

#: The key that a problem is placed at where it has neither a place nor a key.
METHOD: KeyPath = ("simulation", "projection", "method")


def placed(problem: Problem, scene: Scene) -> Problem:
    """The problem with its place in the scene, found by its key."""
    return problem if problem.place else replace(problem, place=scene.place(*(problem.key or METHOD)))


@contextmanager
def placed_in(scene: Scene) -> Iterator[None]:
    """Give problems that are raised in this block their places in the scene."""
    try:
        yield
    except InputError as error:
        raise InputError([placed(problem, scene) for problem in error.problems]) from error
