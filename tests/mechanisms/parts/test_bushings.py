"""Bushings: forces as the gradient of their energy, and runs in every formulation and variant."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbproj import Mechanism, compile_system, initial_guess
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.settings import Settings
from mbproj.equations.fast_modes import fast_modes, responses, slopes, speeds_of_free_bodies
from mbproj.equations.forces import applied, law_state
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.tangent_space import moved, velocities
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.motion.formulations.choice import choose
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.studies.variants import with_stiffness
from mbproj.studies.verify.case import Case, Finding
from mbproj.studies.verify.checks import CHECKS
from tests.dynamics.force_scenes import BUSHINGS, FORCES, HEAD, K_R, K_X, PAIR
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import angular_momentum, run_scene
from tests.support import assembled

# Bushings: forces as the exact gradient of their energy, alike for both bodies, and the formulas for small angles.

STILL = np.zeros(0)


def pair(text=PAIR):
    scene = read_scene_text(text)
    system = compile_system(scene)
    return system, initial_guess(scene, system).q


def turned_apart(q, angle, axis=(1.0, -2.0, 0.5), shift=(0.02, -0.01, 0.03)):
    """The pair with its second body turned against the first about a global axis, and shifted."""
    u = np.zeros(12)
    u[6:9] = shift
    A = pose_of(q).rotation[1]
    u[9:] = A.T @ (angle * np.array(axis) / np.linalg.norm(axis))
    return moved(q, u)


def laws_at(system, q, v=None):
    pose = pose_of(q)
    return law_state(Instant(system, pose, twist_of(pose, np.zeros_like(q) if v is None else v), 0.0, STILL))


def wrench(system, q, u):
    """Forces, global, and torques in body axes on both bodies, (12,), at velocities u (12,)."""
    pose = pose_of(q)
    loads = applied(Instant(system, pose, twist_of(pose, velocities(pose, u)), 0.0, STILL))
    return np.concatenate([loads.force[:-1], loads.torque[:-1]], axis=1).ravel()


@pytest.mark.parametrize("angle", [0.0, 1e-5, 0.05, 0.0633, np.pi / 2, 2.9])
def test_forces_are_minus_the_gradient_of_the_energy(angle):
    """f ξ = -dV/dξ, by differences of V of fourth order, from no angle over both branches to near half a turn."""
    system, q = pair()
    q, h = turned_apart(q, angle), 1e-3
    found = wrench(system, q, np.zeros(12))
    for direction, force in zip(np.eye(12), found, strict=True):
        V = [float(laws_at(system, moved(q, step * h * direction)).stored) for step in (-2, -1, 1, 2)]
        slope = (V[0] - 8 * V[1] + 8 * V[2] - V[3]) / (12 * h)
        assert force == pytest.approx(-slope, abs=2e-9)
    assert np.abs(found).max() > 1.0


@pytest.mark.parametrize("angle", [0.0, 0.05, np.pi / 2, 2.9])
def test_rates_are_those_of_the_coordinates_and_power_is_force_times_rate(angle):
    system, q = pair()
    q, u, h = turned_apart(q, angle), np.random.default_rng(1).normal(size=12), 1e-4
    along = [laws_at(system, moved(q, step * h * u)).value for step in (-2, -1, 1, 2)]
    slope = (along[0] - 8 * along[1] + 8 * along[2] - along[3]) / (12 * h)
    state = laws_at(system, q, velocities(pose_of(q), u))
    np.testing.assert_allclose(state.rate, slope, atol=1e-9)
    assert wrench(system, q, u) @ u == pytest.approx(state.force @ state.rate, rel=1e-12)
    pose = pose_of(q)
    loads = applied(Instant(system, pose, twist_of(pose, velocities(pose, u)), 0.0, STILL))
    seen = np.concatenate([state.rate[:3], relative_angular_velocity(system, pose, u)])
    assert loads.dissipation == pytest.approx(seen @ np.diag([1, 0.5, 2, 0.4, 0, 0.2]) @ seen, rel=1e-13)


def relative_angular_velocity(system, pose, u):
    """ω2 - ω1 in the axes of the frame midway, of velocities (12,) with ω in body axes."""
    first, second = (
        Rotation.from_matrix(pose.rotation[side] @ rotation(system.forces.bushings.turn[0, side])) for side in (0, 1)
    )
    midway = first * Rotation.from_rotvec(0.5 * (first.inv() * second).as_rotvec())
    return midway.inv().apply(pose.rotation[1] @ u[9:] - pose.rotation[0] @ u[3:6])


def test_small_deflections_follow_the_usual_formulas():
    """F = p - K x - C x' along the axes of either frame, on body 2 at its point, and its opposite on body 1: the law of
    Adams' BUSHING and of others, to first order."""
    size = 1e-6
    axes = np.array(compile_system(read_scene_text(PAIR)).forces.bushings.turn)
    errors = []
    for scale in (size, size / 2):
        system, q = pair(PAIR.replace("preload: {translation: [1, -2, 3], rotation: [0.1, 0.3, -0.2]}", "preload: {}"))
        x, φ = scale * np.array([1.0, -2.0, 3.0]), scale * np.array([-1.0, 0.5, 2.0])
        pose = pose_of(q)
        frame = pose.rotation[0] @ rotation(axes[0, 0])
        arm = pose.rotation[1] @ system.forces.bushings.origin[0, 1]
        u = np.zeros(12)
        u[6:9] = frame @ x - np.cross(frame @ φ, arm)  # so that the point moves by x
        u[9:] = pose.rotation[1].T @ frame @ φ
        found = wrench(system, moved(q, u), np.zeros(12))
        force, torque = frame @ (-K_X @ x), frame @ (-K_R @ φ)
        on_second = np.concatenate([force, pose.rotation[1].T @ (torque + np.cross(arm, force))])
        errors.append(np.abs(found[6:] - on_second).max())
    assert errors[0] < 1e-3 * np.abs(on_second).max()
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


