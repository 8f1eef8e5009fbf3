"""A fixed joint with a frame in each body, and how far it moves a body from the pose of the scene."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.equations.assembly.assemble import moved_from_scene
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at
from mbproj.equations.kinematics import pose_of
from mbproj.formats.geometry import turn
from mbproj.linear.equilibrium.start import start_state
from mbproj.scene.scene import read_scene_text

SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 1 s, step: 1 ms}}
bodies:
  arm: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, -1]}}
  lid: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.3, 0, -1]}}
joints:
  pin: {{type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, 1, 0]}}
  weld:
    type: fixed
    bodies: [arm, lid]
    location: {{arm: [0.06, 0, 0], lid: [-0.1, 0, 0]}}
    axes: {{arm: {{axis: [1, 0, 0], angle: 0.4}}, lid: {{axis: [1, 0, 0], angle: 0.1}}}}{reaction}
"""


@pytest.mark.parametrize("reaction", ["", "\n    reaction: true"])
def test_the_frames_meet_whether_the_bodies_are_one_or_two(reaction):
    """The lid shifts by 0.3 - 0.06 - 0.1 = 0.14 m and turns by 0.4 - 0.1 rad; merged or assembled, it ends there."""
    scene = read_scene_text(SCENE.format(reaction=reaction))
    system = compile_system(scene)
    state = start_state(scene, system)
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    shift, turned = moved_from_scene(scene, system, state.q)
    if reaction:  # assembly shares the way between both bodies
        assert 0.0 < shift < 0.14
        arm, lid = pose_of(state.q).rotation[:2]
        np.testing.assert_allclose(arm.T @ lid, turn(np.array([1.0, 0.0, 0.0]), 0.3), atol=1e-13)
    else:
        assert shift == pytest.approx(0.14, abs=1e-12)
        assert turned == pytest.approx(0.3, abs=1e-12)
