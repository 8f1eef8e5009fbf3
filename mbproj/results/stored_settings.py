"""Reads the settings of a run from its file by the fields of a scene's `simulation` block. So settings are refused that
no scene can have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.errors import Place
from mbproj.scene.blocks.simulation import SIMULATION
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import ProjectionSettings, Settings
from mbproj.scene.text.nodes import MappingNode, Node, from_value

PLACE = Place("settings")


class UnfitSettings(ValueError):
    """The settings are such as no scene can have; the message says which and why."""


def settings_from(values: Any) -> Settings:
    """The Settings from `values`, which `dataclasses.asdict` made of them, and which JSON wrote and read."""
    reading = Reading()
    if isinstance(values, Mapping) and values.get("break_times") == []:
        values = {key: value for key, value in values.items() if key != "break_times"}  # a scene names one or none
    node = _node(values)
    read = SIMULATION.read(node, ("simulation",), reading) if isinstance(node, MappingNode) else None
    if read is None or reading.problems:
        raise UnfitSettings(reading.problems[0].message if reading.problems else "it is not a mapping of keys")
    return Settings(**{**read, "projection": ProjectionSettings(**read.get("projection", {}))})


def _node(value: Any) -> Node:
    """A value of JSON as a node of a scene; entries that are None are left out."""
    if not isinstance(value, Mapping):
        return from_value(value, PLACE)
    given = {key: _node(part) for key, part in value.items() if part is not None}
    return MappingNode(given, dict.fromkeys(given, PLACE), PLACE)
