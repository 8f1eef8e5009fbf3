"""Where bodies are asked for turns that the linearised rows promise too much of: the corrections are damped."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from mbproj.dynamics import RowSet, constraint_at, jacobian, mass_matrix, pose_of
from mbproj.integrate import InPlane, Reduced
from mbproj.kernel import core
from mbproj.projection import make_method
from mbproj.projection.solve import correct_position, damped
from mbproj.registry import PROJECTIONS
from mbproj.thresholds import THRESHOLDS
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.projection.uneven_chains import suited, uneven_chain

#: With Euler parameters M is singular, so that popm is no method of the full formulation.
METHODS = [name for name, entry in PROJECTIONS.items() if entry.corrects and name != "popm"]
COMPILED = [name for name, entry in PROJECTIONS.items() if entry.corrects and entry.compiled]
#: Random poses by seed: of the second, Newton's method without damping fails from a mass ratio of 1e4 on.
EASY, HARD = (0, 1, 3), (28, 49, 54, 80, 88, 95)
ONE_HARD = [HARD[0], *map(full, HARD[1:])]
SEEDS = [pytest.param((EASY[0], HARD[0]), id="few"), full((*EASY[1:], *HARD[1:]), id="many")]
RATIOS = (1.0, 1e4, 1e8, 1e12)


def closed(method: str, ratio: float, seed: int):
    """The chain's projection and what it leaves open."""
    system, _, q = uneven_chain(ratio, seed)
    settings = suited(method, ratio)
    found = correct_position(system, make_method(settings), settings, RowSet.regular(system), q)
    return found, np.abs(constraint_at(system, found.q)).max()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("seeds", SEEDS)
def test_every_method_closes_uneven_chains(method, ratio, seeds):
    """Few passes do: every one brings the violation down by half at least, and by its square at last."""
    for seed in seeds:
        found, violation = closed(method, ratio, seed)
        assert found.met, seed
        assert violation <= 1e-13
        assert found.passes <= 12


@pytest.mark.parametrize("method", ["mass-orthogonal", "mmopm", "gpopm", "gpopm-pinv"])
@pytest.mark.parametrize("seed", ONE_HARD)
def test_newtons_method_alone_does_not_close_them(method, seed):
    """In the metrics by masses; so that the test above needs the damping."""
    ratio = 1e8
    system, _, q = uneven_chain(ratio, seed)
    for _ in range(25):
        pose = pose_of(q)
        C, C_q = constraint_at(system, q), jacobian(system, pose)
        q = q + make_method(suited(method, ratio)).correction(mass_matrix(system, pose), C_q, C)
    assert not np.abs(constraint_at(system, q)).max() < 1e-6


@needs_kernel
@pytest.mark.parametrize("method", COMPILED)
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("seeds", SEEDS)
def test_the_kernel_closes_uneven_chains(method, ratio, seeds):
    for seed in seeds:
        system, plane, q = uneven_chain(ratio, seed)
        for coordinates in (Reduced(core(), system), InPlane(core(), system, plane)):
            equations = coordinates.equations(suited(method, ratio))
            closed = equations.corrected(coordinates.state(q, np.zeros_like(q)))
            assert np.abs(equations.constraint(closed)).max() <= 1e-13, seed


@needs_kernel
@pytest.mark.parametrize("method", [name for name in COMPILED if name != "gopm"])
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_newtons_method_alone_does_not_in_the_kernel(formulation, method):
    """`newton` is a correction as it is."""
    system, plane, q = uneven_chain(1e4, 54)
    coordinates = Reduced(core(), system) if formulation == "reduced" else InPlane(core(), system, plane)
    equations, alone = coordinates.equations(suited(method, 1e4)), coordinates.state(q, np.zeros_like(q))
    for _ in range(25):
        alone = equations.newton(alone)
    assert not np.abs(equations.constraint(alone)).max() < 1e-6


def corrections(method: str, ratio: float, seed: int):
    """M, C_q, C, and the corrections to try, with the turn that each asks of each bar, (5,)."""
    system, _, q = uneven_chain(ratio, seed)
    pose = pose_of(q)
    M, C_q, C = mass_matrix(system, pose), jacobian(system, pose), constraint_at(system, q)
    tried = list(damped(make_method(suited(method, ratio)), M, C_q, C, q))
    turns = [
        2.0 * np.linalg.norm((pose.L[:-1] @ change.reshape(-1, 7)[:, 3:, None])[..., 0], axis=-1) for change, _ in tried
    ]
    return M, C_q, C, tried, np.array(turns)


@pytest.mark.parametrize("seed", ONE_HARD)
def test_corrections_turn_less_and_less_and_close_the_rows_to_first_order(seed):
    """Those that are not shortened; what then is shortened is the whole."""
    _, C_q, C, tried, turns = corrections("gpopm", 1e8, seed)
    widest = np.array([turn.max() for turn, (_, part) in zip(turns, tried, strict=True) if part == 1.0])
    assert len(widest) >= 4
    assert widest[0] <= THRESHOLDS.widest_turn
    assert np.all(widest[1:] <= 0.25 * widest[:-1])
    for change, part in tried:
        np.testing.assert_allclose(C_q @ change, -part * C, rtol=0, atol=1e-6 * np.abs(C).max())


@pytest.mark.parametrize("seed", ONE_HARD)
def test_what_turns_less_is_the_smallest_in_energy_that_does(seed):
    """The conditions of min ½ΔᵀMΔ subject to C_qΔ = -C and bounds on |δθ_b|: in the null space of C_q, MΔ is balanced
    by moments against the turns, E_b Δ, with multipliers μ_b that pull back and never push."""
    M, C_q, _, tried, turns = corrections("gpopm", 1e8, seed)
    N = np.linalg.svd(C_q)[2][len(C_q) :].T
    for change, _ in tried[1:4]:  # the first may be the whole, without bounds
        against = np.zeros((len(change), len(turns[0])))
        for bar in range(len(turns[0])):
            of_bar = slice(7 * bar + 3, 7 * bar + 7)
            against[of_bar, bar] = change[of_bar]
        multipliers, *_ = np.linalg.lstsq(N.T @ against, -(N.T @ M @ change), rcond=None)
        left = N.T @ (M @ change + against @ multipliers)
        assert np.abs(left).max() <= 1e-6 * np.abs(M @ change).max()
        assert multipliers.max() > 0.0
        assert multipliers.min() >= -1e-6 * multipliers.max()


def test_gopm_knows_no_masses_and_is_shortened():
    *_, tried, _ = corrections("gopm", 1e8, HARD[0])
    parts = [part for _, part in tried]
    assert parts[:3] == [1.0, 0.5, 0.25]
    for change, part in tried:
        np.testing.assert_allclose(change, part * tried[0][0], rtol=1e-14)


def test_what_turns_nothing_is_not_asked_to_turn_less():
    """A correction that shifts a body alone, and by round-off turns it a little when it is asked again."""

    class Shift:
        calls = 0

        def correction(self, M, C_q, violation):
            self.calls += 1
            return np.array([1.0, 0.0, 0.0, 0.0, 1e-20 * (self.calls > 1), 0.0, 0.0])

    q = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parts = [part for _, part in damped(Shift(), np.eye(7), np.eye(7), q, q)]
    assert parts[0] == 1.0 and parts == sorted(parts, reverse=True)
