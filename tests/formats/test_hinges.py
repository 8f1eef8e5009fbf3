"""Two points that are held between the same bodies are a revolute joint, which moves as they do."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.dynamics import mobility
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.formats import read_model, scene_text
from mbproj.linear.equilibrium.started import start_state
from mbproj.model import compile_system
from mbproj.scene import read_scene, read_scene_text
from tests.support import ROOT

MODEL = """<mujoco><worldbody>
  <body name="crank"><joint name="drive" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.2"/>
    <body name="rod" pos="0 0 0.2"><joint name="knee" axis="0 1 0"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0.1"/></body></body>
  <body name="rocker" pos="0.5 0 0"><joint name="pivot" axis="0 1 0"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.3"/></body></worldbody>
  <equality><connect name="pin" body1="rod" body2="rocker" anchor="0.5 0 0.1"/>{}</equality></mujoco>"""
SECOND = '<connect name="pin_axis" body1="{}" body2="{}" anchor="{}"/>'


def read(folder, second):
    (folder / "model.xml").write_text(MODEL.format(second), encoding="utf-8")
    return read_model(folder / "model.xml")


@pytest.mark.parametrize("second", [("rod", "rocker", "0.5 0.3 0.1"), ("rocker", "rod", "0 -0.3 0.3")])
def test_two_points_are_one_hinge_without_a_redundant_row_more(second, tmp_path):
    """A planar four-bar of hinges has one freedom and three redundant rows, with a ball in one of them one less."""
    pytest.importorskip("mujoco")
    hinge, ball = read(tmp_path, SECOND.format(*second)), read(tmp_path, "")
    assert (hinge.joints["pin"].type, ball.joints["pin"].type, len(hinge.joints)) == ("revolute", "spherical", 4)
    np.testing.assert_allclose(np.abs(hinge.joints["pin"].axes), [[0, 1, 0], [0, 1, 0]], atol=1e-15)
    (said,) = [row for row in hinge.said if row.element == "joints 'pin' and 'pin_axis'"]
    assert (said.same.value, said.place.line) == ("yes", 7)
    counts, ends = [], []
    for each in (hinge, ball):
        scene = read_scene_text(scene_text(each, "1"))
        system = compile_system(scene)
        found = mobility(system, pose_of(start_state(scene, system).q))
        counts.append((found.degrees_of_freedom, system.constraints - found.rank))
        ends.append(mbproj.run(scene, duration=0.5, tolerance=1e-11).body("crank").position[-1])
    assert counts == [(1, 3), (1, 1)]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-10)


@pytest.mark.parametrize(
    "second",
    [
        SECOND.format("rod", "rocker", "0.5 0 0.1"),  # the same point
        SECOND.format("crank", "rocker", "0 0.3 0.1"),  # another body
        '<connect name="pin_axis" site1="a" site2="b"/>',  # farther apart in one body than in the other
        SECOND.format("rod", "rocker", "0.5 0.3 0.1") + SECOND.format("rod", "rocker", "0 0.3 0").replace("axis", "3"),
    ],
)
def test_points_that_make_no_hinge_stay(second, tmp_path):
    pytest.importorskip("mujoco")
    text = MODEL
    for name, end in (("a", "0.5 0 0.1"), ("b", "0 0 0.3")):
        site = f'<site name="{name}" pos="{end.replace(" 0 ", " 0.3 " if name == "a" else " 0.300001 ", 1)}"/>'
        text = text.replace(f'{end}"/></body>', f'{end}"/>{site}</body>', 1)
    assert 'name="a"' in text
    assert 'name="b"' in text
    (tmp_path / "model.xml").write_text(text.format(second), encoding="utf-8")
    loops = {name: joint.type for name, joint in read_model(tmp_path / "model.xml").joints.items() if "pin" in name}
    assert set(loops.values()) == {"spherical"}
    assert len(loops) == 1 + second.count("<connect")


def test_a_hinge_comes_back_from_urdf_and_its_frames_are_markers(tmp_path):
    """An export writes two frames on its axis in each body, as links without mass that are fixed to it."""
    written = mbproj.export_model(ROOT / "mechanisms" / "n_four_bar.yaml", "urdf")
    (tmp_path / "m.urdf").write_text(written.text, encoding="utf-8")
    (tmp_path / "m.yaml").write_text(written.loops, encoding="utf-8")
    mechanism = read_model(tmp_path / "m.urdf")
    assert {joint.type for joint in mechanism.joints.values()} == {"revolute"}
    assert len(mechanism.joints) == len(read_scene(ROOT / "mechanisms" / "n_four_bar.yaml").joints)
    assert all(part.mass for part in mechanism.parts.values())
    assert len(mechanism.markers) >= 4
