"""`mbproj export --mjcf, --urdf`: read again, a scene accelerates as before, with its ropes; what a format lacks is
said."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbproj import run
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import mobility
from mbproj.formats.as_scene import scene_text
from mbproj.formats.export.exported import Written
from mbproj.formats.export.mjcf import as_mjcf
from mbproj.formats.export.urdf import as_urdf
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.linear.equilibrium.start import start_state
from mbproj.model.euler_parameters import matrix_L
from mbproj.motion.formulations.full import FullFormulation
from mbproj.scene.scene import Scene, read_scene, read_scene_text
from tests.cli.commands import mbproj, succeeds
from tests.formats.agreement import _y
from tests.support import ROOT

# A scene that is exported and imported again: how its bodies accelerate at the start, before and after.


def again(written: Written, folder: Path, ending: str) -> Scene:
    """The scene that is read from what was written."""
    path = folder / f"model.{ending}"
    path.write_text(written.text, encoding="utf-8")
    if written.loops:
        (folder / "model.yaml").write_text(written.loops, encoding="utf-8")
    key = "start" if "<keyframe>" in written.text else None
    return read_scene_text(scene_text(read_model(path, ImportOptions(key=key)), "test"))


def accelerations(scene: Scene) -> dict[str, np.ndarray]:
    """Of each body that moves: that of its centre of mass and its angular one, global, at the assembled start."""
    system = compile_system(scene)
    state = start_state(scene, system)
    pose = pose_of(state.q)
    redundant = sum(mobility(system, pose).redundant.values())
    form = FullFormulation.of(system, state, scene.settings, redundant)
    a = form.accelerations(0.0, _y(form, state)).acceleration.reshape(-1, 7)
    v, L = state.v.reshape(-1, 7), matrix_L(state.q.reshape(-1, 7)[:, 3:])
    omega, alpha = (2.0 * np.einsum("nij,nj->ni", L, rows[:, 3:]) for rows in (v, a))
    found = {}
    for at, body in enumerate(scene.bodies):
        carrier = int(system.body_carrier[at])
        if carrier == system.bodies:
            continue
        R = pose.rotation[carrier]
        arm, w, turned = R @ system.body_offset[at], R @ omega[carrier], R @ alpha[carrier]
        moved = a[carrier, :3] + np.cross(turned, arm) + np.cross(w, np.cross(w, arm))
        found[body.name] = np.concatenate([moved, turned])
    return found


def difference(before: dict[str, np.ndarray], after: dict[str, np.ndarray]) -> float:
    """The largest over the bodies, relative to the largest acceleration, or to that of gravity."""
    scale = max(9.81, max(np.abs(each).max() for each in before.values()))
    return max(float(np.abs(before[name] - after[name]).max()) for name in before) / scale


# `mbproj export --mjcf, --urdf`: read again, a scene accelerates as before; what a format lacks is said.

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
    done = succeeds(*asked, folder=tmp_path)
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


# Ropes and telescopes in `mbproj export --mjcf` are tendons; read again, a scene accelerates as before.

pytest.importorskip("mujoco")
#: Two links that turn in the plane of a rope, which runs over a sheave of the ground and one of the first link.
SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.1 s, tolerance: 1.0e-9, output_step: 10 ms, integrator: dopri5}
bodies:
  a: {mass: 1, inertia: [1, 2, 2.5], position: [0, 0, -0.3], orientation: {axis: [0, 1, 0], angle: 0.2}}
  b: {mass: 2, inertia: [1, 1, 1], position: [0.3, 0, -0.7]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0], speed: 0.5}
  B: {type: revolute, bodies: [a, b], location: [0, 0, -0.6], axis: [0, 1, 0]}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: ground, at: [-1, 0.2, 0.1]}
      - {sheave: ground, at: [0, 0.2, 0.3], radius: 0.1, bends: right}
      - {point: a, at: [0.6, 0.2, 0]}
      - {sheave: a, at: [0.3, 0.2, -0.4], radius: 0.08, bends: left}
      - {point: b, at: [0.2, 0.2, -0.8]}
"""
TELESCOPE = "  rope: {type: telescope, bodies: [ground, b], locations: [[-1, 0, 0.3], [0.4, 0.1, -0.7]], KEYS}\n"


