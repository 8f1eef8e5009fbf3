"""C, C_q, C', γ, M, Q and the accelerations: against the complex step, the energy, and Lagrange's equations."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import (
    constraint,
    constraint_acceleration,
    constraint_at,
    constraint_velocity_at,
    gamma,
    jacobian,
    set_jacobian,
    set_velocity,
)
from mbproj.equations.energy import kinetic_energy, potential_energy
from mbproj.equations.kinematics import attached, pose_of, slots_of, twist_of
from mbproj.equations.motions import drive_at
from mbproj.equations.of_motion import SOLVERS, generalised_force, mass_matrix
from mbproj.equations.turning import Teeth, sums_at_start
from mbproj.joints.table import JOINTS
from mbproj.linear.equilibrium.start import start_state
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.scene import read_scene
from tests.support import ROOT, random_chain

# C, C_q, C' and γ against the complex step, for every joint, at states that violate everything (|Λ| ≠ 1).

STEP = 1e-30


@pytest.fixture(params=sorted(JOINTS), scope="module")
def kind(request):
    return request.param


@pytest.fixture(scope="module")
def mechanism(kind):
    """A system of three bodies on joints of one type, and a random state of it."""
    system = compile_system(random_chain(3, [kind] * 3))
    rng = np.random.default_rng(11)
    return system, rng.normal(size=21), rng.normal(size=21)


def test_joints_are_closed_at_the_pose_of_the_scene(kind):
    scene = random_chain(3, [kind] * 3)
    system = compile_system(scene)
    assert np.abs(constraint_at(system, initial_guess(scene, system).q)).max() < 1e-14


def test_number_of_rows(mechanism):
    system, q, v = mechanism
    pose = pose_of(q)
    assert constraint_at(system, q).shape == (system.constraints,)
    assert jacobian(system, pose).shape == (system.constraints, 21)
    assert gamma(system, pose, twist_of(pose, v)).shape == (system.constraints,)


def test_jacobian_is_the_derivative_of_C(mechanism):
    system, q, _ = mechanism
    columns = [constraint_at(system, q + 1j * STEP * direction).imag / STEP for direction in np.eye(21)]
    found, level = jacobian(system, pose_of(q)), system.is_velocity
    np.testing.assert_allclose(found[~level], np.transpose(columns)[~level], rtol=1e-12, atol=1e-12)
    assert not np.any(columns, axis=0)[level].any()  # of no function: see test_integrable


def test_velocity_of_C_is_the_jacobian_times_v(mechanism):
    system, q, v = mechanism
    np.testing.assert_allclose(
        constraint_velocity_at(system, q, v), jacobian(system, pose_of(q)) @ v, rtol=1e-12, atol=1e-12
    )


def test_gamma_is_minus_the_derivative_of_the_velocity_along_the_motion(mechanism):
    """Eq. 8: γ = -(C_q q')_q q'."""
    system, q, v = mechanism
    pose = pose_of(q)
    derivative = constraint_velocity_at(system, q + 1j * STEP * v, v).imag / STEP
    np.testing.assert_allclose(gamma(system, pose, twist_of(pose, v)), -derivative, rtol=1e-11, atol=1e-11)


def test_joint_coordinates_have_the_same_derivatives(mechanism):
    system, q, v = mechanism
    bound = system.coordinates

    def value(at):
        return bound.value(attached(pose_of(at), *slots_of(bound)))

    pose = pose_of(q)
    columns = [value(q + 1j * STEP * direction).imag / STEP for direction in np.eye(21)]
    expected = np.transpose(columns).reshape(bound.size, 21)
    np.testing.assert_allclose(set_jacobian(bound, pose), expected, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(set_velocity(bound, pose, twist_of(pose, v)), expected @ v, rtol=1e-11, atol=1e-11)


def test_acceleration_of_C_is_the_derivative_of_its_velocity(mechanism):
    """d/dt of C' along q' = v, v' = a by the complex step."""
    system, q, v = mechanism
    a = np.random.default_rng(12).normal(size=21)
    rate = constraint_velocity_at(system, q + 1j * STEP * v, v + 1j * STEP * a).imag / STEP
    pose = pose_of(q)
    found = constraint_acceleration(system, pose, twist_of(pose, v), twist_of(pose, a))
    np.testing.assert_allclose(found, rate, rtol=1e-11, atol=1e-11)


def test_samples_in_time_are_a_leading_axis(mechanism):
    system, q, v = mechanism
    many = constraint_velocity_at(system, np.stack([q, v]), np.stack([v, q]))
    for found, alone in zip(
        many, (constraint_velocity_at(system, q, v), constraint_velocity_at(system, v, q)), strict=True
    ):
        np.testing.assert_allclose(found, alone, rtol=1e-13, atol=1e-14)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["geneva", "screw_press"])
def test_rows_in_mesh_have_the_derivatives_of_the_nearest_teeth(name):
    """The teeth in mesh are whole numbers, which a complex step leaves as they are."""
    scene = read_scene(ROOT / f"mechanisms/{name}.yaml")
    system = compile_system(scene)
    q = start_state(scene, system).q
    along = np.random.default_rng(5).normal(size=len(q))
    coordinate = system.coordinates.value(attached(pose_of(q), *slots_of(system.coordinates)))
    teeth = Teeth(sums_at_start(system, pose_of(q), coordinate), coordinate)
    C = constraint(system, pose_of(q + 1j * STEP * along), drive_at(system, 0.0, teeth))
    assert system.couplings.size > 0
    np.testing.assert_allclose(C.imag / STEP, jacobian(system, pose_of(q)) @ along, rtol=0.0, atol=1e-12)


