"""The parts of a scene as classes with the words of YAML, `Body`, `Revolute` and others, made from its tables.

Their arguments are the keys of the scene. Types of force of plug-ins have classes, too. `python scripts/write_parts.py`
writes `parts.pyi`, which says the same of mbproj's own to editors and type checkers.
"""

from __future__ import annotations

from typing import Any

from mbproj.scene.part_classes import CLASSES, class_of_plugin

__all__ = list(CLASSES)


def __getattr__(name: str) -> Any:
    if name in CLASSES:
        return CLASSES[name]
    plugin = None if name.startswith("_") else class_of_plugin(name)
    if plugin is None:
        raise AttributeError(f"module 'mbproj.scene.parts' has no attribute '{name}'")
    return plugin


def __dir__() -> list[str]:
    return sorted(CLASSES)
