"""The parts of a scene as classes with the words of YAML, `Body`, `Revolute` and others, made from its tables.

Their arguments are the keys of the scene. `python scripts/write_parts.py` writes `__init__.pyi`, which says the same to
editors and type checkers.
"""

from __future__ import annotations

from typing import Any

from mbproj.parts.classes import CLASSES

__all__ = list(CLASSES)


def __getattr__(name: str) -> Any:
    if name not in CLASSES:
        raise AttributeError(f"module 'mbproj.parts' has no attribute '{name}'")
    return CLASSES[name]


def __dir__() -> list[str]:
    return sorted(CLASSES)
