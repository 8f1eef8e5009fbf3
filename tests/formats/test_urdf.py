"""URDF: trees move as MuJoCo reads them, loops of each dialect close, and what is wrong is said at its line."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import mobility
from mbproj.formats.as_scene import scene_text
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.linear.equilibrium.start import start_state
from mbproj.scene.scene import read_scene_text
from tests.formats.agreement import agreement
from tests.support import ROOT

DATA = ROOT / "tests" / "data" / "formats"
#: The joint of the scene that closes the loop, by file.
DIALECTS = {"loop_joint": "revolute", "urdf_plus": "revolute", "closing": "spherical", "closed_loop": "spherical"}


def test_a_tree_moves_as_mujoco_reads_it():
    pytest.importorskip("mujoco")
    found = agreement(DATA / "chain.urdf")
    assert max(found) < 1e-10


@pytest.mark.parametrize("name", DIALECTS)
def test_a_loop_of_each_dialect_closes_and_leaves_one_freedom(name):
    mechanism = read_model(DATA / f"{name}.urdf")
    (loop,) = [joint for joint in mechanism.joints.values() if joint.name not in mechanism.tree]
    assert loop.type == DIALECTS[name]
    text = scene_text(mechanism, "1")
    assert max(map(len, text.splitlines())) <= 100
    scene = read_scene_text(text)
    system = compile_system(scene)
    state = start_state(scene, system)
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    assert mobility(system, pose_of(state.q)).degrees_of_freedom == 1


def test_a_loop_without_an_axis_is_about_x_which_is_said(tmp_path):
    text = (DATA / "loop_joint.urdf").read_text(encoding="utf-8")
    start = text.rindex("<axis")
    (tmp_path / "m.urdf").write_text(text[:start] + text[text.index(">", start) + 1 :], encoding="utf-8")
    mechanism = read_model(tmp_path / "m.urdf")
    (row,) = mechanism.said
    assert (row.element, row.what) == ("loop 'd'", "its axis is not given: x of its frames, as of joints")
    assert mechanism.joints["d"].axes == pytest.approx(np.array([[1, 0, 0], [1, 0, 0]]), abs=1e-15)
    assert not [row for row in read_model(DATA / "loop_joint.urdf").said if row.element == "loop 'd'"]


def test_a_frame_may_be_turned_by_a_quaternion(tmp_path):
    """A quarter turn about z, as `rpy` and as `quat_xyzw` of any length."""
    text = (DATA / "loop_joint.urdf").read_text(encoding="utf-8")
    origin = '<origin xyz="0 0 0" rpy="0 0 1.5707963267948966"/>'
    assert text.count(origin) == 1
    (tmp_path / "m.urdf").write_text(
        text.replace(origin, '<origin xyz="0 0 0" quat_xyzw="0 0 2 2"/>'), encoding="utf-8"
    )
    parts, expected = (read_model(path).parts for path in (tmp_path / "m.urdf", DATA / "loop_joint.urdf"))
    for name, part in parts.items():
        assert part.rotation == pytest.approx(expected[name].rotation, abs=1e-15)


def test_the_same_loop_in_another_file_is_read_on_request(tmp_path):
    other = tmp_path / "loops.yaml"
    other.write_text("closed_loop: [[end_a, end_b]]\ntype: [6d]\n", encoding="utf-8")
    mechanism = read_model(DATA / "closed_loop.urdf", ImportOptions(loops=other))
    (loop,) = [joint for joint in mechanism.joints.values() if joint.name not in mechanism.tree]
    assert loop.type == "fixed"


def test_a_mimic_is_a_coupler_and_limits_count_from_the_pose():
    mechanism = read_model(DATA / "chain.urdf", ImportOptions(pose={"shoulder": 0.4, "extend": 0.1}))
    coupler = mechanism.joints["grip_mimic"]
    assert coupler.keys["of"] == {"grip.angle": 1.0, "shoulder.angle": -0.5}
    assert coupler.keys["constant"] == pytest.approx(0.1 + 0.5 * 0.4)
    span = mechanism.joints["extend"].keys["limits"]["displacement"]["range"]
    assert [each.value for each in span] == pytest.approx([-0.3, 0.2])
    assert mechanism.forces["extend_friction"]["coulomb"]["force"].value == 0.1


WRONG = {
    '<link name="a"/>\n<link name="a"/>': "model.urdf:3: error: a second link 'a'",
    '<link name="a"/>\n<link name="b"/>': "model.urdf:3: error: the model has 2 links without a parent",
    '<link name="a">\n<inertial><mass value="nan"/></inertial></link>': "model.urdf:3: error: 'value' of <mass>",
    '<link name="a">\n<inertial><mass value="1_0"/></inertial></link>': "model.urdf:3: error: 'value' of <mass>",
    '<link name="a"><inertial>\n<inertia ixx="-1" iyy="1" izz="1"/></inertial></link>': (
        "model.urdf:3: error: the inertia has a negative principal moment"
    ),
    '<link name="a"/>\n<joint name="j" type="hinge"><parent link="a"/><child link="b"/></joint>': (
        "model.urdf:3: error: unknown joint type 'hinge'"
    ),
    '<link name="a"/>\n<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>': (
        "model.urdf:3: error: unknown link 'b'"
    ),
    '<link name="a"/>\n<loop_joint type="fixed"><link1 link="a"/><link2 link="c"/></loop_joint>': (
        "model.urdf:3: error: unknown link 'c'"
    ),
    '<link name="a"/>\n<xacro:if xmlns:xacro="x" value="1"/>': "model.urdf:1: error: this is a xacro",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_said_at_its_line(text, tmp_path):
    path = tmp_path / "model.urdf"
    path.write_text(f"<robot name='r'>\n{text}\n</robot>", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert caught.value.problems[0].line().replace(f"{tmp_path}/", "").startswith(WRONG[text])


def test_what_would_act_on_the_motion_and_is_not_read_is_said_at_its_line(tmp_path):
    """A coupling of URDF+ and a loop in Gazebo's words would; a motor's transmission and a colour do not."""
    more = """<coupling name="pair"><predecessor link="a"/></coupling>
