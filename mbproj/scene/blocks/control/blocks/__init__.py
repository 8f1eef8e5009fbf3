"""Blocks: signals with states of their own, which are replaced by plain signals and states.

The reader, the schema and the reference use these tables;
the rest of the program sees states, signals and controllers alone.
"""

from __future__ import annotations

from mbproj.scene.blocks.control.blocks.block import ControlBlock, Expanded
from mbproj.scene.blocks.control.blocks.limited import LIMITED_BLOCKS
from mbproj.scene.blocks.control.blocks.linear import LINEAR_BLOCKS
from mbproj.scene.fields.containers import Record

__all__ = ["BLOCKS", "ControlBlock", "Expanded"]

BLOCKS: dict[str, Record[ControlBlock]] = {**LIMITED_BLOCKS, **LINEAR_BLOCKS}
