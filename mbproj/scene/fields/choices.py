"""Fields of one of several: a name among those of a registry or of the scene, or one of several ways to write a value.

The ways are told apart by their shape, or by one of their keys."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from itertools import chain
from typing import Any, ClassVar, Generic

from mbproj.dataclass import dataclass
from mbproj.errors import choose_from
from mbproj.scene.fields.containers import Record, read_keys, report_unknown_key
from mbproj.scene.fields.fields import Field, Schema, T_co
from mbproj.scene.fields.reading import Reading, either, label
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, as_mapping, describe


@dataclass(frozen=True)
class Alternatives(Field[T_co], Generic[T_co]):
    """Several ways to write one value: the first that fits the node's shape reads it."""

    ways: tuple[Field[T_co], ...]

    @property
    def expects(self) -> str:
        return either(way.expects for way in self.ways)

    def takes(self, node: Node) -> bool:
        return any(way.takes(node) for way in self.ways)

    def fits(self, node: Node) -> bool:
        return any(way.fits(node) for way in self.ways)

    def read(self, node: Node, path: KeyPath, reading: Reading) -> T_co | None:
        for way in self.ways:
            if way.fits(node):
                return way.read(node, path, reading)
        taking = [way for way in self.ways if way.takes(node)]
        if len(taking) == 1:
            return taking[0].read(node, path, reading)
        records = [way for way in taking if isinstance(way, Record)]
        if not records or not isinstance(node, MappingNode) or not node.values:
            self.reject(node, path, reading)
            return None
        known = dict.fromkeys(key for record in records for key in record.keys)
        for key, place in node.keys.items():
            report_unknown_key(key, place, known, label(path), reading)
        return None

    def schema(self) -> Schema:
        return {"description": self.expects, "anyOf": [way.schema() for way in self.ways]}


@dataclass(frozen=True)
class Variants(Field[T_co], Generic[T_co]):
    """A record whose `key` says which of `variants` it is. Where the key is wrong, those other keys are still read for
    their problems that have one meaning in all variants."""

    key: str
    tag: NameChoice
    variants: Mapping[str, Record[T_co]]
    node_type: ClassVar[type] = MappingNode

    @property
    def expects(self) -> str:
        return "a mapping"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> T_co | None:
        mapping = as_mapping(node)
        if mapping is None:
            self.reject(node, path, reading)
            return None
        tag = mapping.values.get(self.key, ScalarNode("", mapping.place))
        name = tag.text if isinstance(tag, ScalarNode) else ""
        if name in self.variants:
            return self.variants[name].read(mapping, path, reading)
        if self.key in mapping.keys:
            self.tag.read(tag, (*path, self.key), reading)
        else:
            reading.report(f"missing key '{self.key}'", mapping.place, f"add it: {self.tag.expects}")
        dict(read_keys(self._common(), mapping, path, reading))  # only to report their problems
        return None

    def schema(self) -> Schema:
        return {
            "type": "object",
            "properties": {self.key: self.tag.schema()},
            "required": [self.key],
            "allOf": [
                {"if": {"properties": {self.key: {"const": name}}, "required": [self.key]}, "then": variant.schema()}
                for name, variant in self.variants.items()
            ],
        }

    def _common(self) -> Mapping[str, Field[Any]]:
        variants = self.variants.values()
        every = {key: field for variant in variants for key, field in variant.keys.items()}
        return {
            key: field
            for key, field in every.items()
            if all(variant.keys.get(key, field) is field for variant in variants)
        }


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
