"""Forces as generalised forces: virtual work, potentials, action and reaction, one law written differently."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess
from mbproj.base.errors import InputError, SimulationError
from mbproj.equations.constraints import set_jacobian
from mbproj.equations.forces import applied, generalised, law_state
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.scene.scene import read_scene_text
from tests.dynamics.force_scenes import FORCES, HEAD, ON_BODIES, reference

TIME = 0.8


def system_of(forces):
    scene = read_scene_text(HEAD + forces)
    system = compile_system(scene)
    return system, initial_guess(scene, system)


@pytest.fixture(scope="module")
def state():
    """A system with every kind of law, and a state with unit Euler parameters off its start."""
    system, _ = system_of(FORCES)
    rng = np.random.default_rng(4)
    q, v = rng.normal(size=(2, 7)), rng.normal(size=(2, 7))
    q[:, 3:] /= np.linalg.norm(q[:, 3:], axis=1, keepdims=True)
    v[:, 3:] -= np.sum(v[:, 3:] * q[:, 3:], axis=1, keepdims=True) * q[:, 3:]
    return system, q.ravel(), v.ravel()


def test_generalised_forces_do_virtual_work(state):
    """Q = Σ F (∂s/∂q)ᵀ but for what acts along Λ, which the norm row takes."""
    system, q, v = state
    pose = pose_of(q)
    twist = twist_of(pose, v)
    laws = law_state(Instant(system, pose, twist, TIME, reference(system, q)))
    loads = applied(Instant(system, pose, twist, TIME, reference(system, q)))
    Q = generalised(pose, loads.force, loads.torque).reshape(-1, 7)
    expected = (laws.force @ set_jacobian(system.forces.laws.coordinates, pose)).reshape(-1, 7)
    Λ = q.reshape(-1, 7)[:, 3:]
    expected[:, 3:] -= np.sum(expected[:, 3:] * Λ, axis=1, keepdims=True) * Λ
    np.testing.assert_allclose(Q, expected, atol=1e-12)
    np.testing.assert_allclose(laws.force @ laws.rate, Q.ravel() @ v, rtol=1e-12)
    assert loads.power - loads.dissipation == pytest.approx(laws.force @ laws.rate - laws.spring @ laws.rate, rel=1e-12)


def test_springs_pull_down_their_potential(state):
    """F_spring = -dV/ds, by the complex step through V(q)."""
    system, q, v = state
    pose = pose_of(q)
    laws = law_state(Instant(system, pose, twist_of(pose, v), TIME, reference(system, q)))
    force = laws.spring @ set_jacobian(system.forces.laws.coordinates, pose)
    h = 1e-6

    def potential(at):
        pose = pose_of(at)
        zero = twist_of(pose, np.zeros(14))
        return law_state(Instant(system, pose, zero, TIME, reference(system, q))).stored

    steps = h * np.eye(14)
    gradient = [(potential(q + step) - potential(q - step)) / (2 * h) for step in steps]
    np.testing.assert_allclose(-np.array(gradient), force, atol=1e-7)


def test_action_and_reaction(state):
    """The forces between bodies and ground add to nothing, and so do their moments about any point."""
    system, q, v = state
    pose = pose_of(q)
    loads = applied(Instant(system, pose, twist_of(pose, v), TIME, reference(system, q)))
    global_torque = (pose.rotation @ loads.torque[..., None])[..., 0]
    np.testing.assert_allclose(loads.force.sum(axis=0), 0.0, atol=1e-12)
    moments = global_torque + np.cross(pose.position, loads.force)
    np.testing.assert_allclose(moments.sum(axis=0), 0.0, atol=1e-12)
    assert np.abs(loads.force).max() > 1.0


def test_forces_and_torques_on_bodies():
    """Each as Newton says: the force in its axes, its moment about the centre of mass; power F·v + τ·ω."""
    system, guess = system_of(ON_BODIES)
    pose = pose_of(guess.q)
    v = np.random.default_rng(2).normal(size=14)
    twist = twist_of(pose, v)
    loads = applied(Instant(system, pose, twist, TIME, np.zeros(3)))
    A, B = pose.rotation[0], pose.rotation[1]
    fa, fb = np.array([1.0, -2 * TIME, 3.0]), B @ np.array([TIME, 0.0, 3.0])
    np.testing.assert_allclose(loads.force[0], fa, rtol=1e-14)
    np.testing.assert_allclose(loads.force[1], fb + np.array([5.0, 0.0, 3.0]), rtol=1e-14)
    arm_a, arm_b = np.array([1.0, 2.0, 3.0]) - [0.1, 0.2, 0.3], B @ np.array([0.1, 0.2, 0.3])
    torque_a = np.cross(arm_a, fa) + np.array([0.1, TIME**2, 3.0])
    np.testing.assert_allclose(loads.torque[0], A.T @ torque_a, atol=1e-13)
    np.testing.assert_allclose(loads.torque[1], B.T @ np.cross(arm_b, fb) + np.array([1.0, 0.0, 2.0]), atol=1e-13)
    Q = generalised(pose, loads.force, loads.torque)
    assert loads.power == pytest.approx(Q @ v, rel=1e-12)
    assert loads.dissipation == 0.0


SAME = [
    (
        "points: {a: [0, 0, 1], b: [1, 1, 0]}, stiffness: 30, damping: 2, free_length: 0.7",
        "points: {a: [0, 0, 1], b: [1, 1, 0]}, force: -30*(l - 0.7) - 2*l_dot",
    ),
    (
        "points: {a: [0, 0, 1], b: [1, 1, 0]}, stiffness: 30",
        "bodies: [b, a], locations: [[1, 1, 0], [0, 0, 1]], stiffness: 30 N/m, free_length: sqrt(3)",
    ),
    (
        "points: {a: [0, 0, 1], b: [1, 1, 0]}, stiffness: 30, damping: 2, free_length: 1",
        "points: {a: [0, 0, 1], b: [1, 1, 0]}, table: [[0, 30], [2, -30]], damping: 2",
    ),
    (
        "points: {a: [0, 0, 1], b: [1, 1, 0]}, stiffness: 30, free_length: 1",
        "points: {a: [0, 0, 1], b: [1, 1, 0]}, table: {rows: [[0, 30], [1, 0], [5, -120]], between: linear}",
    ),
]


@pytest.mark.parametrize(("one", "other"), SAME)
def test_the_same_law_written_differently(one, other):
    found = []
    for keys in (one, other):
        system, guess = system_of(f"  k: {{type: spring_damper, {keys}}}\n")
        q = guess.q + 0.05 * np.random.default_rng(3).normal(size=14)
        pose = pose_of(q)
        loads = applied(Instant(system, pose, twist_of(pose, np.ones(14)), TIME, np.zeros(3)))
        found.append(np.concatenate([loads.force, loads.torque]))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-11, atol=1e-11)


def test_angles_count_turns():
    """A torsion spring wound up by three turns pulls with three turns."""
    system, guess = system_of("  k: {type: torsion_spring_damper, joint: R, stiffness: 2}\n")
    pose = pose_of(guess.q)
    still = twist_of(pose, np.zeros(14))
    for turns in (0, 3, -2):
        about = np.array([2 * np.pi * turns + 0.4, 0.0, 0.0])
        torque = law_state(Instant(system, pose, still, 0.0, about)).force
        assert torque == pytest.approx(-2.0 * 2 * np.pi * turns, abs=1e-12)


def test_a_scene_without_forces_and_motions_has_none():
    system, _ = system_of("")
    assert (system.forces.is_empty, system.driven, system.names.forces, system.names.motions) == (True, 0, (), ())


def test_fixed_joints_carry_the_points_along():
    """A spring on a body that a fixed joint has made part of another acts at the same place."""
    scene = HEAD.replace(
        "  R: {type: revolute, bodies: [a, b], location: [0.4, 0, 0.1], axis: [1, 2, -1]}",
        "  F: {type: fixed, bodies: [a, b], location: [0, 0, 0]}",
    )
    spring = "  k: {type: spring_damper, points: {ground: [0, 0, -1], b: [1, 1, 0]}, stiffness: 30, free_length: 1}\n"
    loads = []
    for text in (scene + spring, scene + spring.replace("b: [1, 1", "a: [1, 1")):
        read = read_scene_text(text)
        system = compile_system(read)
        pose = pose_of(initial_guess(read, system).q)
        found = applied(Instant(system, pose, twist_of(pose, np.zeros(7)), 0.0, np.zeros(2)))
        loads.append(np.concatenate([found.force, found.torque]))
    np.testing.assert_allclose(loads[0], loads[1], atol=1e-12)


WRONG = {
    "k: {type: spring_damper, points: {a: [0, 0, 1], b: [0, 0, 1]}, stiffness: 1}": "11:3: error: force 'k' has no "
    "direction: its two points coincide at the scene's pose; move one of its points",
}


@pytest.mark.parametrize("line", WRONG)
def test_forces_that_cannot_be(line):
    with pytest.raises(InputError) as caught:
        compile_system(read_scene_text(f"{HEAD}  {line}\n", "f.yaml"))
    assert str(caught.value).splitlines()[0] == f"f.yaml:{WRONG[line]}"


def test_points_of_one_rigid_body():
    text = HEAD.replace("type: revolute", "type: fixed").replace(", axis: [1, 2, -1]", "")
    spring = "  k: {type: spring_damper, points: {a: [0, 0, 1], b: [0, 0, 2]}, stiffness: 1}\n"
    with pytest.raises(InputError, match="'k' acts between two points of one rigid body; fixed joints have merged"):
        compile_system(read_scene_text(text + spring))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            "k: {type: torsion_spring_damper, joint: R, torque: sqrt(0.1 - t)}",
            "stopped at t = 0.8 s at force 'k': 'sqrt(0.1 - t)' fails: sqrt(-0.7) is not finite; correct the "
            "expression, or end the run before that time",
        ),
        (
            "k: {type: force, body: a, force: [0, 1/(t - 0.8), 0]}",
            "stopped at t = 0.8 s at force 'k': '1/(t - 0.8)' fails: divide(1, 0) is not finite; correct the "
            "expression, or end the run before that time",
        ),
    ],
)
def test_expressions_that_fail_at_run_time(line, said):
    system, guess = system_of(f"  {line}\n")
    pose = pose_of(guess.q)
    with pytest.raises(SimulationError) as caught:
        applied(Instant(system, pose, twist_of(pose, np.zeros(14)), TIME, np.zeros(3)))
    assert str(caught.value) == said


def test_points_that_meet():
    points = "bodies: [ground, a], locations: {ground: [0, 0, 0], a: [0, 0, 0]}"
    system, guess = system_of(f"  k: {{type: spring_damper, {points}, damping: 1}}\n")
    meeting = pose_of(np.concatenate([np.zeros(3), guess.q[3:]]))
    with pytest.raises(SimulationError, match="at force 'k': its two points have met, and it has no direction"):
        applied(Instant(system, meeting, twist_of(meeting, np.ones(14)), 0.5, np.zeros(3)))


def test_assembly_does_not_see_forces():
    system, guess = system_of(FORCES)
    np.testing.assert_array_equal(assemble(system, guess).q, assemble(system_of("")[0], guess).q)
