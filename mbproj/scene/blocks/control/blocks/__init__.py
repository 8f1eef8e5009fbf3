"""Blocks, one file a family: signals with states of their own, which are replaced by plain signals and states.

A file here has `TYPES`, its blocks by their key in a signal. The reader, the schema and the reference use these tables;
the rest of the program sees states, signals and controllers alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules

from mbproj.scene.blocks.control.blocks.block import ControlBlock, Expanded
from mbproj.scene.fields.containers import Record

__all__ = ["BLOCKS", "ControlBlock", "Expanded"]


def _found() -> Iterator[tuple[str, Record[ControlBlock]]]:
    for module in sorted(iter_modules(__path__), key=lambda module: module.name):
        yield from getattr(import_module(f"{__name__}.{module.name}"), "TYPES", {}).items()


BLOCKS: dict[str, Record[ControlBlock]] = dict(_found())
