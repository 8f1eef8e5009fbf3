"""Replaces the blocks among a scene's signals (`control.blocks`) by plain signals, states and controllers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mbproj.scene.blocks.control.blocks import Expanded
from mbproj.scene.fields.reading import Reading

#: Blocks of a scene whose items have parts that expressions name with a point, as in `pin.angle`.
WITH_PARTS = ("joints", "forces", "markers", "controllers")


def expanded(given: Mapping[str, Any], reading: Reading) -> Mapping[str, Any]:
    """Return the blocks of the scene `given` with plain signals, states and controllers in place of blocks. Reports
    signals whose parts would have the names of another item's parts."""
    signals = given.get("signals", {})
    blocks = {name: each for name, each in signals.items() if isinstance(each, Expanded)}
    if not blocks:
        return given
    for name, block in blocks.items():
        for kind in _blocks_with_name(name, block, given):
            message = f"'{name}' is the name of one of the {kind} too, and its parts would be called alike"
            reading.report(message, reading.places["signals", name], "give the signal another name")
    parts = [part for each in signals.values() for part in (each.signals if isinstance(each, Expanded) else (each,))]
    states = [*given.get("states", {}).values(), *(state for block in blocks.values() for state in block.states)]
    delays = [each for block in blocks.values() for each in block.controllers]
    controllers = [*delays, *given.get("controllers", {}).values()]
    named = {"signals": parts, "states": states, "controllers": controllers}
    return {**given, **{key: {each.name: each for each in several} for key, several in named.items()}}


def _blocks_with_name(name: str, block: Expanded, blocks: Mapping[str, Any]) -> Iterator[str]:
    """The blocks of the scene with an item of this name, where the signal has parts; none where it has no parts."""
    if len(block.signals) > 1 or block.states or block.controllers:
        for kind in WITH_PARTS:
            if any(each.replace("-", "_") == name for each in blocks.get(kind, {})):
                yield kind


def where(kind: str, name: str, signals: Mapping[str, object]) -> tuple[str, ...] | None:
    """The path of the signal from which the item `name` of the block `kind` was expanded; None where the scene itself
    has the item."""
    own = name.partition(".")[0]
    return ("signals", own) if "." in name or (kind == "controllers" and own in signals) else None
