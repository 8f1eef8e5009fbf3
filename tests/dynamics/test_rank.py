"""Degrees of freedom, Eq. 20, redundant joints by name, and the reactions that they leave open."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.base.mechanisms_folder import mechanism
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import jacobian, tangent_jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import mobility, refuse_unsolvable
from mbproj.equations.rank.redundancy import conditioning, redundancy
from mbproj.equations.rank.row_space import row_distances, rows_in_words, scaled_jacobian, self_stresses
from mbproj.equations.rank.uniqueness import indeterminate, unique_components
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.joints.table import JOINTS
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.records import Body, Joint, Pair
from mbproj.scene.scene import read_scene
from tests.crossed import crossed
from tests.dynamics import linkages
from tests.dynamics.linkages import scaled
from tests.support import assembled, random_body, random_chain, scene_of

# A planar four-bar with a choice of joints.

ROUND = ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01))


def parallelogram(kinds: str = "rrrr", scale: float = 1.0, mass: float = 1.0):
    """A planar four-bar of 1 m by 0.5 m in the x-z plane; letters r, u, s choose its joints."""
    names = {"r": "revolute", "s": "spherical", "u": "universal"}
    corners = [(0.0, 0.0, 0.0), (0.0, 0.0, scale), (0.5 * scale, 0.0, scale), (0.5 * scale, 0.0, 0.0)]
    middles = [(0.0, 0.0, 0.5 * scale), (0.25 * scale, 0.0, scale), (0.5 * scale, 0.0, 0.5 * scale)]
    inertia = tuple(tuple(mass * scale**2 * x for x in row) for row in ROUND)
    bodies = [Body(name, mass, inertia, middle) for name, middle in zip(("left", "top", "right"), middles, strict=True)]
    ends = [("ground", "left"), ("left", "top"), ("top", "right"), ("right", "ground")]
    axes = {"r": Pair((0.0, 1.0, 0.0), (0.0, 1.0, 0.0)), "u": Pair((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), "s": None}
    joints = [
        Joint(f"J{number}", names[kind], ends[number], Pair(corners[number], corners[number]), axes[kind])
        for number, kind in enumerate(kinds)
    ]
    return scene_of(bodies, joints)


# Degrees of freedom, redundant joints by name, Eq. 20; and none of it depends on units or size.

#: Of a chain of four joints that couple coordinates of others, or merge bodies, or follow a path. Another joint takes a
#: freedom for each of its rows.
FREEDOM = {"fixed": 0, "gear": 1, "rack": 2, "belt": 1, "geneva": 1, "differential": 2, "coupler": 1, "rope": 20}


def ranks(scene):
    system = compile_system(scene)
    return system, mobility(system, pose_of(initial_guess(scene, system).q))


@pytest.mark.parametrize("kind", sorted(JOINTS))
def test_every_joint_leaves_its_degrees_of_freedom(kind):
    _, found = ranks(random_chain(2, [kind] * 4))
    rows = sum(PRIMITIVES[row[0]].rows for row in JOINTS[kind].rows)
    assert found.degrees_of_freedom == FREEDOM.get(kind, 4 * (6 - rows))
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


# Minimal dependent sets, permanent or at one pose, of mechanisms whose redundancy is known.

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


# Components of reactions that C leaves open, of mechanisms where statics says which.


def open_parts(scene):
    """The components that are not unique, by joint, as "Fx Ty"."""
    system, state = assembled(scene)
    force, torque = indeterminate(system, pose_of(state.q))
    return {
        name: " ".join(
            [f"F{axis}" for axis, marked in zip("xyz", f, strict=True) if marked]
            + [f"T{axis}" for axis, marked in zip("xyz", t, strict=True) if marked]
        )
        for name, f, t in zip(system.names.joints, force, torque, strict=True)
    }


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
def test_a_planar_four_bar_leaves_open_what_acts_out_of_its_plane(length):
    assert open_parts(scaled(linkages.four_bar(), length, 1.0)) == dict.fromkeys("ABCD", "Fy Tx Tz")


def test_a_slider_crank_too():
    assert open_parts(linkages.slider_crank(0.5, 0.7)) == dict.fromkeys("ABCD", "Fy Tx Tz")


def test_a_door_leaves_open_how_its_hinges_share_the_load():
    """Hinge axis z: all but the torque about it, which no revolute joint bears."""
    assert open_parts(linkages.door()) == dict.fromkeys(("low", "high"), "Fx Fy Fz Tx Ty")


def test_a_door_on_a_hinge_and_a_ball_leaves_open_the_push_along_their_line_alone():
    scene = linkages.door()
    ball = dataclasses.replace(scene.joints[1], type="spherical", axes=None)
    hinge = dataclasses.replace(scene.joints[0], type="spherical", axes=None)
    assert open_parts(dataclasses.replace(scene, joints=(hinge, ball))) == {"low": "Fz", "high": "Fz"}


def test_a_regular_loop_leaves_nothing_open():
    assert set(open_parts(parallelogram("rusr")).values()) == {""}


def test_a_tree_beside_the_loop_is_untouched():
    loop = linkages.four_bar()
    arm = linkages.body("arm", (0.4, 0.2, 0.9))
    hinge = linkages.joint("E", "revolute", ("link2", "arm"), (0.4, 0.1, 0.4), (1.0, 0.0, 0.0))
    scene = dataclasses.replace(loop, bodies=(*loop.bodies, arm), joints=(*loop.joints, hinge))
    assert open_parts(scene) == dict.fromkeys("ABCD", "Fy Tx Tz") | {"E": ""}


@pytest.mark.parametrize("scene", [linkages.bennett(), linkages.bricard(), linkages.parallelogram(3)])
def test_self_stresses_act_on_no_body(scene):
    system, state = assembled(scene)
    stresses = self_stresses(system, pose_of(state.q))
    G = tangent_jacobian(system.joints, pose_of(state.q))[:, :-1, :6].reshape(system.joints.size, -1)
    assert len(stresses) == system.joints.size - np.linalg.matrix_rank(G, tol=1e-9)
    assert np.abs(stresses @ G).max() < 1e-12 * np.abs(stresses).max()


def test_a_loop_that_turns_with_its_table_leaves_open_what_turns_into_view():
    """Four bars in the plane normal to y at the start, on a table that turns about z: later it is normal to x."""
    loop = linkages.four_bar()
    table = linkages.body("table", (0.0, 0.0, -0.5), 5.0)
    pivot = linkages.joint("T", "revolute", ("ground", "table"), (0, 0, -0.5), (0, 0, 1))
    joints = [
        dataclasses.replace(joint, bodies=tuple("table" if name == "ground" else name for name in joint.bodies))
        for joint in loop.joints
    ]
    scene = dataclasses.replace(loop, bodies=(*loop.bodies, table), joints=(*joints, pivot))
    assert open_parts(scene) == dict.fromkeys("ABCD", "Fy Tx Tz") | {"T": ""}
    marks = unique_components(*assembled(scene))
    expected = [[False, False, True]] * 4 + [[True] * 3]
    assert marks["joints/reaction_force_unique"].tolist() == expected
    assert marks["joints/reaction_torque_unique"].tolist() == [[False] * 3] * 4 + [[True] * 3]


def test_a_tree_has_nothing_open():
    scene = linkages.slider_crank(0.5, 0.7)
    marks = unique_components(*assembled(dataclasses.replace(scene, joints=scene.joints[:3])))
    assert all(each.all() for name, each in marks.items() if name.endswith("unique"))
    assert not any(each.any() for name, each in marks.items() if name.endswith("open"))


def test_the_open_directions_of_a_loop_in_a_plane_are_those_out_of_it():
    marks = unique_components(*assembled(linkages.four_bar()))
    for kind, directions in (("force", [0.0, 1.0, 0.0]), ("torque", [1.0, 0.0, 1.0])):
        expected = np.broadcast_to(np.diag(directions), (4, 3, 3))
        np.testing.assert_allclose(marks[f"joints/reaction_{kind}_open"], expected, atol=1e-12)
