"""Dampers of rotation resist the relative angular velocity however far the bodies have turned, as closed forms say."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.registry import implicit_integrators, integrators
from mbproj.scene.scene import read_scene_text
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import run_scene

#: N m s/rad; about the axes across the figure's and about that, kg m².
DAMPING, ACROSS, ABOUT = 0.02, 0.05, 0.08
SPIN = np.array([3.0, -1.0, 20.0])

#: A top without weight whose frame stands 2 rad apart from the ground's at the start; it turns three times round.
TOP = f"""
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 1, step: 0.01}}
bodies:
  top:
    mass: 1
    inertia: [{ACROSS}, {ACROSS}, {ABOUT}]
    position: [0, 0, 0]
    angular_velocity: {SPIN.tolist()}
    orientation: {{axis: [1, 2, -1], angle: 2 rad}}
joints:
  ball: {{type: spherical, bodies: [ground, top], location: [0, 0, 0]}}
forces:
  oil:
    type: bushing
    bodies: [ground, top]
    location: [0, 0, 0]
    axes: {{ground: {{quaternion: [1, 0, 0, 0]}}, top: {{quaternion: [1, 0, 0, 0]}}}}
    damping: {{rotation: [{DAMPING}, {DAMPING}, {DAMPING}]}}
"""


def angular_velocity(t):
    """Of the top in its axes: c acts on ω, so that each part dies out on its own, and the part across goes round."""
    about = SPIN[2] * np.exp(-DAMPING * t / ABOUT)
    turned = (ABOUT - ACROSS) / ACROSS * SPIN[2] * ABOUT / DAMPING * (1.0 - np.exp(-DAMPING * t / ABOUT))
    across = (SPIN[0] + 1j * SPIN[1]) * np.exp(-DAMPING * t / ACROSS + 1j * turned)
    return np.stack([across.real, across.imag, about], axis=-1)


def top(text=TOP, **settings):
    return run_scene(read_scene_text(text, "s.yaml", {}, settings))


@needs_kernel
@pytest.mark.parametrize("formulation", ["reduced", full("full")])
def test_a_top_in_oil(formulation):
    """Its angular velocity and what is lost, over half a turn too: nothing there depends on where the frames are."""
    accuracy = {"step": 0.01} if formulation == "full" else {"tolerance": 1e-12}
    done = top(formulation=formulation, integrator="dop853", **accuracy)
    expected = angular_velocity(done["time"])
    np.testing.assert_allclose(done["bodies/angular_velocity"][:, 0], expected, rtol=0, atol=1e-9)
    assert np.linalg.norm(done["forces/coordinate"][:, 3:], axis=1).max() > 3.1
    energy = 0.5 * expected**2 @ [ACROSS, ACROSS, ABOUT]
    np.testing.assert_allclose(done["diagnostics/dissipation"], energy[0] - energy, rtol=0, atol=1e-9 * energy[0])


@needs_kernel
@pytest.mark.parametrize("integrator", implicit_integrators())
def test_orders_of_implicit_steps(integrator):
    errors = []
    for count in (40, 80, 160):
        done = top(integrator=integrator, step=1.0 / count, output_step=1.0, formulation="reduced")
        errors.append(np.abs(done["bodies/angular_velocity"][-1, 0] - angular_velocity(1.0)).max())
    assert np.log2(errors[0] / errors[-1]) / 2 > integrators()[integrator].order - 0.3


#: A weight on an arm of 1 m in thick oil: its own inertia counts for 1e-7 only.
CREEPING = """
mbproj: 1
gravity: [0, 0, -10]
bodies:
  bob: {mass: 1, inertia: [0.1, 0.2, 0.15], position: [0.6, 0, 0.8]}
joints:
  ball: {type: spherical, bodies: [ground, bob], location: [0, 0, 0]}
forces:
  oil:
    type: bushing
    bodies: [ground, bob]
    location: [0, 0, 0]
    axes: {ground: {axis: [1, 2, 1], angle: 2.5 rad}, bob: {quaternion: [1, 0, 0, 0]}}
    damping: {rotation: [1.0e4, 1.0e4, 1.0e4]}
"""


@needs_kernel
@pytest.mark.parametrize("formulation", ["reduced", full("full")])
@pytest.mark.parametrize("integrator", implicit_integrators())
def test_thick_oil_takes_few_steps(integrator, formulation):
    """c θ' = m g l sin θ of the angle from where it hangs: tan(θ/2) dies out with c/(m g l) = 1000 s, c/I = 1e4 1/s."""
    keys = {"integrator": integrator, "formulation": formulation, "duration": 2000.0, "output_step": 2000.0}
    scene = read_scene_text(CREEPING, "s.yaml", {}, {**keys, "tolerance": 1e-7})
    done = run_scene(scene)
    start, end = done["bodies/position"][[0, -1], 0]
    θ = np.arctan2(np.hypot(*end[:2]), -end[2])
    expected = np.tan(0.5 * np.arctan2(np.hypot(*start[:2]), -start[2])) * np.exp(-2.0)
    assert np.tan(0.5 * θ) == pytest.approx(expected, rel=1e-5)
    assert done.report.counters["steps"] < 200
