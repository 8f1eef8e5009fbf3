"""`mbproj export --mjcf, --urdf`: read again, a scene accelerates as before; what a format lacks is said."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mbproj.formats.export.mjcf import as_mjcf
from mbproj.formats.export.urdf import as_urdf
from mbproj.formats.read import read_model
from mbproj.scene.scene import read_scene, read_scene_text
from tests.cli.commands import mbproj
from tests.formats.round_trip import accelerations, again, difference
from tests.support import ROOT

MECHANISMS = ROOT / "mechanisms"
#: Loops of each kind, springs between points, springs of joints, universal and cylindrical joints, couplings, speeds.
SAID_ALL = (
    *("bennett", "bricard", "delta_robot", "double_pendulum", "five_bar", "governor", "heavy_top", "hooke_shaft"),
    *("locomotive", "physical_pendulum", "quarter_car", "spatial_four_bar", "spatial_slider_crank", "stewart_platform"),
)


@pytest.mark.parametrize("name", SAID_ALL)
def test_a_scene_accelerates_as_before_after_mjcf(name, tmp_path):
    pytest.importorskip("mujoco")
    scene = read_scene(MECHANISMS / f"{name}.yaml")
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    assert difference(accelerations(scene), accelerations(again(written, tmp_path, "xml"))) < 1e-12


@pytest.mark.parametrize("name", ["delta_robot", "bennett", "locomotive", "planar_four_bar", "stewart_platform"])
def test_a_scene_accelerates_as_before_after_urdf(name, tmp_path):
    """At rest and under the gravity that readers of URDF take, with its loops in the YAML file beside it."""
    text = (MECHANISMS / f"{name}.yaml").read_text(encoding="utf-8")
    scene = _at_rest(read_scene_text(text))
    written = as_urdf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    assert "closed_loop:" in written.loops
    assert difference(accelerations(scene), accelerations(again(written, tmp_path, "urdf"))) < 1e-12


def _at_rest(scene):
    bodies = tuple(replace(body, velocity=(0.0,) * 3, angular_velocity=(0.0,) * 3) for body in scene.bodies)
    joints = tuple(replace(joint, speed={}) for joint in scene.joints)
    return replace(scene, bodies=bodies, joints=joints, gravity=(0.0, 0.0, -9.81))


@pytest.mark.parametrize("angle", [0.0, -180.0])
def test_a_geneva_drive_is_no_polynomial_where_it_rests_either(angle):
    """At 180 degrees its wheel is held over more than two rad to both sides."""
    text = (MECHANISMS / "geneva.yaml").read_text(encoding="utf-8")
    text = text.replace("speed: slowest", f"angle: {angle} deg, speed: slowest")
    text = text.replace(
        "location: [distance, 0, 0], axis: [0, -1, 0]", "location: [distance, 0, 0], axis: -y, angle: TURNED"
    )
    text = text.replace("TURNED", "45 deg" if angle else "0 deg")
    said = {row.element: row.same.value for row in as_mjcf(read_scene_text(text), "1").said}
    assert said["coupler 'drive'"] == "no"


ALL = """
mbproj: 1
gravity: [0, 1, -9.81]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  a: {mass: 1, inertia: [1, 2, 2.5, 0.1, 0.2, 0.3], position: [0, 0, 0], orientation: {axis: [1, 2, 3], angle: 0.7}}
  b: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0.2]}
  c: {mass: 3, inertia: [2, 3, 4], position: [1, 1, 0.2]}
  d: {mass: 3, inertia: [2, 3, 4], position: [1, 2, 0.2], velocity: [0, 0, 1], angular_velocity: [0.1, 0.2, 0.3]}
  e: {mass: 1, inertia: [1, 1, 1], position: [3, 2, 0.2]}
  nut: {mass: 1, inertia: [1, 1, 1], position: [5, 0, 0]}
joints:
  A:
    type: revolute
    bodies: [a, ground]
    location: [0, 0.1, 0.2]
    axis: [1, 0, 1]
    speed: 0.5
    reflected_inertia: 0.2
    angle: 0.3
  B: {type: cylindrical, bodies: [b, a], location: [0.5, 0, 0], axis: [1, 0, 0], speed: {angle: 0.3}}
  C: {type: planar, bodies: [c, b], location: [1, 0.5, 0.2], axis: [0, 1, 0.5]}
  D: {type: spherical, bodies: [c, d], location: [1, 1.4, 0.2]}
  E: {type: universal, bodies: [e, d], location: [2, 2, 0.2], axes: [[0, 0, 1], [0, 1, 0]], speed: {angle_1: 1}}
  S: {type: screw, bodies: [ground, nut], location: [5, 0, 0], axis: [0, 0, 1], pitch: 0.1}
  sum: {type: coupler, of: {A: 1, B.angle: -2, S.angle: 0.5}}
  bend: {type: coupler, of: {B.displacement: 0, C.displacement_x: 1}, function: 0.3*s - 0.2*s**2 + 0.1*s**4}
