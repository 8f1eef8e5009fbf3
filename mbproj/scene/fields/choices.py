"""Fields that are one name of several: a choice of the registries, or an item of the scene."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from itertools import chain

from mbproj.dataclass import dataclass
from mbproj.scene.fields.fields import Field, Schema
from mbproj.scene.fields.reading import Reading, either
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, ScalarNode, describe
from mbproj.scene.text.suggestions import choose_from


@dataclass(frozen=True)
class NameChoice(Field[str]):
    """One of the names that `names()` returns, called when needed, since some stand on disk. `what` says in messages
    what they name, as "integrator"."""

    what: str
    names: Callable[[], Iterable[str]]

    @property
    def expects(self) -> str:
        return either(self.names())

    def read(self, node: Node, path: KeyPath, reading: Reading) -> str | None:
        names = self.names()
        return _pick(self, node, path, reading, names if isinstance(names, Collection) else tuple(names))

    def schema(self) -> Schema:
        names = tuple(self.names())
        return {"description": self.what, "enum": [*names, *(int(name) for name in names if name.isdigit())]}


@dataclass(frozen=True)
class NameReference(Field[str]):
    """The name of an item of the top-level block `block`, or one of `besides`. `what` names such an item in
    messages."""

    what: str
    block: str
    besides: tuple[str, ...] = ()

    @property
    def expects(self) -> str:
        return f"the name of a {self.what}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> str | None:
        return _pick(self, node, path, reading, self.besides, reading.items.get(self.block, ()))

    def schema(self) -> Schema:
        return {"description": self.expects, "type": "string", "minLength": 1}


def _pick(
    field: NameChoice | NameReference, node: Node, path: KeyPath, reading: Reading, *names: Collection[str]
) -> str | None:
    """The node's text where it is among `names`; None where it is not, which is reported. The collections of names are
    joined for a message only, since there may be many."""
    if not isinstance(node, ScalarNode) or not node.text:
        field.reject(node, path, reading)
        return None
    if any(node.text in some for some in names):
        return node.text
    reading.report(f"unknown {field.what} {describe(node)}", node.place, choose_from(node.text, chain(*names)))
    return None
