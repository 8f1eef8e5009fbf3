"""The blocks of a scene's signals, expanded into the signals, states and controllers that they become."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mbproj.scene.blocks.control.blocks import Expanded
from mbproj.scene.fields.reading import Reading

#: Blocks of a scene whose items have parts that are called by a name and a point.
WITH_PARTS = ("joints", "forces", "markers", "controllers")


def expanded(found: Mapping[str, Any], reading: Reading) -> Mapping[str, Any]:
    """What was found, with signals, states and controllers in place of blocks; reports names that are taken."""
    signals = found.get("signals", {})
    blocks = {name: each for name, each in signals.items() if isinstance(each, Expanded)}
    if not blocks:
        return found
    for name, block in blocks.items():
        for kind in _taken(name, block, found):
            message = f"'{name}' is the name of one of the {kind} too, and its parts would be called alike"
            reading.report(message, reading.places["signals", name], "give the signal another name")
    parts = [part for each in signals.values() for part in (each.signals if isinstance(each, Expanded) else (each,))]
    states = [*found.get("states", {}).values(), *(state for block in blocks.values() for state in block.states)]
    delays = [each for block in blocks.values() for each in block.controllers]
    controllers = [*delays, *found.get("controllers", {}).values()]
    named = {"signals": parts, "states": states, "controllers": controllers}
    return {**found, **{key: {each.name: each for each in several} for key, several in named.items()}}


def _taken(name: str, block: Expanded, found: Mapping[str, Any]) -> Iterator[str]:
    """The blocks of the scene that use this name, where the signal has parts."""
    if len(block.signals) > 1 or block.states or block.controllers:
        for kind in WITH_PARTS:
            if any(each.replace("-", "_") == name for each in found.get(kind, {})):
                yield kind


def where(kind: str, name: str, signals: Mapping[str, object]) -> tuple[str, ...] | None:
    """The path of the signal that a state, a signal or a controller comes from; None where it stands by itself."""
    own = name.partition(".")[0]
    return ("signals", own) if "." in name or (kind == "controllers" and own in signals) else None
