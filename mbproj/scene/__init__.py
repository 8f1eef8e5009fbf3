"""The scene file: YAML text -> frozen records whose every value knows its place.

The records alone are cheap to import; the reader is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbproj.registry import lazily
from mbproj.scene.records import Scene, Settings

if TYPE_CHECKING:
    from mbproj.scene.read import read_scene, read_scene_text
    from mbproj.scene.settings import settings_to_run

__getattr__ = lazily(
    __name__,
    {
        "read": "read_scene read_scene_text",
        "settings": "settings_to_run",
    },
)
