"""Fields: small definitions, each of which reads one kind of value from a node of the scene. Each also says what it
expects, so that messages and the schema need nothing else.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping
from functools import cached_property
from itertools import chain
from typing import Any, ClassVar, Generic, NamedTuple, TypeAlias, TypeVar

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place, choose_from, did_you_mean
from mbproj.base.registry import load
from mbproj.scene.fields.reading import Reading, Unfit, either, label
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode, as_mapping, describe

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
    """The field that `where` names as "module:name", or that the function of this name makes of `arguments`. Its module
    is imported when a scene first has such a value: a scene imports only what it contains."""

    where: str
    arguments: tuple[Any, ...] = ()

    @cached_property
    def field(self) -> Field[T_co]:
        """The field itself."""
        imported: Any = load(self.where)
        whole: Field[T_co] = imported if isinstance(imported, Field) else imported(*self.arguments)
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


# --- Fields with keys -------------------------------------------------------------------------------------------------
# Records and named items.


#: The pattern of names of items: they have to be valid in names of files and datasets as well.
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")


class Complaint(NamedTuple):
    """A fault that a check finds at `path` within its record."""

    path: KeyPath
    message: str
    hint: str | None = None


@dataclass(frozen=True)
class Rule:
    """A rule on several values of a record. `find` gets the values of `keys` by position, where all are given and
    right, then those of `besides`. Of the latter, each that is not given is an empty mapping."""

    keys: tuple[str, ...]
    find: Callable[..., Iterable[Complaint]]
    besides: tuple[str, ...] = ()

    def complaints(self, values: Mapping[str, Any], written: Container[str]) -> Iterable[Complaint]:
        """The complaints about `values`, those that were read without a problem; `written` are the keys in the text."""
        for key in self.keys:
            if key not in values:
                return ()
        for key in self.besides:
            if key in written and key not in values:
                return ()
        return self.find(*(values[key] for key in self.keys), *(values.get(key, {}) for key in self.besides))


class OneOf(NamedTuple):
    """Keys that exclude each other: exactly one must be given where it is `needed`, else at most one."""

    keys: tuple[str, ...]
    needed: bool = False
    hint: str = "keep one of them"

    def schema(self) -> Schema:
        if self.needed:
            return {"oneOf": [{"required": [key]} for key in self.keys]}
        others = {key: dict.fromkeys(self.keys[at + 1 :], False) for at, key in enumerate(self.keys[:-1])}
        return {"dependentSchemas": {key: {"properties": excluded} for key, excluded in others.items()}}


@dataclass(frozen=True)
class Record(Field[T_co], Generic[T_co]):
    """A mapping of values by key, which are passed to `make` by name, and the item's own `name` as well where `named`.
    `make` may raise Unfit.

    `keys` are read in the order in which they stand here, whatever their order in the text. `choices` are groups of
    keys that exclude each other; `elsewhere` are keys that only other variants have.
    """

    what: str
    keys: Mapping[str, Field[Any]]
    make: Callable[..., T_co]
    required: tuple[str, ...] = ()
    checks: tuple[Rule, ...] = ()
    choices: tuple[OneOf, ...] = ()
    named: bool = False
    elsewhere: Container[str] = frozenset()
    node_type: ClassVar[type] = MappingNode

    @property
    def expects(self) -> str:
        return "{" + ", ".join(self.keys) + "}"

    def fits(self, node: Node) -> bool:
        return isinstance(node, MappingNode) and not self.keys.keys().isdisjoint(node.values)

    def read(self, node: Node, path: KeyPath, reading: Reading) -> T_co | None:
        mapping = as_mapping(node)
        if mapping is None:
            self.reject(node, path, reading)
            return None
        before = len(reading.problems)
        self._report_keys(mapping, reading)
        values = dict(read_keys(self.keys, mapping, path, reading))
        for check in self.checks:
            for complaint in check.complaints(values, mapping.values):
                where = (*path, *complaint.path)
                reading.report(complaint.message, reading.places[where], complaint.hint)
        if len(reading.problems) > before or len(values) < len(mapping.values):
            return None
        name = {"name": path[-1]} if self.named else {}
        try:
            return self.make(**name, **values)
        except Unfit as unfit:
            reading.report(f"{label(path)} {unfit.message}", mapping.place, unfit.hint)
            return None

    def schema(self) -> Schema:
        needed = [key for group in self.choices if group.needed for key in group.keys]
        schema = mapping_schema(self.what, empty=not (self.required or needed))
        schema |= {"properties": {key: field.schema() for key, field in self.keys.items()}}
        if self.required:
            schema["required"] = list(self.required)
        if self.choices:
            schema["allOf"] = [group.schema() for group in self.choices]
        return schema

    def _report_keys(self, mapping: MappingNode, reading: Reading) -> None:
        """Report the keys that are unknown and those that are missing."""
        for key, place in mapping.keys.items():
            if key in self.keys:
                continue
            if key in self.elsewhere:
                reading.report(f"{self.what} has no '{key}'", place, f"it takes {', '.join(self.keys)}")
            else:
                report_unknown_key(key, place, self.keys, self.what, reading)
        for key in self.required:
            if key not in mapping.keys:
                reading.report(f"missing key '{key}'", mapping.place, f"add it: {self.keys[key].expects}")
        for group in self.choices:
            self._report_choice(group, mapping, reading)

    def _report_choice(self, group: OneOf, mapping: MappingNode, reading: Reading) -> None:
        """Report keys of a group that exclude each other, or that none is given where one is needed."""
        present = [key for key in group.keys if key in mapping.keys]
        for key in present[1:]:
            reading.report(f"'{present[0]}' and '{key}' cannot both be given", mapping.values[key].place, group.hint)
        if group.needed and not present:
            able = [key for key in group.keys if not self._excluded(key, mapping)] or group.keys
            hint = f"add it: {self.keys[able[0]].expects}" if len(able) == 1 else "add one of them"
            reading.report(f"missing key {either(map(repr, able))}", mapping.place, hint)

    def _excluded(self, key: str, mapping: MappingNode) -> bool:
        """Whether another key that is given excludes this one."""
        return any(key in group.keys and not mapping.keys.keys().isdisjoint(group.keys) for group in self.choices)


def read_keys(
    fields: Mapping[str, Field[Any]], mapping: MappingNode, path: KeyPath, reading: Reading
) -> Iterator[tuple[str, Any]]:
    """Yield the key and the value of each field that is given and right."""
    for key, field in fields.items():
        node = mapping.values.get(key)
        if node is not None:
            value = reading.read(field, node, (*path, key))
            if value is not None:
                yield key, value


def report_unknown_key(key: str, place: Place, known: Iterable[str], what: str, reading: Reading) -> None:
    """Report an unknown key, with a hint on the key that was probably meant."""
    known = tuple(known)
    hint = "put a space after the ':'" if ":" in key else did_you_mean(key, known)
    if key.endswith("_dot") and "speed" in known:
        hint = "the rate at the start is 'speed'"
    reading.report(f"unknown key '{key}'", place, hint or f"{what} takes {', '.join(known)}")


def mapping_schema(description: str, empty: bool) -> Schema:
    """The schema of a mapping, without its keys. Where it may be `empty`, a key with no value counts as one."""
    kinds: Schema = {"type": ["object", "null", "string"], "maxLength": 0} if empty else {"type": "object"}
    return {"description": description, **kinds, "additionalProperties": False}


def names_schema(names: re.Pattern[str], reserved: Iterable[str], item: Schema) -> Schema:
    """The schema of a mapping of items of one kind under any of these names, except the reserved ones."""
    forbidden = {"propertyNames": {"not": {"enum": sorted(reserved)}}} if reserved else {}
    return {"patternProperties": {f"^(?:{names.pattern})$": item}, **forbidden}


@dataclass(frozen=True)
class Named(Field[Mapping[str, T_co]], Generic[T_co]):
    """Items of one kind by name; `what` names one in messages, as "body". Names in `reserved` have another meaning."""

    what: str
    item: Field[T_co]
    needed: bool = False
    reserved: frozenset[str] = frozenset()
    names: re.Pattern[str] = NAME
    rule: str = "letters, digits, _ and -, and does not begin with a digit or -"
    node_type: ClassVar[type] = MappingNode

    @property
    def expects(self) -> str:
        return f"a mapping {{name: {self.item.expects}}}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Mapping[str, T_co] | None:
        mapping = as_mapping(node)
        if mapping is None:
            self.reject(node, path, reading)
            return None
        if self.needed and not mapping.values:
            reading.report(f"{label(path)} is empty", mapping.place, f"a scene needs a {self.what}")
            return None
        for name, place in mapping.keys.items():
            self._report_name(name, place, reading)
        fields = dict.fromkeys(mapping.values, self.item)
        values = dict(read_keys(fields, mapping, path, reading))
        return values if len(values) == len(fields) else None

    def schema(self) -> Schema:
        return {
            **mapping_schema(self.expects, empty=not self.needed),
            **names_schema(self.names, self.reserved, self.item.schema()),
            **({"minProperties": 1} if self.needed else {}),
        }

    def _report_name(self, name: str, place: Place, reading: Reading) -> None:
        if name in self.reserved:
            reading.report(f"'{name}' is a reserved name", place, f"give the {self.what} another name")
        elif not self.names.fullmatch(name):
            article = "an" if self.what[0] in "aeiou" else "a"
            reading.report(f"'{name}' cannot name {article} {self.what}", place, f"a name has {self.rule}")


@dataclass(frozen=True)
class ByPath(Field[Mapping[str, T_co]], Generic[T_co]):
    """Items of one kind by any text, such as the path of a value of the scene. `meaning` says what stands for what, as
    in "path of a number: [low, high]". An empty mapping is a fault where `example` says what to give."""

    meaning: str
    item: Field[T_co]
    example: str = ""
    node_type: ClassVar[type] = MappingNode

    @property
    def expects(self) -> str:
        return f"a mapping {{{self.meaning}}}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Mapping[str, T_co] | None:
        mapping = as_mapping(node)
        if mapping is None:
            self.reject(node, path, reading)
            return None
        if self.example and not mapping.values:
            reading.report(f"{label(path)} is empty", mapping.place, self.example)
            return None
        reading.places |= {(*path, name): place for name, place in mapping.keys.items()}
        read = {name: self.item.read(value, (*path, name), reading) for name, value in mapping.values.items()}
        return None if None in read.values() else {name: item for name, item in read.items() if item is not None}

    def schema(self) -> Schema:
        return {"description": self.expects, "type": "object", "additionalProperties": self.item.schema()}


# --- Fields of one of several -----------------------------------------------------------------------------------------
# A name among those of a registry or of the scene, or one of several ways to write a value.
# The ways are told apart by their shape, or by one of their keys.


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
