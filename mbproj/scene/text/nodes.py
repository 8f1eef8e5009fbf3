"""The scene file as nodes: text, sequences and mappings, each with its place. Nothing is a number yet."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from numbers import Real
from typing import Any, NamedTuple, TypeAlias

from mbproj.base.cases import Cases
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place


@dataclass(frozen=True)
class ScalarNode:
    """A piece of text. `column` (from 1) is where it begins in its line. It is None where the text differs from that of
    the file (several lines, escapes), or comes from the command line."""

    text: str
    place: Place
    column: int | None = None

    def place_at(self, offset: int) -> Place:
        """The place of the character number `offset` (from 0), or of the whole text where `column` is None."""
        if self.column is None:
            return self.place
        return Place(self.place.file, self.place.line, self.column + offset, self.place.text)


@dataclass(frozen=True)
class CasesNode(ScalarNode):
    """The numbers of several cases, which take the place of one number."""

    numbers: Any = None


@dataclass(frozen=True)
class SequenceNode:
    items: tuple[Node, ...]
    place: Place


@dataclass(frozen=True)
class MappingNode:
    """Values by key in the order of the text, and the place of each key. A mapping that is the value of a key has the
    place of that key, so that missing keys are reported there."""

    values: Mapping[str, Node]
    keys: Mapping[str, Place]
    place: Place


Node: TypeAlias = "ScalarNode | SequenceNode | MappingNode"


class WrittenKey(NamedTuple):
    """A key of a mapping as it was written, its place, and its value."""

    key: Node
    place: Place
    value: Node


def describe(node: Node) -> str:
    """A description of the node for messages: "'abc'", "nothing", "a list of 3", "a mapping"."""
    match node:
        case ScalarNode():
            shown = node.text if len(node.text) <= 40 else node.text[:37] + "..."
            return f"'{shown}'" if node.text else "nothing"
        case SequenceNode():
            return f"a list of {len(node.items)}"
        case MappingNode():
            return "a mapping"


def as_mapping(node: Node) -> MappingNode | None:
    """The node as a mapping; None where it is none. A key with nothing after it counts as an empty mapping, since its
    entries may be commented out."""
    if isinstance(node, ScalarNode) and not node.text:
        return MappingNode({}, {}, node.place)
    return node if isinstance(node, MappingNode) else None


def plain(value: object) -> object:
    """A scalar or an array of NumPy as a number, flag, text or list of Python; anything else unchanged."""
    listed = getattr(value, "tolist", None)
    return value if listed is None else listed()


def from_value(value: object, place: Place) -> Node:
    """The node of a value from the command line or a Python caller: text, a number, a flag, or a list or mapping of
    them, also of NumPy."""
    if isinstance(value, Cases):
        return CasesNode("the numbers of several cases", place, numbers=value)
    value = plain(value)
    if isinstance(value, Mapping):
        values = {str(key): from_value(inner, place) for key, inner in value.items()}
        return MappingNode(values, dict.fromkeys(values, place), place)
    if isinstance(value, (list, tuple)):
        return SequenceNode(tuple(from_value(item, place) for item in value), place)
    if value is None or isinstance(value, bool):
        return ScalarNode("null" if value is None else str(value).lower(), place)
    if isinstance(value, Real) and not isinstance(value, int):
        value = float(value)
    return ScalarNode(value if isinstance(value, str) else repr(value), place)


#: Text that needs no quotes in a list or mapping of YAML.
_PLAIN = re.compile(r"[^\s\[\]{},:#&*!|>'\"%@`?-][^\[\]{},:#\n]*|-?[\w.]+")


def flow(node: Node) -> str:
    """The node as one line of YAML, from which the same node is read; a scalar as its text."""
    return node.text if isinstance(node, ScalarNode) else _inner(node)


def mapping(values: Mapping[str, object]) -> MappingNode:
    """The mapping node of these values, each as `from_value` takes it."""
    node = from_value(values, Place(""))
    assert isinstance(node, MappingNode)
    return node


def document(root: MappingNode) -> str:
    """The YAML text of a document: its keys, and those of the mappings in it, have a line each."""
    lines = []
    for key, value in root.values.items():
        if isinstance(value, MappingNode) and value.values:
            lines.append(f"{_key(key)}:")
            lines += [f"  {_key(name)}: {_inner(inner)}" for name, inner in value.values.items()]
        else:
            lines.append(f"{_key(key)}: {_inner(value)}")
    return "\n".join(lines) + "\n"


def _key(key: object) -> str:
    return _inner(ScalarNode(str(key), Place("")))


def _inner(node: Node) -> str:
    match node:
        case ScalarNode():
            return node.text if _PLAIN.fullmatch(node.text) else json.dumps(node.text)
        case SequenceNode():
            return f"[{', '.join(map(_inner, node.items))}]"
        case MappingNode():
            return "{" + ", ".join(f"{_key(key)}: {_inner(value)}" for key, value in node.values.items()) + "}"
