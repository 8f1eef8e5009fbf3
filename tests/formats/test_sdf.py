"""SDF: a tree moves as the same in MJCF, loops are what the graph is, couplings turn as their ratios say."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbproj import check
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
from tests.crossed import some
from tests.formats.agreement import agreement
from tests.support import ROOT

DATA = ROOT / "tests" / "data" / "formats"


def started(mechanism):
    """The scene of a mechanism with its system and its state at the start."""
    text = scene_text(mechanism, "1")
    assert max(map(len, text.splitlines())) <= 100
    scene = read_scene_text(text)
    system = compile_system(scene)
    return scene, system, start_state(scene, system)


def test_a_tree_moves_as_the_same_in_mjcf():
    """Nested models, frames by name, axes in other frames, degrees, a quaternion, shapes that weigh, springs."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(DATA / "stack_in_mujoco.xml"))
    found = agreement(DATA / "stack.sdf", model=model)
    assert max(found) < 1e-10


def test_a_loop_is_what_the_graph_of_joints_is():
    """The rod ends at [0.5 cos 0.2, 0, 0.2 + 0.5 sin 0.2], where the included rocker hangs by its frame 'top'."""
    mechanism = read_model(DATA / "four_bar.sdf")
    assert [mechanism.joints[name].type for name in ("drive", "knee", "foot", "elbow")] == ["revolute"] * 4
    assert set(mechanism.joints) - mechanism.tree == {"elbow"}
    assert list(mechanism.parts) == ["crank", "bar", "rod"]
    end = [0.5 * math.cos(0.2), 0.0, 0.2 + 0.5 * math.sin(0.2)]
    np.testing.assert_allclose(mechanism.parts["bar"].position, [end[0], 0.0, end[2] - 0.15], atol=1e-14)
    _, system, state = started(mechanism)
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    assert mobility(system, pose_of(state.q)).degrees_of_freedom == 1
    assert mechanism.gravity[2] == -9.81


def test_a_pose_moves_the_tree_and_leaves_its_loop_to_the_start():
    mechanism = read_model(DATA / "four_bar.sdf", ImportOptions(pose={"drive": 0.1}))
    np.testing.assert_allclose(mechanism.parts["crank"].position, [0.1 * math.sin(0.1), 0, 0.1 * math.cos(0.1)])
    _, system, state = started(mechanism)
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    with pytest.raises(InputError, match="joint 'elbow' closes a loop"):
        read_model(DATA / "four_bar.sdf", ImportOptions(pose={"elbow": 0.1}))


def test_couplings_turn_as_their_ratios_say():
    """θ₂ = -2.5 θ₁ against the frame, where 'out' counts the frame against the wheel; s = 0.1 (φ - 0.2) + 0.03."""
    joints = read_model(DATA / "couplings.sdf").joints
    assert joints["mesh"].keys["of"] == {"out.angle": -1.0, "in.angle": 2.5}
    assert joints["close_mimic"].keys["of"] == {"close.displacement": 1.0, "in.angle": -0.1}
    assert joints["close_mimic"].keys["constant"] == pytest.approx(0.01)
    assert joints["in"].keys["reflected_inertia"].value == pytest.approx(2e-5 * 50**2)
    assert joints["thread"].keys["pitch"].value == 0.02


def test_the_screw_of_older_files_is_the_same(tmp_path):
    text = (DATA / "couplings.sdf").read_text(encoding="utf-8")
    now, before = "<screw_thread_pitch>0.02</screw_thread_pitch>", f"<thread_pitch>{-2 * math.pi / 0.02}</thread_pitch>"
    assert now in text
    (tmp_path / "old.sdf").write_text(text.replace(now, before), encoding="utf-8")
    assert read_model(tmp_path / "old.sdf").joints["thread"].keys["pitch"].value == pytest.approx(0.02, rel=1e-14)


APART = """<sdf version="1.7"><model name="m">
  <!-- *------* a drawing that XML forbids -->
  <link name="bar"><inertial><mass>1</mass></inertial></link>
  <frame name="post" attached_to="world"><pose>0 2 0 0 0 0</pose></frame>
  <joint name="pin" type="revolute"><parent>post</parent><child>bar</child><axis><xyz>1 0 0</xyz></axis></joint>
</model></sdf>"""


