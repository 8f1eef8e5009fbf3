"""MJCF: trees move as MuJoCo's, loops close, and what has no counterpart is said."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import import_model, run
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at
from mbproj.formats.as_scene import scene_text
from mbproj.formats.mechanism import ImportOptions, Same
from mbproj.formats.read import read_model
from mbproj.linear.equilibrium.start import start_state
from mbproj.scene.fields.rotations import to_matrix
from mbproj.scene.scene import read_scene_text
from tests.formats.agreement import agreement
from tests.support import ROOT

pytest.importorskip("mujoco")
DATA = ROOT / "tests" / "data" / "formats"


@pytest.mark.parametrize("name", ["stacks.xml", "loops.xml"])
def test_trees_move_as_mujocos(name):
    found = agreement(DATA / name)
    assert max(found) < 1e-10


TWIST = '<joint name="twist" axis="0 1 1" damping="0.1"/>'
BALLS = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="1 2 -9"/>
  <worldbody>
    <body name="upper" pos="0 0 1" euler="0.3 0 0.2">
      <joint name="shoulder" type="ball" damping="0.7" stiffness="3"/>
      <geom size="0.03 0.2" type="capsule" pos="0.1 0 -0.2" density="5000"/>
      <body name="lower" pos="0 0 -0.4">
        BEFORE<joint name="elbow" type="ball" damping="0.4" pos="0 0.02 0"/>
        <geom size="0.03 0.05 0.1" type="box" pos="0 0.1 -0.1" density="5000"/>
      </body>
    </body>
  </worldbody>
  <keyframe><key name="bent" qpos="0.8 0.2 -0.4 0.4 0.7 0.5 0.5 -0.5 0.5"/></keyframe>
</mujoco>
"""


@pytest.mark.parametrize(("key", "before"), [(None, TWIST), (None, ""), ("bent", "")])
def test_balls_with_springs_and_dampers_move_as_mujocos(tmp_path, key, before):
    """At poses turned by up to 1.7 rad; a keyframe begins elsewhere than where springs rest, so frames lean there."""
    path, options = tmp_path / "balls.xml", ImportOptions(key=key)
    text = BALLS.replace("BEFORE", before)
    path.write_text(text if before else text.replace("0.4 0.7 0.5", "0.4 0.5"), encoding="utf-8")
    assert max(agreement(path, options=options)) < 1e-12
    mechanism = read_model(path, options)
    assert not [row for row in mechanism.said if row.same is Same.NO]
    assert {"shoulder_spring", "elbow_damper"} <= set(mechanism.forces)


@pytest.mark.parametrize("name", ["stacks.xml", "loops.xml"])
def test_the_scene_reads_as_a_persons(name):
    text = scene_text(read_model(DATA / name), "1")
    assert max(map(len, text.splitlines())) <= 100
    scene = read_scene_text(text)
    assert not scene.notes
    assert [body.name for body in scene.bodies][:2] == (["crank", "rod"] if name == "loops.xml" else ["base", "cross"])


def test_several_joints_between_two_bodies_are_one_joint_where_they_can():
    mechanism = read_model(DATA / "stacks.xml")
    kinds = {name: joint.type for name, joint in mechanism.joints.items()}
    assert kinds["rail_spin"] == "cylindrical"
    assert kinds["cross_x_cross_y"] == "universal"
    assert kinds["puck_x_puck_y_puck_turn"] == "planar"
    assert kinds["socket"] == "spherical"
    assert (kinds["yaw"], kinds["lift"], kinds["roll"]) == ("revolute", "prismatic", "revolute")
    assert mechanism.between == {"wrist_after_yaw", "wrist_after_lift"}


def test_loops_close_to_the_last_digit():
    """connect, weld with a frame in each body, a joint that follows by a polynomial, tendons of equal length."""
    scene = read_scene_text(scene_text(read_model(DATA / "loops.xml"), "1"))
    system = compile_system(scene)
    state = start_state(scene, system)
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    assert {joint.name: joint.type for joint in scene.joints if joint.couples} == {"cam": "coupler", "rope": "coupler"}
    (cam,) = [joint.couples for joint in scene.joints if joint.name == "cam"]
    assert cam.function is not None
    assert cam.of == {"slide.displacement": 0.0, "follow.displacement": 1.0}


