"""What keeps an imported scene from running: couplers that it cannot hold, and loops of rounded numbers."""

from __future__ import annotations

from mbproj.errors import InputError, Problem
from mbproj.formats.as_scene import scene_text
from mbproj.formats.mechanism import Mechanism, Same

#: Numbers of a model are rounded to so many m at most: 0.1 mm.
ROUNDED = 1e-4


def without_refused(mechanism: Mechanism, version: str) -> tuple[str, list[Problem]]:
    """The scene without couplers that compiling it refuses, and what it refuses besides."""
    from mbproj.dynamics.assembly.adjust import needed, rounded_up
    from mbproj.model import compile_system, initial_guess
    from mbproj.scene import read_scene_text

    while True:
        text = scene_text(mechanism, version)
        try:
            scene = read_scene_text(text, mechanism.file)
            system = compile_system(scene)
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
            size = needed(system, initial_guess(scene, system).q)
            if 0.0 < size <= ROUNDED:
                mechanism.adjust = rounded_up(size)
                what = f"close where joints move by up to {1e6 * size:.3g} um: the scene has adjust_joints"
                mechanism.say("loops of rounded numbers", None, what, Same.YES)
                text = scene_text(mechanism, version)
            return text, []
