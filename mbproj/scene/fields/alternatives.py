"""Values that may be written in several ways: told apart by their shape, or by one of their keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Generic

from mbproj.dataclass import dataclass
from mbproj.scene.fields.choices import NameChoice
from mbproj.scene.fields.containers import Record, read_keys, report_unknown_key
from mbproj.scene.fields.fields import Field, Schema, T_co
from mbproj.scene.fields.reading import Reading, either, label
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, as_mapping


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
