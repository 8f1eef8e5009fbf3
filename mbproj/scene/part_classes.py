"""The classes of a scene's parts, made from the tables that read a scene: their names, and their arguments with
types.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from inspect import Parameter, Signature
from types import MappingProxyType
from typing import Any, ClassVar

from mbproj.base.errors import choose_from
from mbproj.scene.blocks.bodies import BODY
from mbproj.scene.blocks.curves import CURVE
from mbproj.scene.blocks.elements import ELEMENTS
from mbproj.scene.blocks.expectations import EXPECTATION
from mbproj.scene.blocks.forces import FORCE_RECORDS, OWN_RECORDS
from mbproj.scene.blocks.motions import MOTION
from mbproj.scene.fields.fields import Alternatives, Converted, Deferred, Field, Flag, List, NameChoice, Record, Text
from mbproj.scene.grammar import JOINT, MARKER, SIMULATION


class ScenePart(Mapping[str, Any]):
    """A mapping of the keys that were given. Raises TypeError for a key that it does not have, or lacks."""

    #: The name of the type in a scene; "" where it needs no type.
    type: ClassVar[str] = ""
    #: The keys, and those that must be given.
    keys_of_scene: ClassVar[tuple[str, ...]] = ()
    required: ClassVar[tuple[str, ...]] = ()
    __slots__ = ("_values",)

    def __init__(self, **values: Any) -> None:
        name = type(self).__name__
        for key in values:
            if key not in self.keys_of_scene:
                raise TypeError(f"{name}() has no argument '{key}'; {choose_from(key, self.keys_of_scene)}")
        for key in self.required:
            if values.get(key) is None:
                raise TypeError(f"{name}() lacks the argument '{key}'")
        present = {key: value for key, value in values.items() if value is not None}
        self._values = {"type": self.type, **present} if self.type else present

    def __getitem__(self, key: str) -> Any:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        arguments = ", ".join(
            f"{key}={value!r}" for key, value in self._values.items() if not (key == "type" and self.type)
        )
        return f"{type(self).__name__}({arguments})"


def signature_of(keys: Mapping[str, str], required: tuple[str, ...]) -> Signature:
    """The arguments of a class by their annotations, those that are required first."""
    ordered = sorted(keys, key=lambda key: key not in required)
    return Signature(
        [
            Parameter(
                key,
                Parameter.KEYWORD_ONLY,
                default=Parameter.empty if key in required else None,
                annotation=keys[key] if key in required else f"{keys[key]} | None",
            )
            for key in ordered
        ]
    )


#: The types of numbers and arrays for a scene, which include texts with units or expressions, and NumPy's types.
NUMBER, NUMBERS, MAPPING = "Quantity", "Vector", "Mapping[str, Any]"


def annotation_of(field: Field[Any]) -> str:
    """The type of a field's values, as `__init__.pyi` writes it."""
    if isinstance(field, Converted | Deferred):
        return annotation_of(field.field)
    if isinstance(field, Flag):
        return "bool"
    if isinstance(field, Text):
        return "str"
    if isinstance(field, NameChoice):
        return "str"
    if isinstance(field, List):
        return _several(annotation_of(field.item))
    if isinstance(field, Alternatives):
        return " | ".join(dict.fromkeys(part for way in field.ways for part in annotation_of(way).split(" | ")))
    return _by_schema(field.schema())


def _several(item: str) -> str:
    return NUMBERS if item == NUMBER else f"Sequence[{item}]"


def _by_schema(schema: Mapping[str, Any]) -> str:
    """The type of a field's values by its JSON Schema, for fields without a rule of their own."""
    if "anyOf" in schema:
        return " | ".join(dict.fromkeys(part for way in schema["anyOf"] for part in _by_schema(way).split(" | ")))
    if "enum" in schema:
        return "str"
    kinds = schema.get("type", "object")
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if "object" in kinds:
        return MAPPING
    if "array" in kinds:
        inner = _by_schema(schema["items"]) if isinstance(schema.get("items"), Mapping) else "Any"
        return _several(inner)
    return NUMBER if "number" in kinds else "str"


def _class_of(name: str, record: Record[Any], type_name: str = "") -> type[ScenePart]:
    """The class of the items that a record reads."""
    fields = {key: field for key, field in record.keys.items() if key != "type"}
    required = tuple(key for key in record.required if key != "type")
    lines = [f"{key}: {field.expects}{'' if key in required else ', optional'}" for key, field in fields.items()]
    groups = [
        f"{'one' if group.needed else 'at most one'} of {', '.join(group.keys)}"
        for group in record.choices
        if not set(group.keys) - set(fields)
    ]
    what = record.what[:1].upper() + record.what[1:]
    text = "\n".join([f"{what} of a scene. Arguments are its keys:\n", *lines, *groups])
    keys = {key: annotation_of(field) for key, field in fields.items()}
    body = {
        "__doc__": text,
        "__module__": "mbproj.scene.parts",
        "__slots__": (),
        "__signature__": signature_of(keys, required),
        "type": type_name,
        "keys_of_scene": tuple(fields),
        "required": required,
    }
    return type(name, (ScenePart,), body)


def _class_name(type_name: str) -> str:
    """`spring_damper` as a class: `SpringDamper`."""
    return "".join(word.capitalize() for word in type_name.split("_"))


def class_of_plugin(name: str) -> type[ScenePart] | None:
    """The class of a type of force that a plug-in has registered; None where there is none."""
    types = {_class_name(type_name): type_name for type_name in ELEMENTS.added}
    return _class_of(name, FORCE_RECORDS[types[name]], types[name]) if name in types else None


def _record(field: Field[Any]) -> Record[Any]:
    """The record that a field reads before it converts the values."""
    while isinstance(field, Converted | Deferred):
        field = field.field
    assert isinstance(field, Record)
    return field


def _classes() -> dict[str, type[ScenePart]]:
    alone: Mapping[str, Field[Any]] = {
        "Body": BODY,
        "Marker": MARKER,
        "Curve": CURVE,
        "Motion": MOTION,
        "Expectation": EXPECTATION,
        "Simulation": SIMULATION,
    }
    typed: Mapping[str, Record[Any]] = {**JOINT.variants, **OWN_RECORDS}
    classes = {name: _class_of(name, _record(field)) for name, field in alone.items()}
    return classes | {_class_name(name): _class_of(_class_name(name), record, name) for name, record in typed.items()}


CLASSES: Mapping[str, type[ScenePart]] = MappingProxyType(_classes())
