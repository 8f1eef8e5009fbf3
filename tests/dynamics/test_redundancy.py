"""Minimal dependent sets, permanent or at one pose, of mechanisms whose redundancy is known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj.base.mechanisms_folder import mechanism
from mbproj.equations.constraints import jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import mobility
from mbproj.equations.rank.redundancy import conditioning, redundancy
from mbproj.equations.rank.row_space import rows_in_words, scaled_jacobian
from mbproj.scene.scene import read_scene
from tests.crossed import crossed
from tests.dynamics import linkages
from tests.dynamics.linkages import assembled, scaled

#: Mechanism, permanent sets, sets at the pose only, degrees of freedom at the pose.
KNOWN = {
    "four_bar": (linkages.four_bar(), 3, 0, 1),
    "bennett": (linkages.bennett(), 3, 0, 1),
    "bricard": (linkages.bricard(), 1, 0, 1),
    "three_cranks": (linkages.parallelogram(3), 7, 0, 1),
    # Its balls are in line: the coupler turns about them.
    "three_cranks_on_balls": (linkages.parallelogram(3, kinds=("revolute", "spherical")), 2, 0, 2),
    "door": (linkages.door(), 5, 0, 1),
    "slider_crank": (linkages.slider_crank(0.5, 0.7), 3, 0, 1),
    "flat_parallelogram": (linkages.parallelogram(2, 0.0), 3, 1, 2),
    "flat_three_cranks": (linkages.parallelogram(3, 0.0), 7, 1, 2),
    "folded_slider_crank": (linkages.slider_crank(0.2, np.pi / 2), 3, 1, 2),
}


@pytest.mark.parametrize("name", KNOWN)
def test_the_sets_are_as_many_as_the_books_say(name):
    scene, permanent, passing, freedom = KNOWN[name]
    system, state = assembled(scene)
    found = redundancy(system, state)
    assert [entry.permanent for entry in found.sets].count(True) == permanent
    assert [entry.permanent for entry in found.sets].count(False) == passing
    assert (found.freedom, found.moves, found.is_constant) == (freedom, True, passing == 0)
    assert mobility(system, pose_of(state.q)).degrees_of_freedom == freedom


@pytest.mark.parametrize("name", KNOWN)
def test_each_set_is_dependent_and_no_row_of_it_can_be_left_out(name):
    """What holds along the motion is smallest there: at a branch point a part of it may depend on itself besides."""
    scene, _, passing, _ = KNOWN[name]
    system, state = assembled(scene)
    rows = scaled_jacobian(system, pose_of(state.q))
    norms = rows[: system.bodies]
    for entry in redundancy(system, state).sets:
        members = rows[system.bodies :][list(entry.rows)]
        assert np.linalg.matrix_rank(np.vstack([norms, members]), tol=1e-9) < system.bodies + len(members)
        for left_out in range(len(members) if not (passing and entry.permanent) else 0):
            rest = np.vstack([norms, np.delete(members, left_out, axis=0)])
            assert np.linalg.matrix_rank(rest, tol=1e-9) == len(rest) or _share_is_0_here(entry, left_out)


def _share_is_0_here(entry, row):
    """A row of a set that is smallest along the motion has no part in it at a pose with right angles."""
    return entry.permanent and abs(entry.weights[row]) < 1e-9


@pytest.mark.parametrize("name", KNOWN)
def test_the_weights_cancel_the_rows_but_for_the_radial_part(name):
    """Σ weight · row = 0 for all velocities that keep |Λ|."""
    system, state = assembled(KNOWN[name][0])
    pose = pose_of(state.q)
    rng = np.random.default_rng(1)
    rows = jacobian(system, pose)[system.bodies :]
    motion = rng.normal(size=(system.bodies, 7))
    Λ = pose.orientation[:-1]
    motion[:, 3:] -= np.sum(motion[:, 3:] * Λ, axis=1, keepdims=True) * Λ
    for entry in redundancy(system, state).sets:
        parts = entry.weights * (rows[list(entry.rows)] @ motion.ravel())
        assert abs(parts.sum()) < 1e-10 * np.abs(parts).sum()


def test_rows_are_named_with_what_they_hold():
    first, *_ = redundancy(*assembled(linkages.door())).sets
    assert rows_in_words(first.held) == "joint 'high' (along x), joint 'low' (along x, about y)"
    (flat,) = [entry for entry in redundancy(*assembled(linkages.parallelogram(2, 0.0))).sets if not entry.permanent]
    assert rows_in_words(flat.held) == (
        "joint 'B1' (along x), joint 'A0' (along x), joint 'B0' (along x), joint 'A1' (along x)"
    )


def test_a_joint_given_twice_depends_on_itself():
    scene = linkages.slider_crank(0.5, 0.7)
    twin = dataclasses.replace(scene.joints[0], name="A2")
    spherical = dataclasses.replace(scene.joints[1], type="spherical", axes=None)
    loose = dataclasses.replace(scene.joints[2], type="cylindrical")
    scene = dataclasses.replace(scene, joints=(scene.joints[0], spherical, loose, scene.joints[3], twin))
    system, state = assembled(scene)
    sets = redundancy(system, state).sets
    assert len(sets) == 5
    for entry in sets:
        assert {row.name for row in entry.held} == {"A", "A2"}
        assert len(entry.rows) == 2
        assert len({row.holds for row in entry.held}) == 1
        assert entry.permanent


def test_regular_mechanisms_have_none():
    for name in ("delta_robot", "five_bar", "hooke_shaft", "inline_four", "planar_four_bar", "stewart_platform"):
        found = redundancy(*assembled(read_scene(mechanism(name))))
        assert (found.sets, found.freedom, found.is_constant) == ((), None, True)


@pytest.mark.parametrize(
    "name, permanent, freedom", [("bennett", 3, 1), ("bricard", 1, 1), ("locomotive", None, 1), ("n_four_bar", None, 1)]
)
def test_overconstrained_examples_are_so_for_good(name, permanent, freedom):
    found = redundancy(*assembled(read_scene(mechanism(name))))
    assert found.is_constant and found.moves
    assert found.freedom == freedom
    assert len(found.sets) == permanent or permanent is None


@crossed("name, mass, length", KNOWN, [1e-6, 1e6], [1e-6, 1e6], together=1)
def test_nothing_depends_on_size_or_mass(name, length, mass):
    scene = KNOWN[name][0]
    system, state = assembled(scene)
    other, there = assembled(scaled(scene, length, mass))
    before, after = redundancy(system, state), redundancy(other, there)
    assert [(x.rows, x.permanent, x.contradictory) for x in after.sets] == [
        (x.rows, x.permanent, x.contradictory) for x in before.sets
    ]
    assert (after.freedom, after.moves) == (before.freedom, before.moves)
    here, now = conditioning(system, pose_of(state.q)), conditioning(other, pose_of(there.q))
    assert now.scaled == pytest.approx(here.scaled, rel=1e-6)
    assert now.distance == pytest.approx(here.distance, rel=1e-6)
    assert (now.owner, now.words) == (here.owner, here.words)
