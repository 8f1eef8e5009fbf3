"""The corrections as mathematics, the stop tests, and when a projection takes place."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at, constraint_velocity_at, jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.of_motion import mass_matrix
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.projection import Projection, make_method, project_after, row_tolerances
from tests.support import random_body, random_chain, scene_of

# The corrections as mathematics: they close the linearised constraints, and are the smallest in their metric.

OPTIONS = {"alpha": 1e7, "gains": (25.0, 25.0)}
CORRECTING = sorted(name for name, entry in PROJECTIONS.items() if entry.corrects)
#: Methods that work where M is singular, and whose correction is exact in one pass.
EXACT = [name for name in CORRECTING if name not in ("popm", "mass-orthogonal")]


def method(name: str, **options):
    chosen = {key: (OPTIONS | options)[key] for key in PROJECTIONS[name].options}
    return make_method(ProjectionSettings(method=name, **chosen))


@pytest.fixture
def singular():
    """M and C_q of a mechanism with Euler parameters at a pose that is open, and a violation."""
    system = compile_system(random_chain(6, ["revolute", "spherical", "universal", "prismatic"]))
    rng = np.random.default_rng(5)
    pose = pose_of(rng.normal(size=28))
    return mass_matrix(system, pose), jacobian(system, pose), rng.normal(size=system.constraints)


@pytest.fixture
def definite():
    """A random positive definite M, a random full-rank C_q, and a violation."""
    rng = np.random.default_rng(9)
    root = rng.normal(size=(12, 12))
    return root @ root.T + 0.1 * np.eye(12), rng.normal(size=(7, 12)), rng.normal(size=7)


def null_space(C_q):
    return np.linalg.svd(C_q)[2][len(C_q) :].T


@pytest.mark.parametrize("name", EXACT)
def test_correction_removes_the_violation_in_one_pass(name, singular):
    M, C_q, violation = singular
    np.testing.assert_allclose(C_q @ method(name).correction(M, C_q, violation), -violation, atol=1e-9)


def test_gopm_is_the_shortest_correction(singular):
    """Eq. 37: Δ has no part in the null space of C_q."""
    M, C_q, violation = singular
    change = method("gopm").correction(M, C_q, violation)
    assert np.abs(null_space(C_q).T @ change).max() < 1e-12 * np.abs(change).max()


@pytest.mark.parametrize("name", ["gpopm", "gpopm-pinv", "mmopm"])
def test_physical_corrections_are_the_smallest_in_energy(name, singular):
    """Eq. 43: M Δ has no part in the null space of C_q, though M is singular."""
    M, C_q, violation = singular
    change = method(name).correction(M, C_q, violation)
    bound = 1e-10 if name != "mmopm" else 1e-6  # the round-off of the large penalty
    assert np.abs(null_space(C_q).T @ M @ change).max() < bound * np.abs(M @ change).max()


def test_pseudo_inverse_and_block_inverse_are_the_same_method(singular):
    """Eqs. 65-66 against Eqs. 73-74."""
    block, pseudo = (method(name).correction(*singular) for name in ("gpopm", "gpopm-pinv"))
    np.testing.assert_allclose(pseudo, block, rtol=1e-9, atol=1e-10 * np.abs(block).max())


def test_popm_equals_gpopm_where_M_is_definite(definite):
    """Eq. 75."""
    physical, generalised = (method(name).correction(*definite) for name in ("popm", "gpopm"))
    np.testing.assert_allclose(generalised, physical, rtol=1e-11, atol=1e-12)


def test_popm_is_the_smallest_in_energy_where_M_is_definite(definite):
    """Eqs. 43 and 44."""
    M, C_q, violation = definite
    change = method("popm").correction(M, C_q, violation)
    np.testing.assert_allclose(C_q @ change, -violation, atol=1e-12)
    np.testing.assert_allclose(null_space(C_q).T @ M @ change, 0.0, atol=1e-12)
    assert method("popm").refusal(M) is None


def test_popm_is_refused_where_M_is_singular(singular):
    reason = method("popm").refusal(singular[0])
    assert reason.startswith("'popm' needs a positive definite mass matrix")
    assert "use 'gpopm'" in reason


@pytest.mark.parametrize("alpha", [1e-2, 1e0, 1e2, 1e4])
def test_mmopm_does_not_depend_on_alpha(alpha, singular):
    """Eq. 78, up to the round-off that grows with α."""
    expected = method("gpopm").correction(*singular)
    change = method("mmopm", alpha=alpha).correction(*singular)
    np.testing.assert_allclose(change, expected, atol=1e-10 * max(alpha, 1.0) ** 0.5 * np.abs(expected).max())


def test_inverse_matrices_lose_digits_with_alpha_and_solves_do_not(singular):
    """Eq. 61 as it is printed, with inverses: what is left of the violation grows with α. With solves it does not."""
    M, C_q, violation = singular
    left = []
    for alpha in (1e2, 1e10):
        inverse = np.linalg.inv(M + alpha * C_q.T @ C_q)
        printed = -inverse @ C_q.T @ np.linalg.inv(C_q @ inverse @ C_q.T) @ violation
        solved = method("mmopm", alpha=alpha).correction(*singular)
        left.append([np.abs(C_q @ change + violation).max() for change in (printed, solved)])
    (few, solved_few), (many, solved_many) = left
    assert many > 1e4 * few
    assert max(solved_few, solved_many) < 1e-10


def test_mass_orthogonal_leaves_a_part_of_order_one_over_alpha(definite):
    """Eq. 52: halving 1/α halves what is left, and what is corrected tends to the physical correction."""
    M, C_q, violation = definite
    left = [
        np.linalg.norm(C_q @ method("mass-orthogonal", alpha=alpha).correction(M, C_q, violation) + violation)
        for alpha in (1e4, 2e4)
    ]
    assert left[0] / left[1] == pytest.approx(2.0, rel=0.01)
    change = method("mass-orthogonal", alpha=1e9).correction(M, C_q, violation)
    np.testing.assert_allclose(change, method("popm").correction(M, C_q, violation), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("name", EXACT)
def test_correcting_twice_corrects_once(name, singular):
    """The map v -> v + correction(C_q v) is a projector: idempotent, and the identity on admissible velocities."""
    M, C_q, _ = singular
    chosen = method(name)
    v = np.random.default_rng(0).normal(size=len(M))
    once = v + chosen.correction(M, C_q, C_q @ v)
    np.testing.assert_allclose(once + chosen.correction(M, C_q, C_q @ once), once, atol=1e-8)


def test_gpopm_does_not_depend_on_the_unit_of_length_but_gopm_does():
    """Millimetres instead of metres: the physical correction is the same motion, the geometrical one is not."""
    scene = random_chain(6, ["revolute", "spherical"])
    changes = {}
    for unit in (1.0, 1000.0):
        scaled = dataclasses.replace(
            scene,
            bodies=tuple(
                dataclasses.replace(
                    body,
                    position=tuple(unit * x for x in body.position),
                    inertia=tuple(tuple(unit**2 * x for x in row) for row in body.inertia),
                )
                for body in scene.bodies
            ),
            joints=tuple(
                dataclasses.replace(
                    joint,
                    points=dataclasses.replace(
                        joint.points,
                        first=tuple(unit * x for x in joint.points.first),
                        second=tuple(unit * x for x in joint.points.second),
                    ),
                )
                for joint in scene.joints
            ),
        )
        system = compile_system(scaled)
        rng = np.random.default_rng(3)
        q = np.hstack(
            [
                np.array([body.position for body in scaled.bodies]),
                np.array([body.orientation for body in scaled.bodies]),
            ]
        )
        pose = pose_of(q.ravel())
        violation = rng.normal(size=system.constraints)
        violation[system.bodies :][system.joints.is_length] *= unit
        for name in ("gopm", "gpopm"):
            change = method(name).correction(mass_matrix(system, pose), jacobian(system, pose), violation)
            rows = change.reshape(-1, 7)
            rows[:, :3] /= unit
            changes[name, unit] = rows
    size = np.abs(changes["gpopm", 1.0]).max()
    np.testing.assert_allclose(changes["gpopm", 1000.0], changes["gpopm", 1.0], atol=1e-8 * size)
    assert np.abs(changes["gopm", 1000.0] - changes["gopm", 1.0]).max() > 1e-2 * size


@pytest.mark.parametrize("name", sorted(set(PROJECTIONS) - {"baumgarte"}))
def test_accelerations_are_not_touched(name):
    chosen = method(name)
    rhs = np.array([1.0, 2.0])
    np.testing.assert_array_equal(chosen.stabilised(rhs, rhs, rhs), rhs)
    assert isinstance(chosen, Projection) == PROJECTIONS[name].corrects


def test_baumgarte_adds_its_terms_to_gamma():
    """C'' = C_q q'' - γ, so that C'' + 2αC' + β²C = 0 is γ - 2αC' - β²C."""
    gamma, C, C_dot = np.array([1.0]), np.array([0.01]), np.array([0.1])
    assert method("baumgarte", gains=(25.0, 10.0)).stabilised(gamma, C, C_dot)[0] == pytest.approx(1 - 5 - 1)


# The stop tests, and when a projection takes place.

METHODS = [name for name, entry in PROJECTIONS.items() if entry.corrects and name != "popm"]


@pytest.fixture
def open_state():
    """A mechanism open by about 1e-4, moving apart at about 1e-2."""
    scene = random_chain(6, ["revolute", "spherical", "universal", "prismatic"])
    system = compile_system(scene)
    guess = initial_guess(scene, system)
    rng = np.random.default_rng(1)
    return system, guess.q + 1e-4 * rng.normal(size=28), guess.v


def projected(state, step: int = 1, **keys):
    system, q, v = state
    method = keys.setdefault("method", "gpopm")
    settings = ProjectionSettings(**keys, alpha=1e7 if "alpha" in PROJECTIONS[method].options else None)
    return project_after(step, system, make_method(settings), settings, q, v)


@pytest.mark.parametrize("name", METHODS)
def test_violation_test_closes_to_its_tolerance(name, open_state):
    system = open_state[0]
    result = projected(open_state, method=name)
    assert np.abs(constraint_at(system, result.q)).max() <= 1e-13
    assert np.abs(constraint_velocity_at(system, result.q, result.v)).max() <= 1e-13
    assert 1 <= result.position_iterations <= 4
    assert result.failures == 0


@pytest.mark.parametrize("name", METHODS)
def test_velocity_takes_one_step_but_for_the_penalty_method(name, open_state):
    """Eq. 46."""
    result = projected(open_state, method=name)
    assert (result.velocity_iterations == 1) == (name != "mass-orthogonal")


@pytest.mark.parametrize("name", METHODS)
def test_the_papers_test_stops_when_the_correction_is_small_in_energy(name, open_state):
    """Quadratic convergence: ΔqᵀMΔq <= 1e-12 is a Δq of 1e-6, and what it leaves is of its square."""
    system = open_state[0]
    result = projected(open_state, method=name, test="paper")
    assert result.position_iterations >= 1
    assert np.abs(constraint_at(system, result.q)).max() <= 1e-11


def test_the_papers_test_sees_the_lengths_of_euler_parameters():
    """A change of |Λ| of a free body has no energy, ΔqᵀMΔq = 0: only CᵀC tells that the first pass leaves |Λ| off."""
    scene = scene_of([random_body(np.random.default_rng(2), "a")], [])
    system = compile_system(scene)
    q = initial_guess(scene, system).q.copy()
    q[3:] *= 1.1
    result = projected((system, q, np.zeros(7)), test="paper")
    assert np.abs(constraint_at(system, result.q)).max() <= 1e-11
    assert result.position_iterations > 1


def test_looser_tolerances_take_fewer_iterations(open_state):
    tight, loose = (projected(open_state, tolerance=tolerance) for tolerance in (1e-13, 1e-6))
    assert loose.position_iterations < tight.position_iterations
    assert np.abs(constraint_at(open_state[0], loose.q)).max() <= 1e-6


def test_a_tolerance_below_round_off_ends_at_round_off(open_state):
    result = projected(open_state, tolerance=1e-19)
    assert result.failures == 0
    assert result.position_iterations < 10
    assert np.abs(constraint_at(open_state[0], result.q)).max() <= 1e-14


def test_every_k_th_step(open_state):
    projections = [projected(open_state, step=step, every=3).projections for step in range(1, 8)]
    assert projections == [0, 0, 1, 0, 0, 1, 0]


def test_threshold(open_state):
    system, q, v = open_state
    largest = float(np.abs(constraint_at(system, q)).max())
    moving = float(np.abs(constraint_velocity_at(system, q, v)).max())
    above = projected(open_state, threshold=2.0 * max(largest, moving))
    assert above.projections == 0
    np.testing.assert_array_equal(above.q, q)
    assert projected(open_state, threshold=0.5 * largest).position_iterations >= 1


def test_levels_are_switched_separately(open_state):
    system, q, v = open_state
    positions = projected(open_state, velocity=False)
    np.testing.assert_array_equal(positions.v, v)
    assert np.abs(constraint_at(system, positions.q)).max() <= 1e-13
    velocities = projected(open_state, position=False)
    np.testing.assert_array_equal(velocities.q, q)
    assert np.abs(constraint_velocity_at(system, q, velocities.v)).max() <= 1e-13


def test_default_tolerance_grows_with_the_largest_coordinate():
    """max(1e-13, 4 ε × the largest coordinate in the row)."""
    scene = random_chain(6, ["spherical"])
    system = compile_system(scene)
    q = initial_guess(scene, system).q
    q[0] = 1e6
    tolerances = row_tolerances(system, ProjectionSettings(), pose_of(q))
    assert tolerances[0] == 1e-13
    np.testing.assert_allclose(tolerances[1:], 4 * np.finfo(float).eps * 1e6, rtol=1e-4)
