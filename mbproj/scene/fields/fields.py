"""Fields: small definitions, each of which reads one kind of value from a node of the scene. Each also says what it
expects, so that messages and the schema need nothing else."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar, Generic, TypeAlias, TypeVar

from mbproj.dataclass import dataclass
from mbproj.registry import load
from mbproj.scene.fields.reading import Reading, Unfit, label
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, ScalarNode, SequenceNode, describe

T_co = TypeVar("T_co", covariant=True)
#: A JSON Schema (draft 2020-12) as plain data.
#: The version of JSON Schema that scenes and reports have.
DIALECT = "https://json-schema.org/draft/2020-12/schema"
Schema: TypeAlias = dict[str, Any]


class Field(ABC, Generic[T_co]):
    """One kind of value. `takes` tests the class of a node, `fits` its shape as well; `Alternatives` choose by them."""

    #: The class of the nodes that this field reads.
    node_type: ClassVar[type] = ScalarNode
    #: Whether reading this field defines names that later fields may use.
    defines_names: ClassVar[bool] = False

    @property
    @abstractmethod
    def expects(self) -> str:
        """A text that says which value belongs here, as "a number"."""

    @abstractmethod
    def read(self, node: Node, path: KeyPath, reading: Reading) -> T_co | None:
        """The value of the node at `path`; None where it is wrong, which is reported."""

    @abstractmethod
    def schema(self) -> Schema:
        """The JSON Schema of the field, as far as it can say it. It accepts every value that `read` accepts."""

    def takes(self, node: Node) -> bool:
        return isinstance(node, self.node_type)

    def fits(self, node: Node) -> bool:
        return self.takes(node)

    def reject(self, node: Node, path: KeyPath, reading: Reading) -> None:
        """Report that the node is no value of this field."""
        reading.report(f"{label(path)} needs {self.expects}, found {describe(node)}", node.place)


@dataclass(frozen=True)
class Flag(Field[bool]):
    """true or false."""

    @property
    def expects(self) -> str:
        return "true or false"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> bool | None:
        if not isinstance(node, ScalarNode) or node.text not in ("true", "false"):
            self.reject(node, path, reading)
            return None
        return node.text == "true"

    def schema(self) -> Schema:
        return {"description": self.expects, "enum": [True, False, "true", "false"]}


@dataclass(frozen=True)
class Text(Field[str]):
    """Any text."""

    @property
    def expects(self) -> str:
        return "text"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> str | None:
        if not isinstance(node, ScalarNode):
            self.reject(node, path, reading)
            return None
        return node.text

    def schema(self) -> Schema:
        return {"description": self.expects, "type": ["string", "number", "boolean", "null"]}  # 2015 is a text here


@dataclass(frozen=True)
class List(Field[tuple[T_co, ...]]):
    """A list of exactly `length` items of one kind, or of one or more where that is None. `what` names several in
    messages, as "numbers"."""

    item: Field[T_co]
    length: int | None
    what: str = "numbers"
    node_type: ClassVar[type] = SequenceNode

    @property
    def expects(self) -> str:
        return f"{self.length or 'a list of'} {self.what}"

    def fits(self, node: Node) -> bool:
        return isinstance(node, SequenceNode) and self._long_enough(node) and self.item.fits(node.items[0])

    def _long_enough(self, node: SequenceNode) -> bool:
        return len(node.items) == self.length if self.length is not None else bool(node.items)

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[T_co, ...] | None:
        if not isinstance(node, SequenceNode):
            self.reject(node, path, reading)
            return None
        if not self._long_enough(node):
            reading.report(f"{label(path)} needs {self.expects}, found {len(node.items)}", node.place)
            return None
        values = [reading.read(self.item, item, (*path, index)) for index, item in enumerate(node.items)]
        whole = tuple(value for value in values if value is not None)
        return whole if len(whole) == len(node.items) else None

    def schema(self) -> Schema:
        items = {"type": "array", "items": self.item.schema(), "minItems": self.length or 1}
        most = {} if self.length is None else {"maxItems": self.length}
        return {"description": self.expects, **items, **most}


@dataclass(frozen=True)
class Converted(Field[T_co], Generic[T_co]):
    """The value of `field`, converted for the records by `convert`, which raises Unfit for impossible values."""

    field: Field[Any]
    convert: Callable[[Any], T_co]

    @property
    def expects(self) -> str:
        return self.field.expects

    def takes(self, node: Node) -> bool:
        return self.field.takes(node)

    def fits(self, node: Node) -> bool:
        return self.field.fits(node)

    def read(self, node: Node, path: KeyPath, reading: Reading) -> T_co | None:
        value = self.field.read(node, path, reading)
        if value is None:
            return None
        try:
            return self.convert(value)
        except Unfit as unfit:
            reading.report(f"{label(path)} {unfit.message}", node.place, unfit.hint)
            return None

    def schema(self) -> Schema:
        return self.field.schema()


@dataclass(frozen=True)
class Deferred(Field[T_co], Generic[T_co]):
    """The field that `where` names as "module:name", or that the function of this name makes of `given`. Its module is
    imported when a scene first has such a value: a scene imports only what it contains."""

    where: str
    given: tuple[Any, ...] = ()

    @cached_property
    def field(self) -> Field[T_co]:
        """The field itself."""
        imported: Any = load(self.where)
        whole: Field[T_co] = imported if isinstance(imported, Field) else imported(*self.given)
        return whole

    @property
    def expects(self) -> str:
        return self.field.expects

    def takes(self, node: Node) -> bool:
        return self.field.takes(node)

    def fits(self, node: Node) -> bool:
        return self.field.fits(node)

    def read(self, node: Node, path: KeyPath, reading: Reading) -> T_co | None:
        return self.field.read(node, path, reading)

    def schema(self) -> Schema:
        return self.field.schema()
