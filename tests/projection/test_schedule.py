"""The stop tests, and when a projection takes place."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at, constraint_velocity_at
from mbproj.equations.kinematics import pose_of
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.projection import make_method, project_after, row_tolerances
from tests.support import random_body, random_chain, scene_of

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
