"""What an earlier reading of a document found: where nothing that a value follows from has changed it is taken again.

A value follows from its node, from the parameters that its texts name, and from the names of the scene's items. Of two
readings with other values in them (`mbproj.scene.text.changes`) the nodes beside the changes are the same objects.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple, TypeAlias

from mbproj.errors import Place, Problem
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode

Path: TypeAlias = "tuple[str | int, ...]"
#: Parameters by name, and the names of the items of each block.
Names: TypeAlias = Mapping[str, object]
Items: TypeAlias = Mapping[str, Collection[str]]
#: What may be the name of a parameter.
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class _Entry(NamedTuple):
    """A value that was read without a problem; what it was read from; the notes on it; the words in its texts that are
    names of parameters."""

    field: Any
    node: Node
    path: Path
    value: Any
    notes: tuple[Problem, ...]
    words: frozenset[str] = frozenset()


class ReadingCache:
    """The values of one reading, taken down by `keep`; `again` gives them to readings after it."""

    def __init__(self) -> None:
        self._names: Names = {}
        self._items: Items | None = None
        self._values: dict[tuple[int, int], _Entry] = {}
        self._words: dict[int, frozenset[str]] = {}
        self._changed_for: Names | None = None
        self._changed: frozenset[str] | None = None
        self.places: Mapping[Path, Place] = {}

    @property
    def is_full(self) -> bool:
        """Whether a reading was taken down from its beginning to its end."""
        return self._items is not None

    def close(self, names: Names, items: Items, places: Mapping[Path, Place]) -> None:
        """The reading that was taken down has come to its end without a problem."""
        self._names, self._items, self.places = names, items, places
        self._values = {key: each._replace(words=self._words_of(each.node)) for key, each in self._values.items()}

    def keep(self, field: Any, node: Node, path: Path, value: Any, notes: list[Problem]) -> None:
        """Takes down a value."""
        self._values[id(node), id(field)] = _Entry(field, node, path, value, tuple(notes))

    def again(self, field: Any, node: Node, path: Path, names: Names, items: Items) -> _Entry | None:
        """The value of a node, where it must be what it was, for a reading with these parameters and items."""
        entry = self._values.get((id(node), id(field)))
        if entry is None or entry.path != path:
            return None
        if self._changed_for is not names:
            self._changed_for, self._changed = names, self._changed_in(names, items)
        return entry if self._changed is not None and self._changed.isdisjoint(entry.words) else None

    def _changed_in(self, names: Names, items: Items) -> frozenset[str] | None:
        """The parameters that have other values in a reading; None where it has other names."""
        if items != self._items or names.keys() != self._names.keys():
            return None
        return frozenset(name for name, value in names.items() if value != self._names[name])

    def _words_of(self, node: Node) -> frozenset[str]:
        """The words in the texts of a node that are names of parameters."""
        found = self._words.get(id(node))
        if found is None:
            if isinstance(node, ScalarNode):
                found = frozenset(WORD.findall(node.text)) & self._names.keys()
            else:
                inner = node.values.values() if isinstance(node, MappingNode) else node.items
                found = frozenset().union(*map(self._words_of, inner))
            self._words[id(node)] = found
        return found
