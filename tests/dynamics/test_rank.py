"""Degrees of freedom, redundant joints by name, Eq. 20; and none of it depends on units or size."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import mobility, refuse_unsolvable
from mbproj.equations.rank.row_space import row_distances
from mbproj.joints.table import JOINTS
from mbproj.model.compile.mechanism import initial_guess
from tests.dynamics.four_bar import parallelogram
from tests.support import random_body, random_chain, scene_of

#: Of a chain of four.
FREEDOM = {
    "revolute": 4,
    "spherical": 12,
    "universal": 8,
    "prismatic": 4,
    "cylindrical": 8,
    "planar": 12,
    "fixed": 0,
    "distance": 20,
    "revolute_spherical": 16,
    "point_in_plane": 20,
    "point_on_line": 16,
    "screw": 4,
    "gear": 1,
    "rack": 2,
    "belt": 1,
    "geneva": 1,
    "differential": 2,
    "coupler": 1,
    "telescope": 24,
    "cam_contact": 24,
    "flat_contact": 24,
    "flat_follower": 20,
    "curve_on_curve": 20,
    "space_slot": 16,
    "curve_contact": 24,
    "rolling_wheel": 12,
    "rolling_ball": 12,
    "rolling_ellipsoid": 12,
    "rolling_on_line": 4,
    "rolling_on_curve": 16,
    "knife_edge": 20,
    "cam": 20,
    "slot": 16,
    "rope": 20,
}


def ranks(scene):
    system = compile_system(scene)
    return system, mobility(system, pose_of(initial_guess(scene, system).q))


@pytest.mark.parametrize("kind", sorted(JOINTS))
def test_every_joint_leaves_its_degrees_of_freedom(kind):
    _, found = ranks(random_chain(2, [kind] * 4))
    assert found.degrees_of_freedom == FREEDOM[kind]
    assert found.redundant == {}
    assert found.massless == ()


def test_a_free_body_has_six():
    _, found = ranks(scene_of([random_body(np.random.default_rng(0), "free")], []))
    assert (found.coordinates, found.constraints, found.degrees_of_freedom) == (7, 1, 6)


def test_a_planar_loop_of_revolutes_has_three_redundant_rows_named_by_joint():
    system, found = ranks(parallelogram())
    assert (found.constraints, found.rank, found.degrees_of_freedom) == (23, 20, 1)
    assert found.redundant == {"J3": 3}
    with pytest.raises(InputError, match="joint 'J3' is redundant: 3 of its constraints already follow"):
        refuse_unsolvable(system, found)


def test_the_same_loop_with_a_universal_and_a_spherical_joint_is_regular():
    system, found = ranks(parallelogram("rusr"))
    assert found.redundant == {}
    assert found.degrees_of_freedom == 1
    refuse_unsolvable(system, found)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("mass", [1e-6, 1e6])
def test_the_verdict_does_not_depend_on_size_or_mass(scale, mass):
    _, found = ranks(parallelogram(scale=scale, mass=mass))
    assert found.redundant == {"J3": 3}
    assert found.massless == ()
    _, regular = ranks(parallelogram("rusr", scale=scale, mass=mass))
    assert regular.redundant == {}


def test_a_massless_body_that_joints_do_not_hold_is_named():
    scene = random_chain(4, ["revolute", "spherical"])
    light = dataclasses.replace(scene.bodies[1], mass=0.0, inertia=((0.0,) * 3,) * 3)
    system, found = ranks(dataclasses.replace(scene, bodies=(scene.bodies[0], light)))
    assert found.massless == ("body1",)
    with pytest.raises(InputError, match=r"3 motions that move no mass \(Eq. 20 does not hold\): 'body1' turns"):
        refuse_unsolvable(system, found)


def test_a_massless_body_that_moves_mass_whenever_it_moves_is_legal():
    """Eq. 20 holds though M is singular beyond Λ: the massless crank can only turn with the heavy body behind it."""
    scene = random_chain(4, ["revolute", "prismatic"])
    light = dataclasses.replace(scene.bodies[0], mass=0.0, inertia=((0.0,) * 3,) * 3)
    _, found = ranks(dataclasses.replace(scene, bodies=(light, scene.bodies[1])))
    assert found.massless == ()


def test_row_distances_are_those_of_gram_schmidt():
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(6, 9))
    rows[3] = rows[0] - 2.0 * rows[2]
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    distances = row_distances(rows)
    assert list(np.flatnonzero(distances < THRESHOLDS.dependent)) == [3]
    for index in (1, 2, 4, 5):
        before = rows[:index]
        projected = before.T @ np.linalg.lstsq(before.T, rows[index], rcond=1e-10)[0]
        assert distances[index] == pytest.approx(np.linalg.norm(rows[index] - projected), rel=1e-10)


def test_rows_beyond_the_columns_are_dependent():
    rows = np.random.default_rng(3).normal(size=(5, 3))
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    assert list(np.flatnonzero(row_distances(rows) < THRESHOLDS.dependent)) == [3, 4]