SPRINGS = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="1 2 -9"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" type="hinge" axis="0 1 0" stiffness="7" springref="0.3" damping="0.2"/>
      <geom size="0.03 0.2" type="capsule" pos="0.1 0 -0.2" density="5000"/>
      <body name="block" pos="0 0 -0.4">
        <joint name="slide" type="slide" axis="1 0 0" stiffness="40" springref="-0.1"/>
        <geom size="0.03 0.05 0.1" type="box" density="5000"/>
      </body>
    </body>
  </worldbody>
  <keyframe><key name="bent" qpos="0.8 0.25"/></keyframe>
</mujoco>
"""


@pytest.mark.parametrize("key", [None, "bent"])
def test_springs_of_hinges_and_slides_rest_where_mujocos_do(tmp_path, key):
    """Coordinates count from the pose of the start, which a keyframe moves; the springs rest at 0.3 rad and -0.1 m."""
    path = tmp_path / "springs.xml"
    path.write_text(SPRINGS)
    assert max(agreement(path, options=ImportOptions(key=key))) < 1e-10


def test_a_weld_holds_frames_that_the_pose_does_not():
    """MuJoCo's own relpose: the pose of the cap in the axes of the wheel."""
    scene = read_scene_text(scene_text(read_model(DATA / "loops.xml"), "1"))
    system = compile_system(scene)
    index = {body.name: at for at, body in enumerate(scene.bodies)}
    wheel, cap = index["wheel"], index["cap"]
    assert system.body_carrier[wheel] == system.body_carrier[cap]
    turns = [np.array(to_matrix(tuple(system.body_turn[at]))) for at in (wheel, cap)]
    np.testing.assert_allclose(turns[0].T @ turns[1], to_matrix((0.8, 0.0, 0.6, 0.0)), atol=1e-14)


@pytest.mark.parametrize(
    ("own", "same"),
    [("", "yes"), ('solref="0.005 1"', "yes"), ('solref="0.5 1"', "no"), ('solimp="0.1 0.2 0.1"', "no")],
)
def test_an_equality_that_a_model_makes_softer_is_another_motion(tmp_path, own, same):
    text = (DATA / "loops.xml").read_text(encoding="utf-8")
    (tmp_path / "soft.xml").write_text(text.replace('<connect name="pin"', f'<connect {own} name="pin"'))
    (row,) = [each for each in read_model(tmp_path / "soft.xml").said if each.element == "equality 'pin' (connect)"]
    assert row.same.value == same


def test_spheres_and_ends_of_capsules_above_a_plane_are_stops_on_request(tmp_path):
    """A ball of 0.1 m at the height 0.3 m, and a capsule whose ends are 0.2 m along x beside its middle."""
    path = tmp_path / "model.xml"
    ball = '<body name="b" pos="0 0 0.3"><freejoint/><geom name="g" size="0.1"/></body>'
    pill = '<body name="c" pos="1 0 0.5"><freejoint/><geom type="capsule" size="0.05 0.2" euler="0 90 0"/></body>'
    text = f'<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>{ball}{pill}</worldbody></mujoco>'
    path.write_text(text, encoding="utf-8")
    assert not read_model(path).forces
    mechanism = read_model(path, ImportOptions(contacts=True))
    assert list(mechanism.forces) == ["g_on_plane", "c_on_plane", "c_on_plane_2"]
    scene = read_scene_text(scene_text(mechanism, "1"))
    heights = [stop.point.vector for stop in scene.forces]
    assert [stop.radius for stop in scene.forces] == [0.1, 0.05, 0.05]
    np.testing.assert_allclose([abs(each[0]) for each in heights], [0.0, 0.2, 0.2], atol=1e-14)
    (row,) = [each for each in mechanism.said if each.element == "contacts of 2 shapes"]
    assert row.what.startswith("3 spheres above planes are rigid stops without friction")


def test_a_tendon_between_two_points_is_a_spring_a_stop_or_a_rod(tmp_path):
    path = tmp_path / "model.xml"
    text = """<mujoco><worldbody><site name="a"/><body name="b" pos="0 0 1"><freejoint/><geom size="0.1"/>
      <site name="c" pos="0 0.5 0"/></body></worldbody>
      <tendon><spatial name="spring" stiffness="3" damping="0.5" springlength="0.8" range="0.1 2">
        <site site="a"/><site site="c"/></spatial>
        <spatial name="odd" stiffness="3" springlength="0.2 0.4"><site site="a"/><site site="c"/></spatial>
        <spatial name="rod"><site site="a"/><site site="c"/></spatial></tendon>
      <equality><tendon name="held" tendon1="rod"/></equality></mujoco>"""
    path.write_text(text, encoding="utf-8")
    mechanism = read_model(path)
    spring, stop = mechanism.forces["spring"], mechanism.forces["spring_limit"]
    assert (spring["stiffness"].value, spring["damping"].value, spring["free_length"].value) == (3.0, 0.5, 0.8)
    assert (stop["shortest"].value, stop["longest"].value) == (0.1, 2.0)
    assert mechanism.joints["held"].type == "distance"
    assert mechanism.joints["held"].keys["length"].value == pytest.approx(np.hypot(1.0, 0.5))
    said = {row.element: row.same.value for row in mechanism.said}
    assert mechanism.signals["odd_stretch"] == "(odd.length) - clip(odd.length, 0.2, 0.4)"
    assert not {"tendon 'odd'", "tendon 'spring'"} & set(said)


