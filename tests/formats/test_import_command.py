"""`mbproj import`: the table, --strict, --json, and the scene that `check` can run."""

from __future__ import annotations

import json
import shutil

import pytest

from tests.cli.commands import mbproj
from tests.support import ROOT

DATA = ROOT / "tests" / "data" / "formats"


def test_the_scene_runs_and_the_table_is_short(tmp_path):
    shutil.copy(DATA / "loop_joint.urdf", tmp_path)
    done = mbproj("import", "loop_joint.urdf", "-o", "scene.yaml", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "everything in the model has its counterpart in the scene\nscene.yaml\n"
    check = mbproj("check", "scene.yaml", folder=tmp_path)
    assert check.stdout.splitlines()[-1] == "  can run"


def test_a_scene_is_never_replaced(tmp_path):
    shutil.copy(DATA / "loop_joint.urdf", tmp_path)
    (tmp_path / "scene.yaml").write_text("mine", encoding="utf-8")
    done = mbproj("import", "loop_joint.urdf", "-o", "scene.yaml", folder=tmp_path)
    assert done.returncode == 2
    assert (tmp_path / "scene.yaml").read_text(encoding="utf-8") == "mine"


def test_strict_ends_with_4_where_the_motion_is_not_the_models(tmp_path):
    limited = """<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1"/></inertial></link>
      <joint name="j" type="revolute"><parent link="a"/><child link="b"/><limit lower="0.1" upper="1"/></joint>
    </robot>"""
    (tmp_path / "r.urdf").write_text(limited, encoding="utf-8")
    done = mbproj("import", "r.urdf", "-o", "r.yaml", "--json", "--strict", folder=tmp_path)
    assert done.returncode == 4
    (row,) = json.loads(done.stdout)["said"]
    assert row == {
        "element": "limit of joint 'j'",
        "place": "r.urdf:3",
        "what": "left out: the pose is beyond it",
        "same_motion": "no",
    }
    (tmp_path / "pose.yaml").write_text("j: 0.5\n", encoding="utf-8")
    inside = mbproj("import", "r.urdf", "-o", "s.yaml", "--pose", "pose.yaml", "--strict", folder=tmp_path)
    assert inside.returncode == 0, inside.stderr


def test_a_coupler_that_check_would_refuse_is_left_out_and_said(tmp_path):
    """Two angles in the ratio √2 : 2 have no common turn."""
    text = (DATA / "chain.urdf").read_text(encoding="utf-8")
    assert 'multiplier="0.5"' in text
    (tmp_path / "r.urdf").write_text(text.replace('multiplier="0.5"', 'multiplier="0.70710678118654757"'))
    done = mbproj("import", "r.urdf", "-o", "r.yaml", "--strict", "--json", folder=tmp_path)
    assert done.returncode == 4
    (row,) = [each for each in json.loads(done.stdout)["said"] if each["same_motion"] == "no"]
    assert row["element"] == "coupler 'grip_mimic'"
    assert row["place"].startswith("r.urdf:")
    assert "no common measure" in row["what"]
    assert mbproj("check", "r.yaml", folder=tmp_path).returncode == 0


@pytest.mark.parametrize(("pose", "said"), [("j: x", "'j' needs a number"), ("k: 1", "the pose names 'k'")])
def test_a_wrong_pose_is_said(pose, said, tmp_path):
    shutil.copy(DATA / "loop_joint.urdf", tmp_path)
    (tmp_path / "pose.yaml").write_text(f"{pose}\n", encoding="utf-8")
    done = mbproj("import", "loop_joint.urdf", "--pose", "pose.yaml", folder=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr


def test_a_warning_of_mujoco_is_a_note_and_no_file(tmp_path):
    (tmp_path / "total.xml").write_text(
        '<mujoco><compiler settotalmass="2"/><worldbody><body><joint axis="0 1 0"/>'
        '<geom size="0.1" pos="0.2 0 0"/></body></worldbody></mujoco>'
    )
    done = mbproj("import", "total.xml", "-o", "total.yaml", folder=tmp_path)
    assert (done.returncode, "note: MuJoCo: compiler attribute 'settotalmass'" in done.stderr) == (0, True)
    assert {path.name for path in tmp_path.iterdir()} == {"total.xml", "total.yaml"}


def test_a_model_that_cannot_move_is_no_scene(tmp_path):
    (tmp_path / "r.urdf").write_text('<robot name="r"><link name="a"/></robot>')
    done = mbproj("import", "r.urdf", "-o", "r.yaml", folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr == "r.urdf: error: no body of the model can move; a scene needs one: add a joint\n"
    assert not (tmp_path / "r.yaml").exists()
