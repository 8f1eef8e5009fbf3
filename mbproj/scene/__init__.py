"""The scene file: YAML text -> frozen records whose every value knows its place.

The records alone are cheap to import; the reader is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mbproj.scene.records import Scene, Settings

if TYPE_CHECKING:
    from mbproj.scene.read import read_scene, read_scene_text
    from mbproj.scene.settings import settings_to_run

_HOME_OF = {
    "read_scene": "mbproj.scene.read",
    "read_scene_text": "mbproj.scene.read",
    "settings_to_run": "mbproj.scene.settings",
}

__all__ = ["Scene", "Settings", "read_scene", "read_scene_text", "settings_to_run"]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj.scene' has no attribute '{name}'")
    return getattr(import_module(_HOME_OF[name]), name)
