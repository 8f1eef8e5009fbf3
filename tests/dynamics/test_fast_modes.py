"""The modes of the forces alone: responses against the kernel and by hand, slopes against differences."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from mbproj.base.settings import Settings
from mbproj.equations.fast_modes import fast_modes, responses, slopes, speeds_of_free_bodies
from mbproj.equations.kinematics import pose_of
from mbproj.kernel import core
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.reduced import Reduced
from mbproj.scene.scene import read_scene, read_scene_text
from tests.integrate.stiff_scenes import PENDULUM, WHEEL, held_by, rod
from tests.kernel.scenes import assembled, needs_kernel
from tests.support import ROOT


def mode_of(scene):
    system, state = assembled(scene)
    slope = slopes(system, state)
    found = fast_modes(responses(system, pose_of(state.q), slope.acting), slope.acting, slope, np.zeros((0, 0)))
    return next(iter(found), None)


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        ("stiffness: 200", 20.0),  # √(k / I)
        ("damping: 30", 60.0),  # c / I
        ("torque: -200 * angle - 3 * angle_dot", 20.0),
        ("torque: -5 * tanh(angle_dot / 0.1 - 20)", 5.0 / 0.1 / 0.5),
        ("table: {rows: [[-1, 400], [0, 0], [0.1, -1], [1, -451]], between: linear}", np.sqrt(500.0 / 0.5)),
    ],
)
def test_a_wheel_on_a_spring_has_the_frequency_of_a_formula(law, expected):
    """At 0.1 rad, where the last segment of the table begins, and 2 rad/s, where tanh is steepest."""
    found = mode_of(held_by(f"{{type: torsion_spring_damper, joint: pin, {law}}}", WHEEL))
    assert abs(found.eigenvalue) == pytest.approx(expected, rel=1e-9)
    np.testing.assert_allclose(found.shares, [1.0])


def test_what_depends_on_time_alone_has_no_mode():
    assert (
        slopes(*assembled(held_by("{type: torsion_spring_damper, joint: pin, torque: exp(50*t)}", WHEEL))).acting.size
        == 0
    )


def test_a_joint_that_holds_a_body_makes_it_heavier():
    """Two bobs on one line, on springs of 100 and 300 N/m: det(K - ω² M) = 0 by hand; between ground and a body that is
    held nothing moves."""
    scene = read_scene_text(
        "mbproj: 1\ngravity: [0, 0, 0]\nbodies:\n"
        "  a: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}\n"
        "  b: {mass: 2, inertia: [1, 1, 1], position: [2, 0, 0]}\n"
        "joints:\n  A: {type: prismatic, bodies: [ground, a], location: [0, 0, 0], axis: [1, 0, 0]}\n"
        "  B: {type: prismatic, bodies: [a, b], location: [0, 0, 0], axis: [1, 0, 0]}\n"
        "forces:\n  one: {type: spring_damper, points: {ground: [0, 0, 0], a: [1, 0, 0]}, stiffness: 100}\n"
        "  two: {type: spring_damper, points: {a: [1, 0, 0], b: [2, 0, 0]}, stiffness: 300}\n"
        "  across: {type: spring_damper, points: {ground: [1, 1, 0], a: [1, 0, 0]}, stiffness: 1.0e9}\n"
    )
    found = mode_of(scene)
    square = np.linalg.eigvals(np.diag([1.0, 0.5]) @ np.array([[400.0, -300.0], [-300.0, 300.0]])).max()
    assert abs(found.eigenvalue) == pytest.approx(np.sqrt(square), rel=1e-9)
    assert found.shares[1] > 0.8


@needs_kernel
@pytest.mark.parametrize(
    "scene", [rod(1e6, 10.0), read_scene(str(ROOT / "tests/data/stiff_governor.yaml"))], ids=["rod", "governor"]
)
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_the_kernel_responds_as_the_full_equations(scene, formulation):
    system, state = assembled(scene)
    laws = np.arange(system.forces.laws.size)
    if formulation == "planar" and scene.bodies[0].name == "spindle":
        compiled = Reduced(core(), system)
    else:
        compiled = choose(system, state, Settings(duration=1.0, step=0.1, formulation=formulation)).compiled
    found, expected = compiled.responses(state, laws), responses(system, pose_of(state.q), laws)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(found, found.T, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_free_bodies_bound_the_fastest_mode():
    for scene in (rod(1e6, 0.0), held_by("{type: linear_spring_damper, joint: slide, damping: 50}", PENDULUM)):
        system, state = assembled(scene)
        bound = speeds_of_free_bodies(system, pose_of(state.q), slopes(system, state))
        assert abs(mode_of(scene).eigenvalue) <= bound.max()


def test_a_speed_that_overflows_is_infinite_without_a_warning():
    """k = 1e300 N m/rad of a formula on 1e-12 kg m²: √(k w) has no finite square, and c w neither."""
    wheel = WHEEL.replace("[1, 0.5, 1]", "[1e-12, 1e-12, 1e-12]")
    system, state = assembled(held_by("{type: torsion_spring_damper, joint: pin, torque: -1e300 * angle}", wheel))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bound = speeds_of_free_bodies(system, pose_of(state.q), slopes(system, state))
    assert np.isinf(bound).all()