def test_frames_of_a_joint_meet_on_request(tmp_path):
    (tmp_path / "apart.sdf").write_text(APART, encoding="utf-8")
    mechanism = read_model(tmp_path / "apart.sdf")
    (row,) = mechanism.said
    assert row.place.line == 5
    assert "2 m away: --meet joins both" in row.what
    np.testing.assert_allclose(mechanism.parts["bar"].position, 0.0)
    met = read_model(tmp_path / "apart.sdf", ImportOptions(meet=True))
    np.testing.assert_allclose(met.parts["bar"].position, [0.0, 2.0, 0.0])
    assert not met.said


def test_a_merged_include_stands_in_its_scope(tmp_path):
    (tmp_path / "part").mkdir()
    (tmp_path / "part" / "model.sdf").write_text((DATA / "rocker" / "model.sdf").read_text(encoding="utf-8"))
    outer = """<sdf version="1.9"><model name="m">
      <include merge="true"><uri>part</uri><pose>1 0 0 0 0 0</pose></include>
      <joint name="pin" type="revolute"><parent>world</parent><child>bottom</child><axis><xyz>0 1 0</xyz></axis></joint>
      </model></sdf>"""
    (tmp_path / "m.sdf").write_text(outer, encoding="utf-8")
    mechanism = read_model(tmp_path / "m.sdf")
    np.testing.assert_allclose(mechanism.parts["bar"].position, [1.0, 0.0, -0.15])


def test_links_of_static_models_are_the_ground_and_others_names_are_kept(tmp_path):
    model = '<model name="{}"><static>{}</static><link name="link"/></model>'
    world = f'<sdf version="1.9"><world name="w">{model.format("a", 1)}{model.format("b", 0)}{model.format("c", 0)}'
    (tmp_path / "w.sdf").write_text(world + "</world></sdf>", encoding="utf-8")
    mechanism = read_model(tmp_path / "w.sdf")
    assert list(mechanism.parts) == ["b_link", "c_link"]
    assert mechanism.parts["b_link"].mass == 1.0


