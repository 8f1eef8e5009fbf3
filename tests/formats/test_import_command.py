"""`mbproj import`: the table, --strict, --json, and what is said of files that are no model."""

from __future__ import annotations

import json
import shutil

import pytest

from mbproj.base.errors import InputError
from mbproj.formats.read import read_model
from mbproj.scene.scene import read_scene
from tests.cli.commands import mbproj, succeeds
from tests.support import ROOT

DATA = ROOT / "tests" / "data" / "formats"


def test_the_scene_runs_and_the_table_is_short(tmp_path):
    shutil.copy(DATA / "loop_joint.urdf", tmp_path)
    done = succeeds("import", "loop_joint.urdf", "-o", "scene.yaml", folder=tmp_path)
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
    succeeds("import", "r.urdf", "-o", "s.yaml", "--pose", "pose.yaml", "--strict", folder=tmp_path)


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


# What is no scene and no model: said at the file's line, with a next step.


def message(path) -> str:
    with pytest.raises(InputError) as caught:
        read_model(path)
    return "\n".join(problem.line() for problem in caught.value.problems).replace(str(path.parent) + "/", "")


def written(folder, text: str):
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_model_given_as_a_scene_says_how_to_import_it():
    path = DATA / "loops.xml"
    with pytest.raises(InputError, match=rf"a model in MJCF, not a scene; 'mbproj import {path} -o scene.yaml'"):
        read_scene(path)


def test_broken_xml_is_said_at_its_line(tmp_path):
    wrong = message(written(tmp_path, "<mujoco>\n  <worldbody>\n</mujoco>"))
    assert wrong == "model.xml:3:3: error: no well-formed XML: mismatched tag; repair the file there"


def test_entities_are_not_expanded(tmp_path):
    bomb = '<?xml version="1.0"?>\n<!DOCTYPE m [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>\n<mujoco>&b;</mujoco>'
    assert message(written(tmp_path, bomb)).startswith("model.xml:2: error: a document type, which may hide entities")


def test_a_file_of_100_mb_is_not_read(tmp_path):
    path = tmp_path / "large.xml"
    with path.open("wb") as file:
        file.truncate(100_000_000)
    assert message(path).startswith("large.xml: error: the file has 100 MB, and at most 32 MB are read")


def test_other_xml_is_no_model(tmp_path):
    wrong = message(written(tmp_path, "<svg/>"))
    assert wrong.startswith("model.xml:1: error: <svg> begins no model that mbproj reads; a model is MJCF (<mujoco>)")


def test_depth_is_bounded(tmp_path):
    wrong = message(written(tmp_path, "<a>" * 300 + "</a>" * 300))
    assert wrong == "model.xml:1: error: the file has more than 200 levels; split the model"


def test_includes_stay_in_the_folder_and_make_no_circle(tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path.parent / "outside.xml").write_text("<mujocoinclude/>", encoding="utf-8")
    outside = message(written(tmp_path, '<mujoco>\n<include file="../outside.xml"/></mujoco>'))
    assert outside.startswith("model.xml:2: error: the file '../outside.xml' is outside of the model's folder")
    circle = message(written(tmp_path, '<mujoco>\n<include file="model.xml"/></mujoco>'))
    assert circle.startswith("model.xml:2: error: the files include each other in a circle: model.xml -> model.xml")


def test_an_included_file_that_is_missing_is_left_out_and_said(tmp_path):
    """Its name would run in a shell, and means nothing here."""
    pytest.importorskip("mujoco")
    body = '<worldbody><body><joint/><geom size="0.1" pos="0 0 1"/></body></worldbody>'
    mechanism = read_model(written(tmp_path, f'<mujoco>\n<include file="$(id).xml"/>{body}</mujoco>'))
    (row,) = [each for each in mechanism.said if each.element.startswith("include")]
    assert (row.element, row.place.line, row.same.value) == ("include of '$(id).xml'", 2, "no")


MESH = """<mujoco>
  <asset><mesh name="part" file="part.stl"/></asset>
  <worldbody>
    <body name="yes">
      <joint name="1e3" axis="0 1 0"/>{inertial}
      <geom type="mesh" mesh="part"/>
    </body>
  </worldbody>
</mujoco>"""


def test_a_missing_mesh_that_gives_the_mass_is_refused_at_its_line(tmp_path):
    pytest.importorskip("mujoco")
    wrong = message(written(tmp_path, MESH.format(inertial="")))
    assert wrong.startswith("model.xml:6: error: the mass of a body comes from the mesh 'part'")
    assert "model.xml:2: error: the mesh 'part': its file 'part.stl' is not there" in wrong


def test_a_missing_mesh_of_no_weight_is_said(tmp_path):
    pytest.importorskip("mujoco")
    inertial = '<inertial mass="1" pos="0 0 -1" diaginertia="1 1 1"/>'
    mechanism = read_model(written(tmp_path, MESH.format(inertial=inertial)))
    (said,) = [row for row in mechanism.said if row.element == "mesh 'part'"]
    assert said.what == "its file 'part.stl' is not there: it is not drawn"
    assert list(mechanism.joints) == ["_1e3"]
    assert list(mechanism.parts) == ["yes"]


def test_what_mujoco_refuses_is_said_at_the_line(tmp_path):
    pytest.importorskip("mujoco")
    inertial = '<inertial mass="1" pos="0 0 0" diaginertia="-1 1 1"/>'
    wrong = message(written(tmp_path, MESH.format(inertial=inertial).replace("<asset>", "\n<asset>")))
    assert wrong.startswith("model.xml:")
    assert "MuJoCo refuses the model" in wrong
