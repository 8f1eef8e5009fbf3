"""Rods without inertia about their axis: planar coordinates do not ask for it, and the reactions are the full ones."""

from __future__ import annotations

import numpy as np

from mbproj.scene.scene import read_scene_text
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import run_scene

pytestmark = needs_kernel

RODS = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 0.3, tolerance: 1e-11, integrator: dop853, output_step: 0.1}
bodies:
  a: {mass: 1, shape: {rod: {length: 1, axis: x}}, position: [0.5, 0, 0]}
  b: {mass: 2, shape: {rod: {length: 1, axis: x}}, position: [1.5, 0.2, 0]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [a, b], location: [1, 0.1, 0], axis: [0, 1, 0]}
forces:
  side: {type: force, body: b, force: [1, 3, 0]}
"""


def test_thin_rods_are_planar_and_their_reactions_those_of_the_full_form():
    runs = [run_scene(read_scene_text(RODS, "r.yaml", {}, {"formulation": name})) for name in ("auto", "full")]
    planar, full = runs
    assert planar.report.formulation == "planar"
    for path in ("bodies/position", "joints/reaction_force", "joints/reaction_torque"):
        size = max(1.0, np.abs(full[path]).max())
        np.testing.assert_allclose(planar[path], full[path], rtol=0, atol=1e-8 * size, err_msg=path)


def test_in_space_thin_rods_run_reduced():
    text = RODS.replace("axis: [0, 1, 0]}\nforces", "axis: [0, 1, 1]}\nforces")
    done = run_scene(read_scene_text(text, "r.yaml"))
    assert done.report.formulation == "reduced"