LINK = '<link name="a"/>'
WRONG = {
    "": "model.sdf:1: error: the model has no link",
    f"{LINK}\n{LINK}": "model.sdf:3: error: <link> has a second 'a'",
    f'{LINK}\n<joint name="j" type="hinge"/>': "model.sdf:3: error: unknown joint type 'hinge'",
    f'{LINK}\n<joint name="j" type="ball"><child>a</child></joint>': "model.sdf:3: error: joint 'j' has no <parent>",
    f'{LINK}\n<joint name="j" type="ball"><parent>world</parent><child>b</child></joint>': (
        "model.sdf:3: error: unknown frame 'b'"
    ),
    f'{LINK}\n<joint name="j" type="revolute"><parent>world</parent><child>a</child></joint>': (
        "model.sdf:3: error: joint 'j' has no <axis>"
    ),
    f'{LINK}\n<frame name="f"><pose relative_to="g"/></frame>\n<frame name="g"><pose relative_to="f"/></frame>'
    '<joint name="j" type="ball"><parent>f</parent><child>a</child><pose relative_to="f"/></joint>': (
        "model.sdf:3: error: the frames that 'f' stands in go in a circle"
    ),
    '<link name="a"><inertial><inertia>\n<ixx>-1</ixx></inertia></inertial></link>': (
        "model.sdf:2: error: the inertia has a negative principal moment"
    ),
    '<link name="a">\n<pose>1 2</pose></link>': "model.sdf:3: error: <pose> takes 6 finite numbers, found '1 2'",
    '<link name="a">\n<pose rotation_format="quat_xyzw">0 0 0 0 0 0 0</pose></link>': (
        "model.sdf:3: error: the quaternion has no direction"
    ),
    '<link name="a"><inertial auto="true"/><collision><geometry>\n<mesh/></geometry></collision></link>': (
        "model.sdf:3: error: the inertia of a <mesh> is not computed"
    ),
    f"{LINK}\n<include><uri>https://fuel.gazebosim.org/x</uri></include>": "model.sdf:3: error: 'https://fuel",
    f"{LINK}\n<include><uri>../out.sdf</uri></include>": (
        "model.sdf:3: error: the file '../out.sdf' is outside of the model's folder"
    ),
    f"{LINK}\n<include><uri>model.sdf</uri></include>": (
        "model.sdf:3: error: the files include each other in a circle: model.sdf -> model.sdf"
    ),
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_said_at_its_line(text, tmp_path):
    path = tmp_path / "model.sdf"
    path.write_text(f'<sdf version="1.9"><model name="m">\n{text}\n</model></sdf>', encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert caught.value.problems[0].line().replace(f"{tmp_path}/", "").startswith(WRONG[text])


def test_what_may_act_on_the_motion_is_said_at_its_line(tmp_path):
    more = """<model name="m">
<plugin filename="gz-sim-joint-controller-system" name="c"/>
<plugin filename="gz-sim-joint-state-publisher-system" name="s"/>"""
    text = (DATA / "couplings.sdf").read_text(encoding="utf-8").replace('<model name="couplings">', more)
    path = tmp_path / "model.sdf"
    path.write_text(text, encoding="utf-8")
    first = text[: text.index("<model")].count("\n") + 1
    said = {row.place.line: row.same.value for row in read_model(path).said if row.place is not None}
    assert (said[first + 1], said[first + 2]) == ("no", "yes")


#: A planar four-bar on its side: its plane is turned by the model's pose.
ON_ITS_SIDE = """<?xml version="1.0"?>
<sdf version="1.9">
  <model name="on_its_side">
    <pose>0.2 0 0.7 {angles}</pose>
    {links}
    {joints}
  </model>
</sdf>"""
LINKS = {"crank": (0.04, 0.09), "coupler": (0.3, 0.24), "rocker": (0.48, 0.15)}
HINGES = {
    "A": ("world", "crank", (-0.04, -0.09)),
    "B": ("crank", "coupler", (-0.22, -0.06)),
    "C": ("coupler", "rocker", (0.04, 0.15)),
    "D": ("world", "rocker", (-0.04, -0.15)),
}


def on_its_side(angles):
    """The text of the model with the roll, pitch and yaw of its pose, in rad, as somebody typed them."""
    inertia = "<ixx>0.02</ixx><iyy>0.02</iyy><izz>0.02</izz>"
    links = "".join(
        f'<link name="{name}"><pose>{x} {y} 0 0 0 0</pose><inertial><mass>1</mass>'
        f"<inertia>{inertia}</inertia></inertial></link>"
        for name, (x, y) in LINKS.items()
    )
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child>'
        f"<pose>{x} {y} 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint>"
        for name, (parent, child, (x, y)) in HINGES.items()
    )
    return ON_ITS_SIDE.format(angles=angles, links=links, joints=joints)


@pytest.mark.parametrize(
    "angles",
    some(["1.5707963 0 0", "1.570796 0 0", "1.57079633 0 3.1415927", "1.5708 0 0", "0 1.57079633 0", "0.3 -0.7 2"], 2),
)
def test_a_loop_on_its_side_is_as_free_as_upright_however_its_angles_are_rounded(angles, tmp_path):
    path = tmp_path / "side.sdf"
    path.write_text(on_its_side(angles), encoding="utf-8")
    found = check(str(read_model_to(path, tmp_path)))
    assert found.can_run and found.degrees_of_freedom == 1
    assert found.diagnosis.verdict == "far from singular poses"
    path.write_text(on_its_side("0 0 0"), encoding="utf-8")
    upright = check(str(read_model_to(path, tmp_path)))
    distances = [each.diagnosis.conditioning.distance for each in (found, upright)]
    assert distances[0] == pytest.approx(distances[1], rel=1e-6)


def read_model_to(path, folder):
    """The path of the scene that a model becomes."""
    scene = folder / "scene.yaml"
    scene.write_text(scene_text(read_model(path), "1"), encoding="utf-8")
    return scene


def test_a_ball_meets_without_an_axis(tmp_path):
    """Its frame in the child stands 0.3 m from that in the parent, and meets it there."""
    (tmp_path / "m.sdf").write_text(
        '<sdf version="1.9"><model name="m"><link name="a"/><frame name="f" attached_to="a"><pose>0.3 0 0 0 0 0</pose>'
        '</frame><joint name="j" type="ball"><parent>world</parent><child>f</child></joint></model></sdf>',
        encoding="utf-8",
    )
    mechanism = read_model(tmp_path / "m.sdf", ImportOptions(meet=True))
    assert mechanism.joints["j"].type == "spherical"
    assert mechanism.parts["a"].position == pytest.approx([-0.3, 0.0, 0.0], abs=1e-15)
