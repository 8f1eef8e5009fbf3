"""Models in other formats, MJCF, URDF and SDF, as scenes.

A reader makes an `ImportedMechanism` of a file. Its table `said` lists what a scene cannot express. `scene_text` writes
the scene."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbproj.formats.as_scene import scene_text
    from mbproj.formats.mechanism import ImportOptions
    from mbproj.formats.read import read_model

_HOME_OF = {"ImportOptions": "mechanism", "read_model": "read", "scene_text": "as_scene"}

__all__ = ["ImportOptions", "read_model", "scene_text"]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj.formats' has no attribute '{name}'")
    return getattr(import_module(f"mbproj.formats.{_HOME_OF[name]}"), name)
