"""The mass-orthogonal projection in the kernel (Eqs. 48-55): what a penalty α leaves, and its limit."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.arrays import Array
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.constraints import constraint
from mbproj.equations.kinematics import pose_of
from mbproj.model.euler_parameters import matrix_E, matrix_L
from tests.kernel.scenes import Case, loops, needs_kernel, opened, star, tree
from tests.kernel.tangent import tangent_jacobian

pytestmark = needs_kernel
BUILD = {"tree": lambda: tree(1), "loops": lambda: loops(2), "star": lambda: star(0, 4)}


@pytest.fixture(scope="module", params=BUILD)
def case(request) -> Case:
    """Open by so little that a correction is linear in the violation, to 1e-6 of it."""
    return opened(BUILD[request.param](), size=1e-6)


def shift(case: Case, **settings: object) -> Array:
    """(δr, δθ global) of each body by one correction of the position, (6n,)."""
    moved = case.reduced.equations(ProjectionSettings(**settings)).newton(case.y)
    before, after = case.y[:, 3:7], moved[:, 3:7]
    turned = 2.0 * (matrix_E(before) @ (after - before)[..., None])[..., 0]
    return np.concatenate([moved[:, :3] - case.y[:, :3], turned], axis=1).ravel()


@pytest.mark.parametrize("alpha", [1e-1, 1e1, 1e3, 1e5])
def test_a_correction_is_that_of_eq_52(case, alpha):
    """(M + α GᵀG) δ = -α Gᵀ C."""
    system, Λ = case.system, case.y[:, 3:7]
    G = tangent_jacobian(system, case.q).reshape(-1, 6 * system.bodies)
    A = matrix_E(Λ) @ np.swapaxes(matrix_L(Λ), -1, -2)
    M = np.zeros((system.bodies, 6, system.bodies, 6))
    index = np.arange(system.bodies)
    M[index, :3, index, :3] = system.mass[:, None, None] * np.eye(3)
    M[index, 3:, index, 3:] = A @ system.inertia @ np.swapaxes(A, -1, -2)
    C = constraint(system, pose_of(case.q))[system.bodies :]
    expected = np.linalg.solve(M.reshape(len(G.T), -1) + alpha * G.T @ G, -alpha * G.T @ C)
    found = shift(case, method="mass-orthogonal", alpha=alpha)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())


def test_with_the_penalty_it_tends_to_gpopm(case):
    """By 1/α: ten times the penalty, a tenth of the difference."""
    limit = shift(case, method="gpopm")
    off = [
        np.linalg.norm(shift(case, method="mass-orthogonal", alpha=alpha) - limit) / np.linalg.norm(limit)
        for alpha in (1e4, 1e5, 1e6)
    ]
    assert off[0] < 1e-1
    assert off[0] / off[1] == pytest.approx(10.0, rel=0.1)
    assert off[1] / off[2] == pytest.approx(10.0, rel=0.1)


def test_iterated_it_closes_what_gpopm_closes(case):
    """Positions and velocities, for α = 1e7 kg in masses of about 1 kg."""
    soft, limit = (
        case.reduced.equations(ProjectionSettings(method=method, alpha=alpha)).corrected(case.y)
        for method, alpha in (("mass-orthogonal", 1e7), ("gpopm", None))
    )
    equations = case.reduced.equations()
    fastest = np.abs(limit[:, 7:]).max()
    assert np.abs(equations.constraint(soft)).max() <= 1e-13
    assert np.abs(equations.constraint_velocity(soft)).max() <= 1e-13 * fastest
    np.testing.assert_allclose(soft, limit, rtol=0, atol=1e-6 * fastest)
