"""Many impacts in one run: joints stay closed, and restitution 1 keeps the energy."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from tests.support import Recorder

SCENE = """
mbproj: 1
gravity: [0, -10, 0]
simulation: {{duration: 100, integrator: dop853, tolerance: 1.0e-12, output_step: 0.1, formulation: {form}}}
bodies:
  bob: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, -1, 0]}}
joints:
  pivot:
    type: revolute
    bodies: [ground, bob]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    speed: 2
    limits: {{angle: {{range: [-0.1, 0.1], rigid: true, restitution: 1}}}}
"""


class Struck(Recorder):
    """Counts impacts."""

    impacts = 0

    def events(self, events):
        self.impacts = sum(event.kind == "impact" for event in events)


@pytest.mark.parametrize("form", ["planar", pytest.param("reduced", marks=pytest.mark.full)])
def test_a_pendulum_between_two_walls_keeps_its_energy_over_a_thousand_impacts(form):
    scene, recorded = read_scene_text(SCENE.format(form=form)), Struck()
    system = compile_system(scene)
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorded)
    energy = recorded["diagnostics/total_energy"]
    assert 980 <= recorded.impacts <= 1000
    assert np.abs(energy - energy[0]).max() < 1e-10 * 2.0
    assert report.position_violation.value < 2e-13
