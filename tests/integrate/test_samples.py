"""Samples inside a step."""

from __future__ import annotations

import pytest

from mbproj import SimulationError, assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from tests.kernel.scenes import needs_kernel

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
def test_a_sample_that_no_correction_closes_ends_the_run_at_its_time():
    """A step of 0.16 s passes the fast return of the ram; samples within it have no pose."""
    scene = read_scene_text(QUICK_RETURN)
    system = compile_system(scene)
    with pytest.raises(SimulationError, match="no longer finite") as error:
        simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene))
    assert 1.1 < error.value.time < 1.3
