"""Fields with keys: records and named items."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from typing import Any, ClassVar, Generic, NamedTuple

from mbproj.dataclass import dataclass
from mbproj.errors import Place, did_you_mean
from mbproj.scene.fields.fields import Field, Schema, T_co
from mbproj.scene.fields.reading import Reading, Unfit, either, label
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, as_mapping

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

    def complaints(self, values: Mapping[str, Any], given: Container[str]) -> Iterable[Complaint]:
        """The complaints about `values`, those that were read without a problem; `given` are the keys in the text."""
        for key in self.keys:
            if key not in values:
                return ()
        for key in self.besides:
            if key in given and key not in values:
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
        own = mapping_schema(self.what, empty=not (self.required or needed))
        own |= {"properties": {key: field.schema() for key, field in self.keys.items()}}
        if self.required:
            own["required"] = list(self.required)
        if self.choices:
            own["allOf"] = [group.schema() for group in self.choices]
        return own

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
        given = [key for key in group.keys if key in mapping.keys]
        for key in given[1:]:
            reading.report(f"'{given[0]}' and '{key}' cannot both be given", mapping.values[key].place, group.hint)
        if group.needed and not given:
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
