"""Blocks, one file a family: signals with states of their own, which are replaced by plain signals and states.

A file here has `TYPES`, its blocks by their key in a signal. The reader, the schema and the reference use these tables;
the rest of the program sees states, signals and controllers alone.
"""

from __future__ import annotations

from mbproj.registry import types_of
from mbproj.scene.blocks.control.blocks.block import ControlBlock, Expanded
from mbproj.scene.fields.containers import Record

__all__ = ["BLOCKS", "ControlBlock", "Expanded"]

BLOCKS: dict[str, Record[ControlBlock]] = types_of(__name__, __path__)