forces:
  one: {type: torsion_spring_damper, joint: A, stiffness: 3, damping: 0.2, free_angle: 0.5}
  two: {type: torsion_spring_damper, joint: A, stiffness: 2}
  rail: {type: linear_spring_damper, joint: B, coordinate: displacement, stiffness: 30, damping: 1}
  line: {type: spring_damper, points: {c: [1, 1, 0.5], ground: [0, 3, 1]}, stiffness: 5, damping: 1}
"""


def test_each_joint_either_way_round_and_all_that_acts_on_it(tmp_path):
    """Axes off the body's, inertias off the diagonal, sums of three coordinates, a polynomial, a spring of springs."""
    pytest.importorskip("mujoco")
    scene = read_scene_text(ALL)
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    back = again(written, tmp_path, "xml")
    assert {joint.type for joint in back.joints} >= {"cylindrical", "spherical", "universal", "coupler"}
    assert difference(accelerations(scene), accelerations(back)) < 1e-12


POINTS = """
mbproj: 1
gravity: [0, 1, -9.81]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  a: {mass: 1, inertia: [1, 2, 2.5], position: [0, 0, 0], angular_velocity: [0.1, 0.2, 0.3]}
  b: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0.2]}
joints:
  A: {type: JOINT, bodies: [ENDS], location: [0, 0.1, 0.2], axis: [1, 0, 1], SPEED}
  B: {type: revolute, bodies: [a, b], location: [1, 0.5, 0.2], axis: [0, 1, 0.5], speed: 0.3}
forces:
  F: {type: linear_spring_damper, joint: A, coordinate: COORDINATE, stiffness: 3, damping: 0.2}
"""


@pytest.mark.parametrize("ends", ["ground, a", "a, ground"])
@pytest.mark.parametrize(
    ("kind", "coordinate"), [("point_on_line", "displacement"), ("point_in_plane", "displacement_y")]
)
def test_a_point_on_a_line_is_a_slide_and_a_ball(kind, coordinate, ends, tmp_path):
    pytest.importorskip("mujoco")
    speed = "speed: 0.5" if kind == "point_on_line" else "speed: {displacement_y: 0.5}"
    text = POINTS.replace("JOINT", kind).replace("ENDS", ends).replace("COORDINATE", coordinate).replace("SPEED", speed)
    scene = read_scene_text(text)
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    assert difference(accelerations(scene), accelerations(again(written, tmp_path, "xml"))) < 1e-12


def test_pistons_of_four_cylinders_close_no_loops(tmp_path):
    """Their pins slide, and the rods' hinges are what closes the loops."""
    pytest.importorskip("mujoco")
    text = (MECHANISMS / "inline_four.yaml").read_text(encoding="utf-8")
    scene = replace(read_scene_text(text), motions=())
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    assert difference(accelerations(scene), accelerations(again(written, tmp_path, "xml"))) < 1e-12


def test_what_a_format_lacks_is_said(tmp_path):
    scene = read_scene(MECHANISMS / "drum_brake.yaml")
    said = {row.element: row.same.value for row in as_mjcf(scene, "1").said}
    assert said["friction 'drag'"] == "no"
    assert said["force 'spring'"] == "no"
    of_cam = {row.element: row.same.value for row in as_mjcf(read_scene(MECHANISMS / "cam.yaml"), "1").said}
    assert of_cam["joint 'K'"] == "no"
    in_urdf = {row.element: row.same.value for row in as_urdf(read_scene(MECHANISMS / "governor.yaml"), "1").said}
    assert in_urdf["velocities at the start"] == "no"
    assert in_urdf["force 'spring'"] == "no"


