"""Runs with bushings: what mechanics conserves, what dampers lose, the same motion in every formulation and variant."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import Mechanism
from mbproj.base.errors import SimulationError
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.studies.variants import with_stiffness
from mbproj.studies.verify.case import Case, Finding
from mbproj.studies.verify.checks import CHECKS
from tests.dynamics.force_scenes import BUSHINGS, HEAD, PAIR
from tests.kernel.scenes import assembled, needs_kernel
from tests.mechanisms.running import angular_momentum, run_scene

#: Its frames turn by up to more than a right angle.
SPINNING = PAIR.replace(
    "position: [0.1, 0.2, 0.3]", "velocity: [1, 0, -1], angular_velocity: [13, -9, 5], position: [0.1, 0.2, 0.3]"
)
DAMPED = "damping: {translation: [1, 0.5, 2], rotation: [0.4, 0, 0.2]}"
TIGHT = {"duration": 1.0, "tolerance": 1e-12, "integrator": "dop853", "output_step": 0.01}


def spinning(text: str = SPINNING, **settings: object):
    return read_scene_text(text, "s.yaml", {}, {**TIGHT, **settings})


@needs_kernel
def test_a_free_pair_keeps_momentum_angular_momentum_and_energy():
    done = run_scene(spinning(SPINNING.replace(DAMPED, "damping: {}")))
    φ = done["forces/coordinate"][:, 3:]
    assert np.degrees(np.linalg.norm(φ, axis=1).max()) > 90.0
    momentum = done["bodies/velocity"][:, 0] + 2.0 * done["bodies/velocity"][:, 1]
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-12)
    spin = angular_momentum(done, "origin")
    np.testing.assert_allclose(spin, np.broadcast_to(spin[0], spin.shape), atol=1e-11)
    energy = done["diagnostics/total_energy"]
    np.testing.assert_allclose(energy, energy[0], atol=1e-11 * np.abs(energy).max())
    assert np.ptp(done["diagnostics/potential_energy"]) > 0.1


@needs_kernel
def test_dampers_lose_what_is_recorded():
    """x'ᵀ C x' and ωᵀ C ω, ω = H⁻¹ φ' from body to body, integrated over the samples by Simpson's rule, and the energy
    that is gone."""
    done = run_scene(spinning(output_step=0.001))
    rate, energy = done["forces/rate"], done["diagnostics/total_energy"]
    φ = done["forces/coordinate"][:, 3:]
    θ = np.linalg.norm(φ, axis=1, keepdims=True)
    along = np.sum(φ * rate[:, 3:], axis=1, keepdims=True) * φ / θ**2
    ω = along + (rate[:, 3:] - along) * np.sin(θ / 2) / (θ / 2)
    loss = rate[:, :3] ** 2 @ [1.0, 0.5, 2.0] + ω**2 @ [0.4, 0.0, 0.2]
    simpson = 0.001 / 3.0 * (loss[0] + loss[-1] + 4.0 * loss[1:-1:2].sum() + 2.0 * loss[2:-1:2].sum())
    lost = done["diagnostics/dissipation"][-1]
    assert lost > 0.5
    assert lost == pytest.approx(simpson, abs=1e-8)
    assert lost == pytest.approx(energy[0] - energy[-1], abs=1e-10)


@needs_kernel
def test_all_formulations_agree():
    settings = {"duration": 0.1, "output_step": 0.05}
    one, other = (run_scene(spinning(formulation=name, **settings)) for name in ("reduced", "full"))
    for path in ("bodies/position", "bodies/velocity", "forces/coordinate", "forces/rate", "diagnostics/dissipation"):
        np.testing.assert_allclose(one[path], other[path], rtol=0, atol=1e-10, err_msg=path)


@pytest.mark.parametrize("name", ["units", "rotation", "translation", "renumbering", "power", "momentum"])
def test_variants_of_a_scene_have_its_equations(tmp_path, name):
    """With frames that are global, local, or on the ground; so does a stiffness times a factor."""
    path = tmp_path / "scene.yaml"
    path.write_text(
        HEAD + BUSHINGS + BUSHINGS.replace("bu:", "bo:").replace("bg:", "ag:").replace("[b, ground]", "[ground, a]")
    )
    found = CHECKS[name].run(Case(Mechanism.of(read_scene(path))))
    assert isinstance(found, Finding), found
    assert found.passed, found


def test_the_dial_of_stiffness_turns_bushings_too():
    scene = read_scene_text(PAIR)
    (before,), (after,) = scene.forces, with_stiffness(scene, 3.0).forces
    np.testing.assert_allclose(after.stiffness, 3.0 * np.array(before.stiffness))
    assert (after.damping, after.preload) == (before.damping, before.preload)


@pytest.mark.full_where(formulation="full")
@needs_kernel
@pytest.mark.parametrize("formulation", ["reduced", "full"])
def test_half_a_turn_stops_the_run(formulation):
    soft = SPINNING.replace("[[9.0, 1.0, 0.0], [1.0, 8.0, 2.0], [0.0, 2.0, 7.0]]", "[0.1, 0.1, 0.1]")
    scene = spinning(
        soft.replace(DAMPED, "damping: {}"), formulation=formulation, tolerance=None, integrator="rk4", step=0.01
    )
    with pytest.raises(SimulationError) as caught:
        run_scene(scene)
    assert caught.value.where == "force 'bush'"
    assert "at 180 deg a rotation vector has no direction; make it stiffer" in str(caught.value)
    assert 0.1 < caught.value.time < 1.0


def test_a_body_hangs_where_its_weight_and_the_preload_stretch_the_bushing():
    """z = (p - m g) / k."""
    text = (
        "mbproj: 1\ngravity: [0, 0, -10]\nsimulation: {duration: 1, step: 0.001}\n"
        "bodies: {b: {mass: 2, inertia: [0.1, 0.2, 0.25], position: [0, 0, 0]}}\n"
        "forces:\n  bush:\n    type: bushing\n    bodies: [ground, b]\n    location: [0, 0, 0]\n"
        "    stiffness: {translation: [800, 800, 3200], rotation: [10, 10, 10]}\n"
        "    preload: {translation: [0, 0, 5]}\n"
    )
    found = equilibrium(*assembled(read_scene_text(text)))
    np.testing.assert_allclose(found.state.q[:3], [0.0, 0.0, (5.0 - 20.0) / 3200.0], atol=1e-12)
