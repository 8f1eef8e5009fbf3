"""What a run by implicit steps says of vibration that it damps, and of energy that goes with it."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.settings import Settings
from mbproj.motion.simulate import simulate
from mbproj.motion.steppers.runge_kutta import amplification
from mbproj.motion.steppers.tableau import load_implicit_tableau
from mbproj.scene.scene import read_scene_text
from tests.kernel.scenes import assembled
from tests.support import Recorder

#: 1 kg on a spring of 1e6 N/m that is 1 mm too long: ω = 1000 rad/s.
SLIDER = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {slider: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.3, 0, 0]}}
joints: {guide: {type: prismatic, bodies: [ground, slider], location: [0, 0, 0], axis: [1, 0, 0]}}
forces:
  coil: {type: spring_damper, points: {ground: [0, 0, 0], slider: [0.3, 0, 0]}, stiffness: 1.0e6, free_length: 0.301,
         damping: DAMPING}
"""


def slider(damping: float) -> Scene:
    return read_scene_text(SLIDER.replace("DAMPING", str(damping)))


def run(scene, **keys):
    """(recorder, report)."""
    recorder = Recorder()
    return recorder, simulate(*assembled(scene), Settings(**keys), recorder)


@pytest.mark.parametrize("integrator", ["esdirk4", "radau5"])
def test_a_vibration_that_is_damped_is_named_with_its_frequency(integrator):
    """ω h = 10 in each of five steps: |R(10 i)| of the amplitude is left after each, and its square of the energy that
    no damper has lost."""
    recorder, report = run(slider(0.0), duration=0.05, step=0.01, integrator=integrator)
    left = amplification(load_implicit_tableau(integrator), 10j)
    assert report.stiffness.startswith(
        f"force 'coil' vibrates with {1000 / (2 * pi):.3g} Hz on the masses that it moves"
    )
    assert f"{integrator} damps that by {100 * (1 - left):.2g} % in a step of 0.01 s (ω h = 10)" in report.stiffness
    assert "steps of 0.0005 s would follow it" in report.stiffness
    energy = recorder["diagnostics/kinetic_energy"] + recorder["diagnostics/potential_energy"]
    np.testing.assert_allclose(energy[1:] / energy[:-1], left**2, rtol=1e-6)
    np.testing.assert_allclose(recorder["diagnostics/energy_balance"], energy - energy[0], atol=1e-12)
    assert not recorder["diagnostics/dissipation"].any()


@pytest.mark.parametrize(("damping", "step"), [(0.0, 0.0005), (1000.0, 0.01)])
def test_what_is_resolved_or_dies_away_by_itself_is_not_named(damping, step):
    _, report = run(slider(damping), duration=5 * step, step=step, integrator="radau5")
    assert report.stiffness == ""
