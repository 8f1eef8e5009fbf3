"""The elimination, seen through the equations: residuals of M a + Gᵀλ = f and G a = γ at any size, fill, pivots."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import Scene
from mbproj.integrate import Reduced
from mbproj.kernel import core
from mbproj.model import compile_system, rotation_matrix
from tests.kernel.scenes import Case, ladder, loops, mechanism, needs_kernel, opened, rails, shaft, star, tree
from tests.support import random_body, random_chain, random_joint, scene_of

pytestmark = needs_kernel
KINDS = ["revolute", "spherical", "universal"]
SHAPES = {
    "chain": lambda size: random_chain(3, [KINDS[body % 3] for body in range(size)]),
    "floating tree": lambda size: tree(8, size),
    "ladder": lambda size: ladder(5, max(1, size // 2)),
    "star": lambda size: star(2, size - 1),
    "shaft": lambda size: shaft(2, size - 1),
    "rails": lambda size: rails(2, max(1, size // 4)),
}


def residuals(case: Case) -> tuple[float, float, float]:
    """What is left of Newton and Euler's equations, of G a = γ, and the largest number among a, λ and f."""
    system, y, equations = case.system, case.y, case.reduced.equations()
    acceleration, multipliers = equations.accelerations(y)
    A, omega = rotation_matrix(y[:, 3:7]), y[:, 10:13]
    G = equations.jacobian(y)
    gyroscopic = np.cross(omega, np.einsum("nij,nj->ni", system.inertia, omega))
    inertial = np.einsum("nij,nj->ni", system.inertia, acceleration[:, 3:]) + gyroscopic
    force = system.mass[:, None] * (acceleration[:, :3] - system.gravity)
    wrench = np.hstack([force, np.einsum("nij,nj->ni", A, inertial)]) + np.einsum("mni,m->ni", G, multipliers)
    a = np.hstack([acceleration[:, :3], np.einsum("nij,nj->ni", A, acceleration[:, 3:])])
    largest = max(np.abs(a).max(), np.abs(multipliers).max(initial=0.0), np.abs(inertial).max())
    return np.abs(wrench).max(), np.abs(np.einsum("mni,ni->m", G, a) - equations.gamma(y)).max(initial=0.0), largest


@pytest.mark.parametrize("size", [3, 30, 300])
@pytest.mark.parametrize("shape", SHAPES)
def test_both_equations_hold_to_round_off(shape, size):
    case = opened(SHAPES[shape](size), size=1e-3 / size)
    force, rows, largest = residuals(case)
    assert force <= 1e-12 * largest * size
    assert rows <= 1e-12 * largest * size


@pytest.mark.parametrize("seed", range(30))
def test_both_equations_hold_in_random_loops(seed):
    """Balls, slides, planes and rods that close a chain three times over; many orders of elimination."""
    case = opened(loops(seed, 4 + seed % 5))
    found = case.reduced.equations().accelerations(case.y)
    assert found is not None
    force, rows, largest = residuals(case)
    assert max(force, rows) <= 1e-10 * largest


@pytest.mark.parametrize("size", [3, 30, pytest.param(300, marks=pytest.mark.full)])
def test_trees_need_no_factor_at_all(size):
    """Leaves are eliminated one by one down to the root, which the ground holds or nothing does."""
    facts = topology(random_chain(3, [KINDS[body % 3] for body in range(size)]))
    assert facts == {
        "eliminated_bodies": size,
        "core_bodies": 0,
        "core_joints": 0,
        "core_numbers": 0,
        "core_fill": 0,
    }
    assert topology(tree(8, size))["eliminated_bodies"] >= size - 1
    assert topology(tree(8, size))["core_numbers"] == 0


def test_the_factor_of_a_ladder_grows_by_a_constant_per_loop():
    numbers = [topology(ladder(5, loops))["core_numbers"] for loops in (10, 20, 40, 80)]
    fill = [topology(ladder(5, loops))["core_fill"] for loops in (10, 20, 40, 80)]
    per_loop = np.diff(numbers) / (10, 20, 40)
    assert per_loop[0] == per_loop[1] == per_loop[2]
    # Of a loop: two balls and a rod, 7 rows that couple with the loop's own and the next one's.
    assert per_loop[0] <= 7 * 14
    assert all(part <= 0.5 * whole for part, whole in zip(fill, numbers, strict=True))


@pytest.mark.parametrize("arms", [3, 30, 100])
def test_the_factor_of_a_star_of_loops_holds_no_more_than_the_coupling_at_the_hub(arms):
    """Arms on balls (3 rows) around a hub, each tied to the ground by a rod (1 row). The balls all couple at the hub,
    a rod with its own ball alone: eliminated first, the rods cost nothing beyond."""
    rng = np.random.default_rng(arms)
    bodies = [random_body(rng, f"b{number}") for number in range(arms + 1)]
    balls = [random_joint(rng, f"J{arm}", "spherical", ("b0", f"b{arm}")) for arm in range(1, arms + 1)]
    rods = [random_joint(rng, f"R{arm}", "distance", ("ground", f"b{arm}")) for arm in range(1, arms + 1)]
    facts = topology(scene_of(bodies, [*balls, *rods]))
    assert facts["core_joints"] == 2 * arms
    assert facts["core_fill"] == 0
    assert facts["core_numbers"] == (1 + 3) * arms + 9 * arms * (arms + 1) // 2


def test_the_factor_of_loops_on_one_shaft_grows_by_a_constant_per_loop():
    """Of each arm a ball on the shaft (3 rows), a rod to the ground (1), and a weld to the shaft's next piece (1)."""
    numbers = [topology(shaft(5, arms, ["spherical"]))["core_numbers"] for arms in (10, 20, 40, 80)]
    per_arm = np.diff(numbers) / (10, 20, 40)
    assert per_arm[0] == per_arm[1] == per_arm[2] <= (3 + 1 + 1) * (3 + 1 + 1)


def test_joints_that_hinge_a_body_to_the_ground_have_no_rows_in_the_factor():
    """Of a slider-crank, 17 rows, those of the ball and of the universal joint are left: 3 and 4."""
    facts = topology(mechanism("spatial_slider_crank"))
    assert facts["core_joints"] == 2
    assert facts["core_numbers"] == 3 * 3 + 4 * 4 + 3 * 4


def test_rails_between_two_joints_have_no_rows_of_their_hinges_in_the_factor():
    """Of each loop's 16 rows, those of a ball and a universal joint are left, 7, which couple with the next loop's."""
    per_loop = np.diff([topology(rails(5, loops))["core_numbers"] for loops in (10, 20, 40)]) / (10, 20)
    assert per_loop[0] == per_loop[1] <= 7 * 14
    joints = [topology(rails(5, loops))["core_joints"] for loops in (10, 20)]
    assert joints == [2 * 10 + 1, 2 * 20 + 1]  # and the rod of the triangle


def topology(scene: Scene) -> dict[str, int]:
    return dict(Reduced(core(), compile_system(scene)).equations().topology)