<gazebo><joint name="closing" type="revolute"/></gazebo>
<gazebo reference="a"><material>Gazebo/Red</material></gazebo>
<transmission name="drive"><joint name="shoulder"/></transmission>
<gazebo reference="a"><gravity>0</gravity></gazebo>
<transmission name="heavy"><actuator name="m"><motorInertia>1</motorInertia></actuator></transmission>
</robot>"""
    text = (DATA / "chain.urdf").read_text(encoding="utf-8").replace("</robot>", more)
    path = tmp_path / "model.urdf"
    path.write_text(text, encoding="utf-8")
    first = text[: text.index("<coupling")].count("\n") + 1
    said = {row.place.line: row.same.value for row in read_model(path).said if row.place is not None}
    assert [said[first + after] for after in range(6)] == ["no", "no", "yes", "yes", "no", "no"]


def test_points_of_links_that_meet_are_read_beside_the_model(tmp_path):
    """loop_closures.yaml; the names and points are those of the loop in YAML that the other test closes."""
    text = (DATA / "closed_loop.urdf").read_text(encoding="utf-8")
    (tmp_path / "m.urdf").write_text(text, encoding="utf-8")
    loop = "{name: pin, parent: end_a, parent_xyz: [0, 0, 0], child: end_b, child_xyz: [0, 0, 0]}"
    (tmp_path / "loop_closures.yaml").write_text(f"ball_loops:\n  - {loop}\n", encoding="utf-8")
    mechanism = read_model(tmp_path / "m.urdf")
    (found,) = [joint for joint in mechanism.joints.values() if joint.name not in mechanism.tree]
    assert (found.name, found.type) == ("pin", "spherical")
    (tmp_path / "loop_closures.yaml").write_text("ball_loops:\n  - {parent: end_a}\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"loop_closures.yaml:2:5: error: a ball loop names no child"):
        read_model(tmp_path / "m.urdf")


def test_springs_of_dynamics_are_read_and_its_other_words_said(tmp_path):
    text = (DATA / "chain.urdf").read_text(encoding="utf-8")
    assert '<dynamics damping="0.3"/>' in text
    more = '<dynamics damping="0.3" spring_stiffness="4" spring_reference="0.5" hysteresis="2" stiction="0"/>'
    safe = '<safety_controller k_velocity="1"/>'
    (tmp_path / "m.urdf").write_text(text.replace('<dynamics damping="0.3"/>', more + safe), encoding="utf-8")
    mechanism = read_model(tmp_path / "m.urdf", ImportOptions(pose={"shoulder": 0.2}))
    spring = mechanism.forces["shoulder_spring"]
    assert (spring["stiffness"].value, spring["free_angle"].value) == (4.0, pytest.approx(0.3))
    said = {row.element: row.same.value for row in mechanism.said}
    assert said["'hysteresis' of joint 'shoulder'"] == "no"
    assert said["<safety_controller> of joint 'shoulder'"] == "yes"
    assert "'stiction' of joint 'shoulder'" not in said
