"""The scene's motions as arrays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.functions.program_set import flatten
from mbproj.model.channels import Motions
from mbproj.model.primitive_set import Binding
from mbproj.scene.records import Scene


def compile_motions(scene: Scene, coordinates: Mapping[str, Binding]) -> tuple[Motions, tuple[str, ...]]:
    """The motions and their names; `coordinates` are the joints' by whole name."""
    motions = scene.motions
    starts = {joint.name: joint.start for joint in scene.joints}
    names = [f"{motion.joint}.{motion.coordinate}" for motion in motions]
    index = np.array([list(coordinates).index(name) for name in names], dtype=np.intp)
    from_start = [starts[each.joint].get(each.coordinate, 0.0) if each.from_start else 0.0 for each in motions]
    places = tuple(scene.place("motions", motion.name, motion.coordinate) for motion in motions)
    functions = flatten([motion.function for motion in motions])
    return Motions(index, np.array(from_start), functions, places), tuple(each.name for each in motions)