def rotation(Λ):
    return pose_of(np.concatenate([np.zeros(3), Λ])).rotation[0]


def test_neither_body_comes_first():
    """With the bodies exchanged the coordinates are their opposites, and with the preload's sign all forces stay."""
    preload = "preload: {translation: [1, -2, 3], rotation: [0.1, 0.3, -0.2]}"
    other = PAIR.replace("bodies: [a, b]", "bodies: [b, a]").replace(
        preload, "preload: {translation: [-1, 2, -3], rotation: [-0.1, -0.3, 0.2]}"
    )
    (one, q), (two, _) = pair(), pair(other)
    q, u = turned_apart(q, 1.3), np.random.default_rng(2).normal(size=12)
    np.testing.assert_allclose(wrench(one, q, u), wrench(two, q, u), atol=1e-12)
    v = velocities(pose_of(q), u)
    np.testing.assert_allclose(laws_at(one, q, v).value, -laws_at(two, q, v).value, atol=1e-14)
    np.testing.assert_allclose(laws_at(one, q, v).rate, -laws_at(two, q, v).rate, atol=1e-13)


def test_action_and_reaction():
    system, q = pair()
    q = turned_apart(q, 2.0)
    pose = pose_of(q)
    loads = applied(Instant(system, pose, twist_of(pose, np.random.default_rng(3).normal(size=14)), 0.0, STILL))
    turned = (pose.rotation @ loads.torque[..., None])[..., 0]
    np.testing.assert_allclose(loads.force.sum(axis=0), 0.0, atol=1e-13)
    np.testing.assert_allclose((turned + np.cross(pose.position, loads.force)).sum(axis=0), 0.0, atol=1e-12)


def test_near_half_a_turn_the_run_stops():
    system, q = pair()
    wrench(system, turned_apart(q, 2.99), np.zeros(12))
    said = (
        "at force 'bush': its frames stand 172.5 deg apart, and at 180 deg a rotation vector has no direction; make it"
    )
    for angle in (3.01, 2 * np.pi - 3.01):
        with pytest.raises(SimulationError, match=said):
            wrench(system, turned_apart(q, angle), np.zeros(12))


def test_a_body_on_a_bushing_has_the_frequency_of_a_formula():
    """√(k / m), √(k / J) and c / m, of the fastest; coupled by the matrix where it couples."""
    base = (
        "mbproj: 1\ngravity: [0, 0, 0]\nbodies:\n  b: {mass: 2, inertia: [0.1, 0.2, 0.25], position: [0, 0, 0]}\n"
        "forces:\n  bush: {type: bushing, bodies: [ground, b], location: [0, 0, 0], "
    )
    coupled = np.sqrt(np.linalg.eigvalsh(K_X / 2.0).max())
    for keys, expected in (
        ("stiffness: {translation: [800, 200, 100]}", 20.0),
        ("stiffness: {rotation: [10, 80, 10]}", 20.0),
        ("damping: {translation: [0, 60, 0]}", 30.0),
        (f"stiffness: {{translation: {K_X.tolist()}}}", coupled),
    ):
        system, state = assembled(read_scene_text(base + keys + "}\n"))
        slope, pose = slopes(system, state), pose_of(state.q)
        found = fast_modes(responses(system, pose, slope.acting), slope.acting, slope, np.zeros((0, 0)))[0]
        assert abs(found.eigenvalue) == pytest.approx(expected, rel=1e-12)
        assert found.shares.sum() == pytest.approx(1.0)
        assert speeds_of_free_bodies(system, pose, slope).max() >= expected * (1.0 - 1e-12)


@needs_kernel
def test_the_kernel_responds_as_the_full_equations():
    system, state = assembled(read_scene_text(HEAD + FORCES + BUSHINGS))
    along = np.arange(system.forces.size)
    compiled = choose(system, state, Settings(duration=1.0, step=0.1, formulation="reduced")).compiled
    found, expected = compiled.responses(state, along), responses(system, pose_of(state.q), along)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_frames_of_one_rigid_body():
    text = HEAD.replace("type: revolute", "type: fixed").replace(", axis: [1, 2, -1]", "") + BUSHINGS
    with pytest.raises(InputError, match="'bu' acts between two frames of one rigid body; fixed joints have merged"):
        compile_system(read_scene_text(text))


# Runs with bushings: what mechanics conserves, what dampers lose, the same motion in every formulation and variant.

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