def test_joints_do_not_see_a_rigid_motion_of_everything(kind):
    """The bodies turned and shifted together, open joints included: each joint's |C| stays (the ground's left out)."""
    scene = random_chain(5, [kind] * 3)
    system = compile_system(scene)
    q = initial_guess(scene, system).q + 0.1 * np.random.default_rng(2).normal(size=21)

    def openings(at):
        rows = constraint_at(system, at)[system.bodies :]
        return [np.linalg.norm(rows[system.joints.owner == joint]) for joint in (1, 2)]

    np.testing.assert_allclose(openings(_moved(q)), openings(q), rtol=1e-13)


def _moved(q):
    """q of a quarter turn about z and a shift: Λ -> p Λ with p = (cos 45°, 0, 0, sin 45°)."""
    half = np.sqrt(0.5)
    turn = np.array([[half, 0, 0, -half], [0, half, -half, 0], [0, half, half, 0], [half, 0, 0, half]])
    rows = q.reshape(-1, 7).copy()
    x, y, z = rows[:, :3].T
    rows[:, :3] = np.stack([-y + 1.0, x + 2.0, z + 3.0], axis=1)
    rows[:, 3:] = rows[:, 3:] @ turn.T
    return rows.ravel()


# M, Q and the accelerations: against the energy, against Lagrange's equations, Eq. 14 against Eqs. 80-81.

KINDS = ["revolute", "universal", "prismatic", "spherical"]


@pytest.fixture
def system():
    return compile_system(random_chain(1, KINDS))


@pytest.fixture
def state(system):
    rng = np.random.default_rng(4)
    return rng.normal(size=(2, 7 * system.bodies))


def test_mass_matrix_gives_the_kinetic_energy(system, state):
    q, v = state
    pose = pose_of(q)
    assert 0.5 * v @ mass_matrix(system, pose) @ v == pytest.approx(kinetic_energy(system, pose, twist_of(pose, v)))


def test_mass_matrix_is_singular_of_rank_six_a_body(system, state):
    M = mass_matrix(system, pose_of(state[0]))
    np.testing.assert_allclose(M, M.T, atol=1e-15 * np.abs(M).max())
    assert np.linalg.matrix_rank(M) == 6 * system.bodies


def test_forces_are_those_of_lagranges_equations(system, state):
    """d/dt ∂T/∂q' - ∂T/∂q + ∂V/∂q = M q'' - Q, at states with |Λ| ≠ 1: Q = -M' q' + ∂T/∂q - ∂V/∂q."""
    q, v = state

    def lagrangian(at):
        pose = pose_of(at)
        return kinetic_energy(system, pose, twist_of(pose, v)) - potential_energy(system, pose)

    momentum_rate = mass_matrix(system, pose_of(q + 1j * STEP * v)).imag / STEP @ v
    gradient = np.array([lagrangian(q + 1j * STEP * e).imag / STEP for e in np.eye(len(q))])
    pose = pose_of(q)
    np.testing.assert_allclose(
        generalised_force(system, pose, twist_of(pose, v)), gradient - momentum_rate, rtol=1e-12, atol=1e-12
    )


@pytest.mark.parametrize("name", sorted(SOLVERS))
def test_accelerations_satisfy_both_equations(system, state, name):
    q, v = state
    pose = pose_of(q)
    twist = twist_of(pose, v)
    M, C_q = mass_matrix(system, pose), jacobian(system, pose)
    Q, rhs = generalised_force(system, pose, twist), gamma(system, pose, twist)
    acceleration, multipliers = SOLVERS[name](M, C_q, Q, rhs)
    np.testing.assert_allclose(M @ acceleration + C_q.T @ multipliers, Q, atol=1e-10 * np.abs(Q).max())
    np.testing.assert_allclose(C_q @ acceleration, rhs, atol=1e-10 * np.abs(rhs).max())


def test_bordered_and_eliminated_accelerations_agree(system, state):
    """Eq. 14 against Eqs. 80 and 81, multipliers included."""
    q, v = state
    pose = pose_of(q)
    twist = twist_of(pose, v)
    arguments = (
        mass_matrix(system, pose),
        jacobian(system, pose),
        generalised_force(system, pose, twist),
        gamma(system, pose, twist),
    )
    bordered, eliminated = (SOLVERS[name](*arguments) for name in ("bordered", "eliminated"))
    for one, other in zip(bordered, eliminated, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(one).max())


def test_second_derivative_of_the_constraints_is_zero_along_the_motion(system, state):
    q, v = state
    pose = pose_of(q)
    twist = twist_of(pose, v)
    acceleration, _ = SOLVERS["bordered"](
        mass_matrix(system, pose),
        jacobian(system, pose),
        generalised_force(system, pose, twist),
        gamma(system, pose, twist),
    )
    second = constraint_velocity_at(system, q + 1j * STEP * v, v + 1j * STEP * acceleration).imag / STEP
    assert np.abs(second).max() < 1e-10 * np.abs(acceleration).max()
