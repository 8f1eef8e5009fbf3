"""The `simulation` block: the field that reads each setting."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.scene.fields.choices import Alternatives, NameChoice
from mbproj.scene.fields.containers import OneOf, Record
from mbproj.scene.fields.fields import Converted, Field, Flag, List
from mbproj.scene.fields.quantities import Integer, Number
from mbproj.settings import SETTINGS, SIZE, SettingEntry


def _field(entry: SettingEntry) -> Field[Any]:
    """The field that reads a setting."""
    if entry.kind == "str":
        what = "projection method" if entry.name == "projection" else entry.key.replace("_", " ")
        return NameChoice(what, lambda: entry.words)
    if entry.kind == "bool":
        return Flag()
    if entry.kind == "int":
        return Integer(minimum=1)
    number = Number("" if entry.takes in ("1", SIZE) else entry.takes, above=entry.above, maximum=entry.maximum)
    if entry.kind == "float":
        return number
    if entry.kind == "tuple[float, ...]":
        return List(number, None, "times")
    return Alternatives((Converted(number, lambda value: (value, value)), List(number, 2)))


def _fields(length: int) -> dict[str, Field[Any]]:
    """The fields of the settings whose paths have this length, by their keys."""
    return {entry.key: _field(entry) for entry in SETTINGS.values() if len(entry.path) == length}


#: The fields of the options of a projection.
OF_PROJECTION: Mapping[str, Field[Any]] = _fields(2)
PROJECTION: Field[dict[str, Any]] = Alternatives(
    (
        Converted(OF_PROJECTION["method"], lambda method: {"method": method}),
        Record("a projection", OF_PROJECTION, dict),
    )
)
SIMULATION: Record[dict[str, Any]] = Record(
    "a simulation", {**_fields(1), "projection": PROJECTION}, dict, choices=(OneOf(("step", "tolerance")),)
)
