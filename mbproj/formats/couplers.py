"""Couplers that a scene cannot hold: taken out of it, and said, before it is written."""

from __future__ import annotations

from mbproj.errors import InputError, Problem
from mbproj.formats.as_scene import scene_text
from mbproj.formats.mechanism import Mechanism, Same


def without_refused(mechanism: Mechanism, version: str) -> tuple[str, list[Problem]]:
    """The scene without couplers that compiling it refuses, and what it refuses besides."""
    from mbproj.model import compile_system
    from mbproj.scene import read_scene_text

    while True:
        text = scene_text(mechanism, version)
        try:
            compile_system(read_scene_text(text, mechanism.file))
        except InputError as error:
            couplers = [name for name, joint in mechanism.joints.items() if joint.type == "coupler"]
            refused = {
                name: problem.message
                for problem in error.problems
                for name in couplers
                if f"'{name}'" in problem.message
            }
            if not refused:
                return text, list(error.problems)
            for name, why in refused.items():
                joint = mechanism.joints.pop(name)
                mechanism.say(f"coupler '{name}'", joint.place, f"left out: {why}", Same.NO)
        else:
            return text, []
