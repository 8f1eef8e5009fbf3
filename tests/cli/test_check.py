"""`mbproj check`: redundant rows, motions without mass, singular poses, conditions, tolerances, ropes."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import mbproj
from mbproj.base.errors import InputError
from mbproj.base.mechanisms_folder import mechanism
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene
from mbproj.scene.settings import settings_to_run
from mbproj.studies.record import notes_on
from tests.cli.commands import mbproj as command
from tests.support import ROOT, assembled

PARALLELOGRAM = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {angle: 0 deg, l: 0.3, top_mass: 1}
bodies:
  left: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [l/2*cos(angle), 0, l/2*sin(angle)]}
  top:
    mass: top_mass
    inertia: [0.01*top_mass, 0.01*top_mass, 0.01*top_mass]
    position: [0.25+l*cos(angle), 0, l*sin(angle)]
  right: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.5+l/2*cos(angle), 0, l/2*sin(angle)]}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0], speed: 2}
  B: {type: KIND, bodies: [left, top], location: [l*cos(angle), 0, l*sin(angle)]AXIS}
  C: {type: KIND, bodies: [top, right], location: [0.5+l*cos(angle), 0, l*sin(angle)]AXIS}
  D: {type: revolute, bodies: [right, ground], location: [0.5, 0, 0], axis: [0, 1, 0]}
"""
REVOLUTES = PARALLELOGRAM.replace("KIND", "revolute").replace("AXIS", ", axis: [0, 1, 0]")
BALLS = PARALLELOGRAM.replace("KIND", "spherical").replace("AXIS", "")
GEARS = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  b: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.3, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [ground, b], location: [0.3, 0, 0], axis: [0, 1, 0]}
  G: {type: gear, joints: [A, B], teeth: [20, 10]}
motions:
  one: {joint: A, angle: t**2}
  two: {joint: B, angle: FACTOR*t**2}
"""


def check(folder, text, *arguments):
    (folder / "scene.yaml").write_text(text)
    done = command("check", "scene.yaml", *arguments, folder=folder)
    assert "Traceback" not in done.stderr
    return done


def test_a_regular_scene_gets_one_line(tmp_path):
    done = command("check", str(mechanism("stewart_platform")), folder=tmp_path)
    lines = done.stdout.splitlines()
    at = next(number for number, line in enumerate(lines) if "degrees of freedom" in line)
    start = "  condition of C_q 5.37 as written, 6.03 scaled; far from singular poses (distance 0.3"
    assert lines[at + 1].startswith(start)
    assert lines[at + 2].startswith("  assembled: ")


def test_redundancy_for_good_is_information(tmp_path):
    done = check(tmp_path, REVOLUTES, "--set", "angle=40 deg")
    assert done.returncode == 0
    assert "  3 rows follow from others along the whole motion, without contradiction:\n" in done.stdout
    assert "    3 in A, B, C, D, of the rows along y, about z, about x\n" in done.stdout
    assert "  reactions that are not unique: Fy Tx Tz of A, B, C, D\n" in done.stdout
    assert done.stdout.endswith("  can run, given --duration and --step or --tolerance\n")


def test_a_pose_that_is_singular_by_itself_is_a_problem(tmp_path):
    """Flat, the crank's speed alone does not say on which branch; the accelerations then do not go together."""
    done = check(tmp_path, REVOLUTES)
    assert done.returncode == 4
    assert done.stderr.startswith(
        "scene.yaml:15:3: error: the pose is singular: at it rows of joints depend on each other, and elsewhere they "
        "do not: joint 'D' (along x), joint 'A' (along x), joint 'B' (along x), joint 'C' (along x) in contradiction, "
        "as the accelerations that they ask for differ by "
    )
    assert "; the pose is singular\n" in done.stdout


def test_on_a_branch_the_rows_of_a_singular_pose_agree(tmp_path):
    foot = "location: [0.5, 0, 0], axis: [0, 1, 0]"
    speeds = REVOLUTES.replace(foot, f"{foot}, speed: -2")
    done = check(tmp_path, speeds, "--json")
    (entry,) = [entry for entry in json.loads(done.stdout)["redundancy"]["sets"] if entry["permanent"] is False]
    assert (done.returncode, entry["contradictory"], entry["acceleration_residual"]) == (4, False, 0.0)
    assert {row["holds"] for row in entry["rows"]} == {"along x"}


