"""At states with |Λ| = 1 and ΛᵀΛ' = 0, joints open, the formulations are one: design, section 3."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.arrays import Array
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.constraints import constraint, constraint_velocity, gamma, jacobian
from mbproj.equations.forces import applied, generalised
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.of_motion import SOLVERS, generalised_force, mass_matrix
from mbproj.model.euler_parameters import matrix_E, matrix_L
from mbproj.model.system import System
from mbproj.motion.formulations.reduced import space_acceleration
from mbproj.motion.projection import make_method
from tests.kernel.scenes import SCENES, needs_kernel, opened
from tests.kernel.tangent import tangent_jacobian

pytestmark = needs_kernel

#: What round-off may be, times the condition of S = G W⁻¹ Gᵀ; the design allows a hundred times more.
ROUND_OFF = 1e-13
METHODS = ["gopm", "gpopm"]


@pytest.fixture(scope="module", params=SCENES)
def case(request):
    return opened(SCENES[request.param]())


def condition(system: System, q: Array, *, mass: bool = True) -> float:
    """The condition of S with the masses, or the coordinates, as weights."""
    Λ = q.reshape(-1, 7)[:, 3:]
    A = matrix_E(Λ) @ np.swapaxes(matrix_L(Λ), -1, -2)
    G = tangent_jacobian(system, q)
    weights = np.zeros((system.bodies, 6, 6))
    weights[:, :3, :3] = np.eye(3) * (system.mass[:, None, None] if mass else 1.0)
    weights[:, 3:, 3:] = A @ system.inertia @ np.swapaxes(A, -1, -2) if mass else 0.25 * np.eye(3)
    return float(np.linalg.cond(np.einsum("mni,nij,knj->mk", G, np.linalg.inv(weights), G))) if len(G) else 1.0


def assert_equal(found: Array, expected: Array, condition: float) -> None:
    """To round-off times the condition, relative to the largest number."""
    size = max(1.0, np.abs(expected).max(initial=0.0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUND_OFF * max(1.0, condition) * size)


def test_constraints_and_their_derivatives(case):
    """C, C', γ and G of the kernel's own primitives are those of mbproj.joints.primitives.table."""
    system, n = case.system, case.system.bodies
    pose, equations = pose_of(case.q), case.reduced.equations()
    twist = twist_of(pose, case.v)
    at, rate = (part.reshape(-1, 7).copy() for part in (case.q, case.v))
    at[:, :3], at[:, 3:] = 0.0, -np.sum(rate[:, 3:] ** 2, axis=1, keepdims=True) * at[:, 3:]  # Λ'' without ω'
    for found, expected in (
        (equations.constraint(case.y), constraint(system, pose)[n:]),
        (equations.constraint_velocity(case.y), constraint_velocity(system, pose, twist)[n:]),
        (equations.gamma(case.y), (gamma(system, pose, twist) - jacobian(system, pose) @ at.ravel())[n:]),
        (equations.jacobian(case.y), tangent_jacobian(system, case.q)),
    ):
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * max(1.0, np.abs(expected).max(initial=0.0)))
    if system.at_positions.joints.size:
        assert np.abs(equations.constraint(case.y)).max() > 1e-4 * system.length  # open indeed


def test_accelerations_and_multipliers_are_those_of_the_full_equations(case):
    system, q, v = case.system, case.q, case.v
    pose = pose_of(q)
    twist = twist_of(pose, v)
    force = generalised_force(system, pose, twist)
    if not system.forces.is_empty:
        loads = applied(Instant(system, pose, twist, 0.0, coordinate_values(system, pose)))
        force = force + generalised(pose, loads.force, loads.torque)
    expected, multipliers = SOLVERS["bordered"](
        mass_matrix(system, pose), jacobian(system, pose), force, gamma(system, pose, twist)
    )
    acceleration, own = case.reduced.equations().accelerations(case.y)
    number = condition(system, q)
    assert number < 1e8
    assert_equal(space_acceleration(case.y[None], acceleration[None])[0], expected, number)
    assert_equal(own, multipliers[system.bodies :], number)


def test_smallest_multipliers_of_many_states_are_those_of_each(case):
    """To the bit, whatever stands before; where no row is redundant they are the multipliers, and not numbers where the
    accelerations are not unique, as where all bodies have come to one point."""
    equations, there = case.reduced.equations(), coordinate_values(case.system, pose_of(case.q))
    states, places = np.stack([np.zeros_like(case.y), case.y]), np.stack([there] * 2)
    nowhere, found = equations.smallest_multipliers(states, np.zeros(2), places)
    (alone,) = equations.smallest_multipliers(states[1:], np.zeros(1), places[1:])
    np.testing.assert_array_equal(found, alone)
    if not case.reduced.model.rows.redundant:
        np.testing.assert_array_equal(found, equations.accelerations(case.y, 0.0, there.tolist())[1])
    if equations.accelerations(states[0], 0.0, there.tolist()) is None:
        assert np.isnan(nowhere).all()


@pytest.mark.parametrize("name", METHODS)
def test_one_exact_newton_correction_is_that_of_the_full_equations(case, name):
    """Δr, and Λ + ΔΛ normalised: ΔΛ of the full correction has no radial part where |Λ| = 1. Velocities stay."""
    system, q = case.system, case.q
    settings, pose = ProjectionSettings(method=name), pose_of(q)
    change = make_method(settings).correction(
        mass_matrix(system, pose), jacobian(system, pose), constraint(system, pose)
    )
    expected = (q + change).reshape(-1, 7)
    expected[:, 3:] /= np.linalg.norm(expected[:, 3:], axis=1, keepdims=True)
    moved = case.reduced.equations(settings).newton(case.y)
    number = condition(system, q, mass=name == "gpopm")
    assert_equal(moved[:, :7], expected, number)
    np.testing.assert_array_equal(moved[:, 7:], case.y[:, 7:])
    if system.at_positions.joints.size:
        assert np.abs(change).max() > 1e-4 * system.length


@pytest.mark.parametrize("name", METHODS)
def test_the_correction_closes_joints_and_velocities(case, name):
    """To the default tolerance, which is 1e-13 for coordinates below 100, even from joints that are wide open; a
    second correction finds nothing to do."""
    equations = case.reduced.equations(ProjectionSettings(method=name))
    closed = equations.corrected(case.y)
    assert np.abs(case.q).max() < 100.0
    assert np.abs(equations.constraint(closed)).max(initial=0.0) <= 1e-13
    fastest = max(1.0, np.abs(closed[:, 7:]).max())
    assert np.abs(equations.constraint_velocity(closed)).max(initial=0.0) <= 1e-13 * fastest
    np.testing.assert_array_equal(equations.corrected(closed)[:, :3], closed[:, :3])


def test_eq_75_popm_is_gpopm_bit_for_bit(case):
    """M₆ is definite: the two methods of the paper are one."""
    results = [
        case.reduced.equations(ProjectionSettings(method=name)).corrected(case.y).tobytes()
        for name in ("popm", "gpopm")
    ]
    assert results[0] == results[1]