def test_meshes_of_one_name_in_two_folders_are_two(tmp_path):
    """A tetrahedron with edges of 0.1 m along the axes has 1/6 kg, one of twice the size eight times as much."""
    for folder, size in (("a", 0.1), ("b", 0.2)):
        (tmp_path / folder).mkdir()
        points = "\n".join(f"v {x} {y} {z}" for x, y, z in ([0, 0, 0], [size, 0, 0], [0, size, 0], [0, 0, size]))
        (tmp_path / folder / "part.obj").write_text(f"{points}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    path = tmp_path / "model.xml"
    path.write_text(
        """<mujoco><asset><mesh name="first" file="a/part.obj"/><mesh file="b/part.obj"/></asset><worldbody>
        <body name="one"><joint axis="0 1 0"/><geom type="mesh" mesh="first"/></body>
        <body name="two"><joint axis="0 1 0"/><geom type="mesh" mesh="part"/></body></worldbody></mujoco>"""
    )
    assert [part.mass for part in read_model(path).parts.values()] == pytest.approx([1 / 6, 8 / 6], rel=1e-6)


def test_a_pose_that_opens_a_loop_is_said_with_its_gap(tmp_path):
    """A pin at (0.5, 0, 0.3) m of an arm that has turned by 0.4 rad about y; the other end stays."""
    bodies = """<body name="arm"><joint name="turn" axis="0 1 0"/><geom size="0.1" pos="0 0 0.3"/></body>
      <body name="other" pos="0.5 0 0"><joint name="swing" axis="0 1 0"/><geom size="0.1" pos="0 0 0.3"/></body>"""
    pin = '<connect name="pin" body1="arm" body2="other" anchor="0.5 0 0.3"/>'
    path = tmp_path / "m.xml"
    path.write_text(f"<mujoco><worldbody>{bodies}</worldbody><equality>{pin}</equality></mujoco>", encoding="utf-8")
    said = [import_model(path, pose=pose).mechanism.said for pose in ({}, {"turn": 0.4})]
    assert not [row for row in said[0] if "loops" in row.element]
    (row,) = [row for row in said[1] if "loops" in row.element]
    gap = 2.0 * np.sin(0.2) * np.hypot(0.5, 0.3)
    assert row.element == "1 of 1 loops, open where the model begins"
    assert row.what.startswith(f"up to {gap:.2g} m and 0 deg apart: the scene is assembled from there")


def test_fingers_that_are_coupled_have_one_limit(tmp_path):
    """The second slides twice as far as the first, the other way, and up to 0.02 m: the first falls by 0.01 m."""
    fingers = "".join(
        f'<body name="{name}"><joint name="{name}" type="slide" axis="0 0 1" range="{limit}"/><geom size="0.01"'
        f' mass="{mass}"/></body>'
        for name, limit, mass in (("first", "-0.03 0.03", 1), ("second", "-0.05 0.02", 0.1))
    )
    ratio = '<joint joint1="second" joint2="first" polycoef="0 -2 0 0 0"/>'
    path = tmp_path / "m.xml"
    path.write_text(
        f'<mujoco><compiler autolimits="true"/><worldbody>{fingers}</worldbody><equality>{ratio}</equality></mujoco>',
        encoding="utf-8",
    )
    found = import_model(path)
    joints = found.mechanism.joints
    assert "limits" not in joints["second"].keys
    (low, high) = joints["first"].keys["limits"]["displacement"]["range"]
    assert (low.value, high.value) == pytest.approx((-0.01, 0.025))
    (row,) = [row for row in found.mechanism.said if row.element == "limit of 'second.displacement'"]
    assert row.same.value == "yes"
    results = run(found.scene, duration=0.5)
    np.testing.assert_allclose(results.body("second").position[-1][2], 0.02, atol=1e-12)
