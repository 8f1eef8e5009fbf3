"""The modes of the forces alone, and what `check` says of fast ones."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from mbproj.base.errors import SimulationError
from mbproj.base.settings import Settings
from mbproj.commands.report.scene import facts, lines
from mbproj.equations.fast_modes import fast_modes, responses, slopes, speeds_of_free_bodies
from mbproj.equations.kinematics import pose_of
from mbproj.kernel import core
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.reduced import Reduced
from mbproj.motion.stiffness import fastest_at, stable_steps
from mbproj.scene.scene import read_scene, read_scene_text
from tests.integrate.stiff_scenes import PENDULUM, WHEEL, held_by, rod
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import run_scene
from tests.support import ROOT, assembled

# The modes of the forces alone: responses against the kernel and by hand, slopes against differences.


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


# What `check` says of fast forces: whose they are, what they move, and steps that runs hold to.

LINE = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
  b: {mass: 4, inertia: [1, 1, 1], position: [2, 0, 0], velocity: [0.01, 0, 0]}
joints:
  A: {type: prismatic, bodies: [ground, a], location: [0, 0, 0], axis: [1, 0, 0]}
  B: {type: prismatic, bodies: [ground, b], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  hard: {type: spring_damper, points: {ground: [0, 0, 0], a: [1, 0, 0]}, stiffness: 1.0e6}
  soft: {type: spring_damper, points: {ground: [0, 0, 0], b: [2, 0, 0]}, stiffness: 400}
"""


def found(text):
    scene = read_scene_text(text)
    system, state = assembled(scene)
    return fastest_at(choose(system, state, scene.settings), system, state)


def test_forces_and_bodies_by_a_formula():
    """√(k / m): 1000 rad/s of one, 10 rad/s of the other."""
    modes = found(LINE)
    assert [(mode.forces, mode.bodies) for mode in modes] == [(("hard",), ("a",)), (("soft",), ("b",))]
    np.testing.assert_allclose([mode.time_constant for mode in modes], [1e-3, 0.1], rtol=1e-6)
    assert facts(modes, {})["fast_modes"][0]["frequency"] == pytest.approx(1000.0 / (2.0 * np.pi), rel=1e-6)
    assert lines(modes, {"rk4": 2.84e-3})[1:] == [
        "    'hard' on 'a' vibrates with 159 Hz, time constant 1 ms",
        "    'soft' on 'b' vibrates with 1.59 Hz, time constant 100 ms",
        "  stable up to steps of",
        "    rk4  2.84 ms",
    ]


def test_what_only_decays_is_said_to():
    (mode,) = fastest_at(*_wheel("{type: torsion_spring_damper, joint: pin, damping: 30}"))
    assert mode.time_constant == pytest.approx(0.5 / 30.0, rel=1e-9)
    assert lines([mode], {})[1].endswith("decays, time constant 16.7 ms")


def _wheel(force):
    scene = held_by(force, WHEEL)
    system, state = assembled(scene)
    return choose(system, state, scene.settings), system, state


def test_a_scene_without_forces_along_coordinates_has_none():
    scene = read_scene(str(ROOT / "mechanisms" / "double_pendulum.yaml"))
    system, state = assembled(scene)
    assert fastest_at(choose(system, state, scene.settings), system, state) == []
    assert (stable_steps([]), lines([], {})) == ({}, [])


@pytest.mark.parametrize("integrator", ["rk4", "dopri5", "dop853"])
def test_runs_are_stable_up_to_these_steps(integrator):
    """A spring that starts off its length by a millimetre, over 100 steps: `stable_slack` lets each grow by 1 %."""
    text = LINE.replace("stiffness: 1.0e6}", "stiffness: 1.0e6, free_length: 1.001}")
    step = stable_steps(found(text))[integrator]
    largest = []
    for h in (0.98 * step, 1.3 * step):
        scene = read_scene_text(text, "s.yaml", {}, {"integrator": integrator, "step": h, "duration": 100 * h})
        try:
            done = run_scene(scene)
            largest.append(float(np.abs(done["bodies/position"][:, 0, 0] - 1.0).max()))
        except SimulationError:
            largest.append(np.inf)
    assert largest[0] < 0.002 * 1.01**100
    assert largest[1] > 1.0