def test_a_coupler_on_balls_without_mass_spins(tmp_path):
    done = check(tmp_path, BALLS, "--set", "angle=40 deg", "--set", "top_mass=0", "--json")
    facts = json.loads(done.stdout)
    assert (done.returncode, facts["massless_motions"]) == (4, [{"top": "turns about x through its centre of mass"}])
    (problem,) = facts["problems"]
    assert problem["message"].endswith(": 'top' turns about x through its centre of mass")


def test_motions_of_two_wheels_in_mesh_that_disagree_are_a_problem(tmp_path):
    done = check(tmp_path, GEARS.replace("FACTOR", "-3"), "--json")
    facts = json.loads(done.stdout)
    (entry,) = facts["redundancy"]["sets"]
    assert (done.returncode, entry["permanent"], entry["contradictory"]) == (4, True, True)
    assert {row["name"] for row in entry["rows"]} == {"one", "two", "G"}
    assert entry["acceleration_residual"] == pytest.approx(2.0, rel=1e-12)
    (problem,) = facts["problems"]
    assert problem["message"].startswith(
        "motions 'two' and 'one' lock each other: the coordinate that one drives already follows"
    )
    assert "as the accelerations that they ask for differ by 2 rad/s^2" in problem["message"]


def test_motions_of_two_wheels_in_mesh_that_agree_are_none(tmp_path):
    done = check(tmp_path, GEARS.replace("FACTOR", "-2"))
    assert done.returncode == 0
    assert "    1 in G, one, two, of the rows about y\n" in done.stdout


def test_couplers_that_lock_each_other_are_told(tmp_path):
    second = "  H: {type: coupler, of: {A: 1, B: 3}}\n"
    loose = GEARS[: GEARS.index("motions:")]
    assert "nothing can move" not in check(tmp_path, loose).stderr
    told = check(tmp_path, loose + second).stderr
    assert "scene.yaml:10:3: note: nothing can move: with 'G', 'H' the joints leave no degree of freedom" in told


TILTED = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1, tolerance: 1e-8}
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0.05]}
  link: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.2, 0, 0.15]}
  rocker: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.4, 0, 0.1]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: y}
  B: {type: revolute, bodies: [crank, link], location: [0, 0, 0.1], axis: y}
  C: {type: revolute, bodies: [link, rocker], location: [0.4, 0, 0.2], axis: [0, -1, 0]}
  D: {type: revolute, bodies: [ground, rocker], location: [0.4, 0, 0], axis: AXIS}