def test_the_command_writes_both_and_replaces_only_its_own(tmp_path):
    (tmp_path / "planar_four_bar.yaml").write_bytes((MECHANISMS / "planar_four_bar.yaml").read_bytes())
    asked = ("export", "planar_four_bar.yaml", "--mjcf", "m.xml", "--urdf", "u.urdf")
    done = mbproj(*asked, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-3:] == ["m.xml", "u.urdf", "u.yaml"]
    strict = mbproj(*asked, "--json", "--strict", folder=tmp_path)
    assert strict.returncode == 4  # it begins in motion, and a URDF at rest
    (row,) = [each for each in json.loads(strict.stdout)["said"] if each["same_motion"] == "no"]
    assert row["element"] == "velocities at the start"
    (tmp_path / "m.xml").write_text("<mujoco/>", encoding="utf-8")
    refused = mbproj(*asked, folder=tmp_path)
    assert refused.returncode == 2
    assert (tmp_path / "m.xml").read_text(encoding="utf-8") == "<mujoco/>"


def test_loops_never_replace_the_scene(tmp_path):
    (tmp_path / "planar_four_bar.yaml").write_bytes((MECHANISMS / "planar_four_bar.yaml").read_bytes())
    done = mbproj("export", "planar_four_bar.yaml", "--urdf", "planar_four_bar.urdf", "--force", folder=tmp_path)
    assert done.returncode == 2
    assert "the loops of 'planar_four_bar.urdf' belong in 'planar_four_bar.yaml', which is the scene" in done.stderr


def test_numbers_read_back_as_they_are():
    from mbproj.formats.export.exported import tag

    values = np.array([0.1, 1 / 3, 1e-7, 12345678.9])
    text = tag("a", x=values).attributes["x"]
    assert [float(each) for each in text.split()] == values.tolist()


@pytest.mark.parametrize("ending", ["xml", "urdf"])
def test_a_universal_joint_comes_back_with_its_name(ending, tmp_path):
    """An export writes two hinges, which are named after the joint and its angles."""
    scene = read_scene(ROOT / "mechanisms" / "hooke_shaft.yaml")
    names = {joint.name for joint in scene.joints if joint.type == "universal"}
    if ending == "xml":
        pytest.importorskip("mujoco")
    written = as_mjcf(scene, "1") if ending == "xml" else as_urdf(scene, "1")
    (tmp_path / f"m.{ending}").write_text(written.text, encoding="utf-8")
    if written.loops:
        (tmp_path / "m.yaml").write_text(written.loops, encoding="utf-8")
        assert max(map(len, written.loops.splitlines())) <= 100
    found = read_model(tmp_path / f"m.{ending}").joints
    assert names
    assert {name for name, joint in found.items() if joint.type == "universal"} == names


@pytest.mark.parametrize("write", [as_mjcf, as_urdf])
def test_a_force_that_is_an_element_is_left_out_and_said(write):
    """A spring and a damper in series, between points and in a joint: a tendon without stiffness is none of them."""
    scene = read_scene_text("""\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: y}}
forces:
  line: {type: maxwell, points: {ground: [0, 0, 1], rod: [0.5, 0, 0]}, stiffness: 2e4, damping: 300}
  seal: {type: torsion_maxwell, joint: A, stiffness: 40, damping: 2}
""")
    written = write(scene, "1")
    lost = {row.element: row.what for row in written.said if row.same.value == "no"}
    assert set(lost) == {"force 'line'", "force 'seal'"}
    assert lost["force 'seal'"] == "left out: no model has the type torsion_maxwell"
    assert "<tendon" not in written.text


def test_a_telescope_is_a_tendon_where_something_acts_along_it(tmp_path):
    """A spring with a damper along it comes back with its force; one that holds and bears nothing has no say."""
    scene = read_scene_text("""\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {boom: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints:
  A: {type: revolute, bodies: [ground, boom], location: [0, 0, 0], axis: y, speed: 0.7}
  lift: {type: telescope, bodies: [ground, boom], locations: [[0, 0, -1], [1, 0, 0]]}
  idle: {type: telescope, bodies: [ground, boom], locations: [[0, 1, -1], [1, 0, 0]]}
forces:
  oil: {type: linear_spring_damper, joint: lift, stiffness: 40, damping: 3, free_displacement: 1.1}
""")
    written = as_mjcf(scene, "1")
    assert {row.element: row.same.value for row in written.said if "joint" in row.element} == {"joint 'idle'": "yes"}
    assert not [row for row in written.said if row.same.value == "no"]
    assert difference(accelerations(scene), accelerations(again(written, tmp_path, "xml"))) < 1e-12
    lost = {row.element for row in as_urdf(scene, "1").said if row.same.value == "no"}
    assert lost == {"what acts on 'lift.length'", "velocities at the start"}
