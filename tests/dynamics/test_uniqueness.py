"""Components of reactions that C leaves open, of mechanisms where statics says which."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj.equations.constraints import tangent_jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.row_space import self_stresses
from mbproj.equations.rank.uniqueness import indeterminate, unique_components
from tests.dynamics import linkages
from tests.dynamics.four_bar import parallelogram
from tests.dynamics.linkages import assembled, scaled


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
