"""Models in other formats, MJCF, URDF and SDF, as scenes.

A reader makes an `ImportedMechanism` of a file. Its table `said` lists what a scene cannot express. `scene_text` writes
the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbproj.registry import lazily

if TYPE_CHECKING:
    from mbproj.formats.as_scene import scene_text
    from mbproj.formats.mechanism import ImportOptions
    from mbproj.formats.read import read_model

__getattr__ = lazily(
    __name__,
    {
        "as_scene": "scene_text",
        "mechanism": "ImportOptions",
        "read": "read_model",
    },
)