def over_points(text):
    return "\n".join(line for line in text.splitlines() if "sheave" not in line) + "\n"


FORCE = "forces:\n  f: {type: linear_spring_damper, joint: rope, coordinate: length, "
ALIKE = {
    "taut": ("", ""),
    "given its length": ("    length: LENGTH m\n", ""),
    "with a spring": ("    free: true\n", FORCE + "stiffness: 30, free_displacement: 1.5, damping: 2}\n"),
}


@pytest.mark.parametrize("name", ALIKE)
@pytest.mark.parametrize("change", [str, over_points], ids=["sheaves", "points"])
def test_a_rope_accelerates_bodies_as_before(name, change, tmp_path):
    own, more = ALIKE[name]
    text = change(SCENE) + own.replace("LENGTH", "2.6") + more
    scene = read_scene_text(text)
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    assert ("<geom" in written.text) is (change is str)
    back = again(written, tmp_path, "xml")
    assert difference(accelerations(scene), accelerations(back)) < 1e-12
    without = read_scene_text(text.partition("  rope:")[0])
    assert difference(accelerations(scene), accelerations(without)) > 1e-3


@pytest.mark.parametrize(
    "own", ["slack: true", "stiffness: 1 kN/m", "limits: {length: {range: [2 m, LENGTH], rigid: true}}"]
)
def test_a_rope_that_may_be_slack_moves_as_before(own, tmp_path):
    """It is a little longer than its path at the start, and taut before the end."""
    taut = read_scene_text(SCENE)
    start = run(taut, duration=0.01).coordinate("rope.length").value[0] + 1e-4
    own = f"    {own}\n".replace("LENGTH", f"{start} m") + (f"    length: {start} m\n" if "limits" not in own else "")
    scene = read_scene_text(SCENE + own)
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    one, other = (run(each, duration=0.1) for each in (scene, again(written, tmp_path, "xml")))
    for body in ("a", "b"):
        np.testing.assert_allclose(other.body(body).position[-1], one.body(body).position[-1], atol=1e-7)
    assert one.coordinate("rope.length").value.max() > start - 1e-9


def test_what_acts_along_a_telescope_acts_along_a_tendon(tmp_path):
    keys = "reflected_inertia: 0.4"
    text = SCENE.partition("  rope:")[0] + TELESCOPE.replace("KEYS", keys)
    scene = read_scene_text(text + FORCE + "stiffness: 30, free_displacement: 1.5, damping: 2}\n")
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    assert difference(accelerations(scene), accelerations(again(written, tmp_path, "xml"))) < 1e-12


OTHERWISE = {
    "no tendon turns the wheel that it runs over": ("sheave: a", "wheel: a"),
    "no tendon rubs on what it runs over": ("at: [0, 0.2, 0.3]", "at: [0, 0.2, 0.3], friction: 0.2"),
    "no tendon has whole turns around a shape": ("radius: 0.08, bends: left", "radius: 0.08, bends: left, turns: 1"),
    "a tendon has a point between two shapes": (
        "{point: a, at: [0.6, 0.2, 0]}",
        "{sheave: a, at: [0.6, 0.2, 0], radius: 0.05, bends: right}",
    ),
    "it leans at its place 2, and a tendon runs along a helix there": ("at: [-1, 0.2, 0.1]", "at: [-1, 0.21, 0.1]"),
    "what it touches at its place 4 moves out of its plane": (
        "B: {type: revolute, bodies: [a, b]",
        "B: {type: spherical, bodies: [a, b]",
    ),
}


@pytest.mark.parametrize("why", OTHERWISE)
def test_what_no_tendon_says_is_said(why):
    old, new = OTHERWISE[why]
    text = SCENE.replace(old, new)
    if "wheel" in new:
        text = text.replace(", speed: 0.5", "")
    if "spherical" in new:
        text = text.replace("location: [0, 0, -0.6], axis: [0, 1, 0]", "location: [0, 0, -0.6]")
    (row,) = [each for each in as_mjcf(read_scene_text(text), "1").said if each.same.value == "no"]
    assert (row.element, row.what) == ("joint 'rope'", f"left out: {why}")
