"""Joints of imported models: adjusted so that loops close, merged where several hold the same, fixed by frames."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import mbproj
from mbproj.base.errors import InputError
from mbproj.equations.assembly.assemble import moved_from_scene
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import mobility
from mbproj.formats.as_scene import scene_text
from mbproj.formats.geometry import turn
from mbproj.formats.read import read_model
from mbproj.linear.equilibrium.start import start_state
from mbproj.scene.scene import read_scene, read_scene_text
from tests.cli.commands import succeeds
from tests.support import ROOT

# One joint in the place of several, which moves as they do: turns with massless links between, two points held.

INERTIAL = '<inertial><origin xyz="0.1 0 -0.4"/><mass value="2"/><inertia ixx="0.05" iyy="0.04" izz="0.02"/></inertial>'


def stacked(axes, offset="0 0 0", ring="", more=""):
    """A URDF whose bob hangs from a frame by turns about these axes, with links between of the content `ring`."""
    names = ["base", *(f"ring_{at}" for at in range(1, len(axes))), "bob"]
    links = [f'<link name="{name}">{ring}</link>' for name in names[1:-1]]
    joints = [
        f'<joint name="turn_{at}" type="continuous"><parent link="{names[at]}"/><child link="{names[at + 1]}"/>'
        f'<origin xyz="{offset if at else "0 0 0"}" rpy="{"0.2 0.1 0.3" if not at else "0 0 0"}"/>'
        f'<axis xyz="{axis}"/></joint>'
        for at, axis in enumerate(axes)
    ]
    bob = f'<link name="bob">{INERTIAL}</link>'
    return f'<robot name="r"><link name="base"/>{"".join(links)}{bob}{"".join(joints)}{more}</robot>'


def read(folder, text):
    (folder / "model.urdf").write_text(text, encoding="utf-8")
    return read_model(folder / "model.urdf")


@pytest.mark.parametrize(
    ("axes", "kind"), [(("1 0 0", "0 1 0"), "universal"), (("1 0 0", "0 1 0", "0 0 1"), "spherical")]
)
def test_the_motion_is_that_of_the_turns(axes, kind, tmp_path):
    """Links of 1e-12 kg m² stay; the bob moves as beside them, to their share."""
    mechanism = read(tmp_path, stacked(axes))
    (joint,) = mechanism.joints.values()
    assert (joint.type, joint.name, list(mechanism.parts)) == (kind, "turn", ["bob"])
    (said,) = [row for row in mechanism.said if row.element.startswith("joints turn_0, turn_1")]
    assert (said.same.value, said.place.line) == ("yes", 1)
    light = '<inertial><mass value="1e-12"/><inertia ixx="1e-12" iyy="1e-12" izz="1e-12"/></inertial>'
    other = read(tmp_path, stacked(axes, ring=light))
    assert [each.type for each in other.joints.values()] == ["revolute"] * len(axes)
    ends = []
    for each in (mechanism, other):
        scene = read_scene_text(scene_text(each, "1").replace("duration: 10 s", "duration: 0.4 s"))
        ends.append(mbproj.run(scene, tolerance=1e-11).body("bob").position[-1])
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)
    assert np.linalg.norm(ends[0] - mechanism.parts["bob"].position) > 0.05


@pytest.mark.parametrize(
    ("axes", "change"),
    [
        (("1 0 0", "0.1 1 0"), {}),  # not at a right angle
        (("1 0 0", "0 1 0"), {"offset": "0 0 0.01"}),  # axes that pass each other
        (("1 0 0", "0 1 0"), {"ring": INERTIAL}),
        (
            ("1 0 0", "0 1 0"),
            {
                "more": '<link name="more"/><joint name="j" type="fixed"><parent link="ring_1"/>'
                '<child link="more"/></joint>'
            },
        ),
    ],
)
def test_turns_stay_where_they_are_no_such_joint(axes, change, tmp_path):
    mechanism = read(tmp_path, stacked(axes, **change))
    assert [joint.type for joint in mechanism.joints.values()][:2] == ["revolute", "revolute"]


@pytest.mark.parametrize(
    "own", ['<dynamics damping="0.1"/>', '<limit lower="-1" upper="1"/>', '<mimic joint="turn_0"/>']
)
def test_a_turn_on_which_something_acts_stays(own, tmp_path):
    text = stacked(("1 0 0", "0 1 0")).replace('<axis xyz="0 1 0"/>', f'<axis xyz="0 1 0"/>{own}')
    text = text.replace('name="turn_1" type="continuous"', 'name="turn_1" type="revolute"')
    assert list(read(tmp_path, text).joints)[:2] == ["turn_0", "turn_1"]


def test_two_of_three_turns_become_universal_where_the_third_is_aside(tmp_path):
    """A gimbal and a hinge at its end, 1 cm off: its own axis does not pass through the crossing."""
    text = stacked(("1 0 0", "0 1 0", "1 0 0")).replace('name="turn_2"', 'name="hinge"')
    text = text.replace('<child link="bob"/><origin xyz="0 0 0"', '<child link="bob"/><origin xyz="0 0.01 0.02"')
    mechanism = read(tmp_path, text)
    assert {name: joint.type for name, joint in mechanism.joints.items()} == {"turn": "universal", "hinge": "revolute"}


FOUR_BAR = """<mujoco><worldbody>
  <body name="crank"><joint name="drive" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.2"/>
    <body name="rod" pos="0 0 0.2"><joint name="knee" axis="0 1 0"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0.1"/></body></body>
  <body name="rocker" pos="0.5 0 0"><joint name="pivot" axis="0 1 0"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.3"/></body></worldbody>
  <equality><connect name="pin" body1="rod" body2="rocker" anchor="0.5 0 0.1"/>{}</equality></mujoco>"""
SECOND = '<connect name="pin_axis" body1="{}" body2="{}" anchor="{}"/>'


def closed(folder, second):
    (folder / "model.xml").write_text(FOUR_BAR.format(second), encoding="utf-8")
    return read_model(folder / "model.xml")


@pytest.mark.parametrize("second", [("rod", "rocker", "0.5 0.3 0.1"), ("rocker", "rod", "0 -0.3 0.3")])
def test_two_points_are_one_hinge_without_a_redundant_row_more(second, tmp_path):
    """A planar four-bar of hinges has one freedom and three redundant rows, with a ball in one of them one less."""
    pytest.importorskip("mujoco")
    hinge, ball = closed(tmp_path, SECOND.format(*second)), closed(tmp_path, "")
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
    text = FOUR_BAR
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


# A spherical parallel wrist, three legs of three revolutes whose axes meet in one point, with rounded numbers.

CENTRE = np.array([0.1, 0.2, 0.3])
X, Y, Z = np.eye(3)


def wrist(digits: int, adjust: str = "") -> str:
    """The scene with all places and axes rounded to so many digits."""

    def written(vector):
        return "[" + ", ".join(f"{float(part):.{digits}f}" for part in vector) + "]"

    bodies = [("plate", CENTRE + 0.05 * Z)]
    joints = []
    for leg in range(3):
        R = turn(Z, 2 * np.pi * leg / 3)
        axes = (
            -R @ turn(Y, 0.5) @ Z,
            R @ turn(X, 0.3) @ turn(Y, 1.2) @ Z,
            R @ turn(Y, 0.9) @ Z,
        )
        chain = ("ground", f"p{leg}", f"d{leg}", "plate")
        for name, axis, arm, ends in zip("UWV", axes, (0.12, 0.1, 0.08), pairwise(chain), strict=True):
            place = written(CENTRE + arm * axis)
            joints.append(
                f"  {name}{leg}: {{type: revolute, bodies: [{', '.join(ends)}], location: {place}, "
                f"axis: {written(axis)}}}"
            )
        bodies += [(f"{word}{leg}", CENTRE + 0.05 * (axes[1] + axes[at])) for word, at in (("p", 0), ("d", 2))]
    rows = [f"  {name}: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: {written(at)}}}" for name, at in bodies]
    asked = f", adjust_joints: {adjust}" if adjust else ""
    head = f"mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {{duration: 0.2 s, step: 1 ms{asked}}}\n"
    return "\n".join([head + "bodies:", *rows, "joints:", *joints]) + "\n"


# `adjust_joints`: loops of rounded numbers close by the least change of the joints, and stay closed as they move.


def freedoms(text: str) -> int:
    scene = read_scene_text(text)
    system = compile_system(scene)
    return mobility(system, pose_of(start_state(scene, system).q)).degrees_of_freedom


@pytest.mark.parametrize("digits", [8, 6])
def test_a_rounded_wrist_is_a_structure_and_turns_about_its_point_when_adjusted(digits):
    """Joints move by less than a rounding of their numbers, 10^-digits m."""
    assert freedoms(wrist(digits)) == 0
    assert freedoms(wrist(digits, "1 um")) == 3
    system = compile_system(read_scene_text(wrist(digits, "1 um")))
    assert len(system.adjustments) == 9
    assert 0.0 < max(change.size(system.length) for change in system.adjustments) < 0.5 * 10.0**-digits


def test_more_than_was_allowed_is_refused_with_what_would_do():
    with pytest.raises(InputError, match=r"adjust_joints is 1 um; .* or give adjust_joints: \d+ um") as caught:
        compile_system(read_scene_text(wrist(4, "1 um")))
    enough = str(caught.value).partition("give adjust_joints: ")[2].split("\n")[0]
    assert freedoms(wrist(4, enough)) == 3


@pytest.mark.parametrize("name", ["bennett", "planar_four_bar", "five_bar", "bricard"])
def test_what_closes_exactly_stays_as_it_is(name):
    text = (ROOT / "mechanisms" / f"{name}.yaml").read_text(encoding="utf-8")
    scene = read_scene_text(text.replace("simulation:\n", "simulation:\n  adjust_joints: 1 mm\n", 1))
    assert scene.settings.adjust_joints == 1e-3
    system, before = compile_system(scene), compile_system(read_scene(ROOT / "mechanisms" / f"{name}.yaml"))
    assert not system.adjustments
    np.testing.assert_array_equal(system.joints.local, before.joints.local)


def test_check_and_run_say_alike_which_joints_moved(tmp_path):
    (tmp_path / "wrist.yaml").write_text(wrist(8, "1 um"), encoding="utf-8")
    check = succeeds("check", "wrist.yaml", folder=tmp_path)
    run = succeeds("run", "wrist.yaml", "-o", "r.h5", folder=tmp_path)
    (note,) = [line for line in check.stderr.splitlines() if "joints were moved so that the loops close" in line]
    assert note in run.stderr.splitlines()
    assert note.startswith("wrist.yaml:3:")


# A fixed joint with a frame in each body, and how far it moves a body from the pose of the scene.

SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 1 s, step: 1 ms}}
bodies:
  arm: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, -1]}}
  lid: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.3, 0, -1]}}
joints:
  pin: {{type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, 1, 0]}}
  weld:
    type: fixed
    bodies: [arm, lid]
    location: {{arm: [0.06, 0, 0], lid: [-0.1, 0, 0]}}
    axes: {{arm: {{axis: [1, 0, 0], angle: 0.4}}, lid: {{axis: [1, 0, 0], angle: 0.1}}}}{reaction}
"""


@pytest.mark.parametrize("reaction", ["", "\n    reaction: true"])
def test_the_frames_meet_whether_the_bodies_are_one_or_two(reaction):
    """The lid shifts by 0.3 - 0.06 - 0.1 = 0.14 m and turns by 0.4 - 0.1 rad; merged or assembled, it ends there."""
    scene = read_scene_text(SCENE.format(reaction=reaction))
    system = compile_system(scene)
    state = start_state(scene, system)
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    shift, turned = moved_from_scene(scene, system, state.q)
    if reaction:  # assembly shares the way between both bodies
        assert 0.0 < shift < 0.14
        arm, lid = pose_of(state.q).rotation[:2]
        np.testing.assert_allclose(arm.T @ lid, turn(np.array([1.0, 0.0, 0.0]), 0.3), atol=1e-13)
    else:
        assert shift == pytest.approx(0.14, abs=1e-12)
        assert turned == pytest.approx(0.3, abs=1e-12)
