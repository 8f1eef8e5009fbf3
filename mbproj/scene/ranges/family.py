"""Reads the file of a study of many variants of a scene: the scene that it names, and the units of the varied
values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mbproj.errors import InputError, Problem
from mbproj.scene.expressions.dimensions import symbol_of
from mbproj.scene.expressions.units import BARE, Dimension
from mbproj.scene.fields.containers import Record
from mbproj.scene.fields.reading import Reading, in_text_order
from mbproj.scene.read import Scene, SceneText
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import MappingNode, ScalarNode, describe
from mbproj.scene.text.source import read_text


def read_mapping(path: Path, what: str, begins: str) -> tuple[str, MappingNode, Reading]:
    """The text of the file, its mapping, and a new reading for it. Raises InputError where it is no mapping: `what` is
    the kind of file, as "a sweep", and `begins` its usual first line."""
    text = read_text(path)
    root, problems = compose(text, str(path))
    if not isinstance(root, MappingNode):
        raise InputError(Problem(f"{what} is a mapping of keys, found {describe(root)}", root.place, begins))
    return text, root, Reading(places={(): root.place}, problems=list(problems))


def scene_named(path: Path, root: MappingNode, reading: Reading, record: Record[Any]) -> tuple[SceneText, Scene]:
    """The scene that the file's key `scene` names: its text, taken apart, and the scene without changes. Raises
    InputError where there is no such scene, with the other faults that `record` finds, or where the scene is wrong."""
    node = root.values.get("scene")
    if not isinstance(node, ScalarNode) or not node.text:
        record.read(root, (), reading)
        raise InputError(in_text_order(reading.problems))
    where = path.parent / node.text
    try:
        text = SceneText(read_text(where), str(where), where)
    except InputError as error:
        problems = [_at(problem, str(where), node) for problem in error.problems]
        raise InputError(problems) from error
    return text, text.scene()


def _at(problem: Problem, scene: str, node: ScalarNode) -> Problem:
    """The problem; one of the scene as a whole is placed at the key that names the scene."""
    if problem.place is None or problem.place.line is not None:
        return problem
    return replace(problem, message=f"scene '{scene}': {problem.message}", place=node.place)


def column_of(path: str) -> str:
    """The name in tables of a quantity that varies: a parameter's name, or the path of another value."""
    return path.removeprefix("parameters.")


def with_unit(name: str, unit: str) -> str:
    """The heading of a column: the name, with its unit in brackets."""
    return f"{name} ({unit})" if unit else name


def units_of(given: Mapping[str, Dimension | None], scene: SceneText) -> dict[str, str]:
    """The SI units of the quantities that vary, by path: as the scene has them, or from the dimensions of the values
    `given`. "" is none."""
    known = {".".join(map(str, path)): unit for path, unit in scene.units().items()}
    units = {}
    for path, dimension in given.items():
        own = symbol_of(dimension) if dimension is not None and dimension != BARE else ""
        units[path] = known.get(path) or known.get(f"parameters.{path}") or own
    return units
