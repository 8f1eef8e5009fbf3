"""Samples inside a step: recorded on the constraints, or the run says why not."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import SimulationError, assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from tests.kernel.scenes import needs_kernel
from tests.support import Recorder

QUICK_RETURN = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2, integrator: dop853, tolerance: 0.021, output_step: 0.001}
bodies:
  crank: {mass: 1, shape: {rod: {length: 0.1, axis: x}}, position: [0.05, 0, 0.2]}
  rocker:
    mass: 2
    shape: {rod: {length: 0.5, axis: x}}
    position: [0.1118, 0, 0.2236]
    orientation: {axis: [0, -1, 0], angle: 63.43 deg}
  link: {mass: 0.5, shape: {rod: {length: 0.2, axis: x}}, position: [0.32, 0, 0.4736]}
  ram: {mass: 3, inertia: [0.01, 0.01, 0.01], position: [0.4165, 0, 0.5]}
joints:
  O: {type: revolute, bodies: [ground, rocker], location: [0, 0, 0], axis: [0, 1, 0]}
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0.2], axis: [0, 1, 0]}
  B: {type: point_on_line, bodies: [rocker, crank], location: [0.1, 0, 0.2], axis: [1, 0, 2]}
  C: {type: revolute, bodies: [rocker, link], location: [0.2236, 0, 0.4472], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [link, ram], location: [0.4165, 0, 0.5], axis: [0, 1, 0]}
  guide: {type: prismatic, bodies: [ground, ram], location: [0.4165, 0, 0.5], axis: [1, 0, 0]}
motions:
  drive: {joint: A, angle: {constant_speed: 60 rpm}}
"""


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
@pytest.mark.parametrize("tolerance", [0.01, 0.021, 0.03, 0.1])
def test_no_sample_is_recorded_with_an_open_joint(tolerance, formulation):
    """Steps of up to 0.2 s pass the fast return of the ram; some samples within them have no pose near by."""
    scene = read_scene_text(QUICK_RETURN, "f", {}, {"tolerance": tolerance, "formulation": formulation})
    system, recorder = compile_system(scene), Recorder()
    try:
        simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    except SimulationError as error:
        assert 0.0 < error.time <= 2.0
        assert error.hint
    assert np.all(recorder["diagnostics/position_violation"] <= 1e-6)
