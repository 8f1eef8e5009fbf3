"""The scene file: YAML text -> frozen records whose every value knows its place.

The records alone are cheap to import; the reader is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbproj.registry import lazily
from mbproj.scene.read import Scene
from mbproj.scene.records import Settings

if TYPE_CHECKING:
    from mbproj.scene.read import read_scene, read_scene_text
    from mbproj.scene.settings import settings_to_run

__getattr__ = lazily(
    __name__,
    {
        "blocks.curves.sheet": "sheet",
        "blocks.elements": "ELEMENTS",
        "blocks.forces.dry_joints": "friction_units",
        "blocks.forces.stops": "stop_units",
        "blocks.observables": "MECHANICAL_ADVANTAGE OBSERVABLES TRANSMISSION_ANGLE VELOCITY_RATIO",
        "blocks.oversights": "notes_on oversights",
        "expressions.evaluate": "Unavailable Value evaluate",
        "expressions.syntax_tree": "ExpressionError",
        "fields.rotations": "from_matrix to_matrix",
        "meshes": "meshes_of",
        "read": "SceneText read_scene read_scene_text",
        "records": "Body BodyForce Expectation Joint Marker Pair Passage ProjectionSettings Quaternion Vector",
        "sampling": "output_times whole_steps",
        "schema": "scene_schema",
        "settings": "settings_to_run with_options",
        "solids.shapes": "SHAPES",
    },
)