"""


@pytest.mark.parametrize(
    ("axis", "off"), [("[0.03, 1, 0]", "1.72 deg"), ("[0, -1, 0.001]", "0.0573 deg"), ("y", None), ("[1, 1, 0]", None)]
)
def test_the_axis_that_is_a_little_askew_is_named(tmp_path, axis, off):
    """With atan of its part across. One that is far off is meant to be."""
    text, driven = TILTED.replace("AXIS", axis), "motions: {drive: {joint: A, angle: 2*t}}\n"
    words = f"the axis of joint 'D' is {off} off those of 3 others, which are parallel"
    free, moved = check(tmp_path, text).stderr, check(tmp_path, text + driven)
    assert (words in free, "askew" in free) == (off is not None, False)
    assert (words in moved.stderr) == (off is not None)
    assert moved.returncode == (0 if axis == "y" else 2)


def test_a_frame_is_a_structure(tmp_path):
    text = REVOLUTES.replace(", speed: 2", "").replace("bodies: [top, right]", "bodies: [top, ground]")
    lines = [line for line in text.splitlines(keepends=True) if "right" not in line]
    done = check(tmp_path, "".join(lines), "--set", "angle=40 deg")
    assert done.returncode == 0
    assert "  the joints leave no freedom: a structure, and its dependent rows stay dependent" in done.stdout


def test_a_run_marks_reactions_that_are_not_unique(tmp_path):
    (tmp_path / "scene.yaml").write_text(REVOLUTES)
    arguments = ["--set", "angle=40 deg", "--duration", "0.1", "--step", "0.01", "-o", "out.h5"]
    assert command("run", "scene.yaml", *arguments, folder=tmp_path).returncode == 0
    assert "reactions not unique  Fy Tx Tz of A, B, C, D\n" in command("info", "out.h5", folder=tmp_path).stdout
    facts = json.loads(command("info", "out.h5", "--json", folder=tmp_path).stdout)
    assert facts["reactions_not_unique"] == dict.fromkeys("ABCD", "Fy Tx Tz")
    assert command("export", "out.h5", "--table", "joint-A", folder=tmp_path).returncode == 0
    headings = (tmp_path / "out-joint-A.csv").read_text().splitlines()[0].split(",")
    assert [heading for heading in headings if "reaction" in heading] == [
        "reaction_force_x (N)",
        "reaction_force_y (N; not unique)",
        "reaction_force_z (N)",
        "reaction_torque_x (N m; not unique)",
        "reaction_torque_y (N m)",
        "reaction_torque_z (N m; not unique)",
    ]


# A tolerance below what round-off leaves is pointed out, and no other.


@pytest.mark.parametrize(("tolerance", "notes"), [(1e-14, 0), (1e-16, 1)])
def test_a_tolerance_below_round_off_is_pointed_out(tolerance, notes):
    """The five-bar's coordinates are up to 1.1 m: 4 ε of that is 1e-15 m. Its error falls no further than 1e-13 m."""
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml")
    settings = replace(
        settings_to_run(scene), duration=0.1, step=None, tolerance=tolerance, integrator="dop853", output_step=0.05
    )
    report = simulate(*assembled(scene), settings)
    found = [
        note for note in notes_on(report) if note.text.startswith("the tolerance of 1e-16 is below what round-off")
    ]
    assert len(found) == notes
    assert report.round_off == pytest.approx(1e-15, rel=0.5)


# What `mbproj check` says of ropes.


def test_check_says_how_long_ropes_are_and_how_far_they_wrap():
    """Of a hoist two strands of 3 m and half a turn; of Atwood's machine what its angle leaves of half a turn."""
    radius, length, angle = 0.12, 3.0, 1.0
    hoist = mbproj.check(mechanism("hoist")).facts["ropes_at_start"]["rope"]
    assert hoist["length"] == pytest.approx(2.0 * length + np.pi * radius, abs=1e-12)
    assert hoist["wraps"] == [{"place": 2, "body": "block", "angle": pytest.approx(np.pi)}]
    atwood = mbproj.check(mechanism("swinging_atwood")).facts["ropes_at_start"]["rope"]
    (wrap,) = atwood["wraps"]
    assert (wrap["place"], wrap["body"]) == (2, "wheel")
    assert wrap["angle"] == pytest.approx(np.pi - angle, abs=1e-12)
    assert atwood["length"] == pytest.approx(1.0 + 0.1 * (np.pi - angle) + 0.6, abs=1e-12)


def test_a_scene_without_ropes_says_nothing_of_them():
    assert mbproj.check(mechanism("five_bar")).facts["ropes_at_start"] == {}


FIXED_WHEEL = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 0.5, tolerance: 1e-9}
bodies:
  wheel: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [-0.1, 0, -1]}
joints:
  F: {type: fixed, bodies: [ground, wheel], location: [0, 0, 0]}
  A: {type: prismatic, bodies: [ground, a], location: [-0.1, 0, -1], axis: [0, 0, 1]}
  R:
    type: rope
    normal: [0, -1, 0]
    path: [{point: a, at: [-0.1, 0, -1]}, {wheel: wheel, radius: 0.1, bends: right}, {point: ground, at: [0.1, 0, -1]}]
"""


def test_a_wheel_that_a_fixed_joint_holds_is_no_sheave():
    """The rope does not slide over a wheel: over one that does not turn it would not move at all."""
    with pytest.raises(InputError, match=r"11:3: error: the wheel 'wheel' of the rope 'R' does not turn.*'sheave'"):
        mbproj.check(mbproj.read_scene_text(FIXED_WHEEL))
    assert (
        mbproj.check(mbproj.read_scene_text(FIXED_WHEEL.replace("{wheel: wheel", "{sheave: wheel"))).degrees_of_freedom
        == 0
    )
