"""M, Q and the accelerations: against the energy, against Lagrange's equations, Eq. 14 against Eqs. 80-81."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_velocity_at, gamma, jacobian
from mbproj.equations.energy import kinetic_energy, potential_energy
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.of_motion import SOLVERS, generalised_force, mass_matrix
from tests.support import random_chain

STEP = 1e-30
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
