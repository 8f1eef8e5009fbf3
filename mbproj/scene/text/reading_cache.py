"""A cache of the values of an earlier reading of a document: a value is used again where nothing has changed that it
depends on.

A value depends on its node, on the parameters that its texts name, and on the names of the scene's items. Two documents
that differ by changes (`mbproj.scene.changes`) share the objects of all other nodes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple, TypeAlias

from mbproj.base.cases import Cases
from mbproj.base.errors import Place, Problem
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode

Path: TypeAlias = "tuple[str | int, ...]"
#: Parameters by name, and the names of the items of each block.
Names: TypeAlias = Mapping[str, object]
Items: TypeAlias = Mapping[str, Collection[str]]
#: The pattern of names of parameters.
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class _StoredValue(NamedTuple):
    """A value that was read without a problem, with the field, the node and the path that it was read by. `notes` are
    those on it, `words` the names of parameters in its texts."""

    field: Any
    node: Node
    path: Path
    value: Any
    notes: tuple[Problem, ...]
    words: frozenset[str] = frozenset()


class ReadingCache:
    """The values of one reading, stored by `keep`; `again` returns them to later readings."""

    def __init__(self) -> None:
        self._names: Names = {}
        self._items: Items | None = None
        self._values: dict[tuple[int, int], _StoredValue] = {}
        self._words: dict[int, frozenset[str]] = {}
        self._changed_for: Names | None = None
        self._changed: frozenset[str] | None = None
        self.places: Mapping[Path, Place] = {}

    @property
    def is_full(self) -> bool:
        """Whether the cache has all values of a reading without a problem."""
        return self._items is not None

    def close(self, names: Names, items: Items, places: Mapping[Path, Place]) -> None:
        """Mark the stored reading as complete: it has ended without a problem."""
        self._names, self._items, self.places = names, items, places
        self._values = {key: each._replace(words=self._words_of(each.node)) for key, each in self._values.items()}

    def keep(self, field: Any, node: Node, path: Path, value: Any, notes: list[Problem]) -> None:
        """Store a value that was read without a problem."""
        self._values[id(node), id(field)] = _StoredValue(field, node, path, value, tuple(notes))

    def again(self, field: Any, node: Node, path: Path, names: Names, items: Items) -> _StoredValue | None:
        """The stored value of a node for a reading with these parameters and items; None where it may have changed."""
        entry = self._values.get((id(node), id(field)))
        if entry is None or entry.path != path:
            return None
        if self._changed_for is not names:
            self._changed_for, self._changed = names, self._changed_in(names, items)
        return entry if self._changed is not None and self._changed.isdisjoint(entry.words) else None

    def _changed_in(self, names: Names, items: Items) -> frozenset[str] | None:
        """The parameters whose values differ from the stored reading; None where other names exist than there."""
        if items != self._items or names.keys() != self._names.keys():
            return None
        return frozenset(name for name, value in names.items() if _differ(value, self._names[name]))

    def _words_of(self, node: Node) -> frozenset[str]:
        """The names of parameters that occur in the texts of a node."""
        words = self._words.get(id(node))
        if words is None:
            if isinstance(node, ScalarNode):
                words = frozenset(WORD.findall(node.text)) & self._names.keys()
            else:
                inner = node.values.values() if isinstance(node, MappingNode) else node.items
                words = frozenset().union(*map(self._words_of, inner))
            self._words[id(node)] = words
        return words


def _differ(value: Any, before: Any) -> bool:
    """Whether a parameter has another value; one of several cases has."""
    if value is before:
        return False
    number, other = (getattr(each, "number", None) for each in (value, before))
    return isinstance(number, Cases) or value != before or not same_bits(number, other)


def same_bits(value: Any, other: Any) -> bool:
    """Whether two values are equal, and 0 of the same sign: atan2(-0.0, -1) is not atan2(0.0, -1)."""
    same: bool = value == other
    return same and (not isinstance(value, float) or math.copysign(1.0, value) == math.copysign(1.0, other))
