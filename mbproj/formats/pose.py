"""A file of joint coordinates: a YAML mapping of names and numbers, in rad and m."""

from __future__ import annotations

from pathlib import Path

from mbproj.errors import InputError, Problem
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import MappingNode, ScalarNode
from mbproj.scene.text.source import read_text


def read_pose(path: Path) -> dict[str, float]:
    """Coordinates by the name of the model's joint. Raises InputError at what is no number."""
    root, problems = compose(read_text(path), str(path))
    if not isinstance(root, MappingNode):
        raise InputError(Problem("a pose is a mapping of joints", root.place, "write lines as in 'hinge: 0.3'"))
    found: dict[str, float] = {}
    for name, node in root.values.items():
        text = node.text if isinstance(node, ScalarNode) else ""
        try:
            found[name] = float(text)
        except ValueError:
            problems.append(Problem(f"'{name}' needs a number", node.place, "give it in rad or m"))
    if problems:
        raise InputError(problems)
    return found
