"""Notes on what may be a mistake: angles in degrees, bodies that nothing holds, joints far from their bodies."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from mbproj.scene import read_scene, read_scene_text
from mbproj.scene.blocks.oversights import notes_on
from tests.cli.commands import mbproj
from tests.scene.scenes import changed, read
from tests.support import MECHANISMS

ROD = "{mass: 1, inertia: [0.001, 0.1, 0.1], position: [0, 0, 0]}"  # 1.1 m long
BALL = "{mass: 1, inertia: [0.001, 0.001, 0.001], position: [0, 0, 0]}"


def notes(text: str) -> list[str]:
    return [note.line("note") for note in notes_on(read_scene_text(text, "f.yaml"))]


def scene(bodies: str, joints: str = "", more: str = "") -> str:
    return f"mbproj: 1\ngravity: [0, 0, 0]\nbodies:\n{bodies}\njoints:\n{joints}\n{more}"


@pytest.mark.parametrize("path", MECHANISMS, ids=lambda path: path.stem)
def test_there_are_none_on_the_shipped_mechanisms(path: Path) -> None:
    assert notes_on(read_scene(path)) == []


DEGREES = [
    ("angle: 90 deg}", "angle: 90}", 90.0),
    ("speed: 6 rad/s}", "speed: 6 rad/s, angle: -22.5}", -22.5),
    ("markers:", "motions:\n  m: {joint: A, angle: {smooth_step: {to: 180, duration: 1}}}\nmarkers:", 180.0),
    ("markers:", "motions:\n  m: {joint: A, angle: 45}\nmarkers:", 45.0),
]


@pytest.mark.parametrize(("old", "new", "number"), DEGREES)
def test_a_plain_whole_number_of_many_turns_may_be_in_degrees(old: str, new: str, number: float) -> None:
    (note,) = read(changed(old, new)).notes
    assert note.message.endswith(f"is {number:g} rad, {abs(number) / (2 * math.pi):.3g} turns")
    assert note.hint == f"did you mean {number:g} deg? ({number:g} rad says that it is in radians)"


@pytest.mark.parametrize("angle", ["12", "62.8319", "90 rad", "90 deg", "3 * 30", "30*pi", "rod_length"])
def test_other_angles_are_not_noted(angle: str) -> None:
    text = changed("angle: 90 deg}", f"angle: {angle}}}").replace("rod_length: 0.3", "rod_length: 90")
    assert read(text).notes == ()


def test_speeds_and_times_are_no_angles() -> None:
    more = "motions:\n  m: {joint: A, angle: {polynomial: [0, 90, 90]}}\nmarkers:"
    text = changed("speed: 6 rad/s}", "speed: 90}", changed("markers:", more)).replace("duration: 10", "duration: 90")
    assert read(text).notes == ()


PIN = "  p: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 0, 1]}"
WELD = "  w: {type: spherical, bodies: [b, c], location: [0, 0, 0]}"
SPRING = "forces:\n  k: {type: spring_damper, points: {ground: [0, 0, 1], b: [0, 0, 0]}, stiffness: 1}"
LOOSE = {
    "one of two": (f"  a: {ROD}\n  b: {ROD}", PIN, "", ["f.yaml:5:3: note: no joint holds body 'b': it moves freely"]),
    "two together": (
        f"  a: {ROD}\n  b: {ROD}\n  c: {ROD}",
        f"{PIN}\n{WELD}",
        "",
        ["f.yaml:5:3: note: no joint connects the bodies 'b', 'c' with the ground: they move freely"],
    ),
    "all are free": (f"  a: {ROD}\n  b: {ROD}", "", "", []),
    "one beside a pair in free flight": (
        f"  a: {ROD}\n  b: {ROD}\n  c: {ROD}",
        WELD,
        "",
        ["f.yaml:4:3: note: no joint holds body 'a': it moves freely"],
    ),
    "a pair in free flight": (f"  b: {ROD}\n  c: {ROD}", WELD, "", []),
    "a spring holds it": (f"  a: {ROD}\n  b: {ROD}", PIN, SPRING, []),
}


@pytest.mark.parametrize("case", LOOSE)
def test_bodies_that_nothing_holds(case: str) -> None:
    bodies, joints, more, found = LOOSE[case]
    assert notes(scene(bodies, joints, more)) == found


def test_many_loose_bodies_take_a_few_lines() -> None:
    found = notes(scene(f"  a: {ROD}\n" + "\n".join(f"  b{i}: {ROD}" for i in range(1000)), PIN))
    assert len(found) == 6
    assert found[-1] == "note: ... and 995 more of this kind"


def pinned(body: str, kind: str, location: str) -> str:
    axis = "" if kind == "spherical" else ", axis: [0, 0, 1]"
    return scene(f"  a: {body}", f"  p: {{type: {kind}, bodies: [ground, a], location: {location}{axis}}}")


@pytest.mark.parametrize("location", ["[10, 0, 0]", "{ground: [0, 0, 0], a: [0, -6, -8]}"])
def test_a_joint_far_from_its_body(location: str) -> None:
    assert notes(pinned(ROD, "spherical", location)) == [
        "f.yaml:6:3: note: joint 'p' is 10 m from the centre of mass of body 'a', which is about 1.1 m long by its "
        "inertia; look at its location, and at its units"
    ]


NEAR = {
    "within eight lengths": (ROD, "spherical", "[8, 0, 0]"),
    "a bob on a long string": (BALL, "spherical", "[0, 0, 10]"),
    "along its axis a slider may be anywhere": (ROD, "prismatic", "[0, 0, 10]"),
    "without inertia a body has no length": (
        "{mass: 1, shape: {point: {}}, position: [0, 0, 0]}",
        "spherical",
        "[0, 0, 10]",
    ),
}


@pytest.mark.parametrize("case", NEAR)
def test_a_joint_near_its_body(case: str) -> None:
    assert notes(pinned(*NEAR[case])) == []


def test_run_and_check_show_them(tmp_path: Path) -> None:
    text = scene(f"  a: {ROD}\n  b: {ROD}", PIN, "simulation: {duration: 0.01, step: 0.01}")
    (tmp_path / "s.yaml").write_text(text)
    said = "s.yaml:5:3: note: no joint holds body 'b': it moves freely\n"
    assert mbproj("run", "s.yaml", folder=tmp_path).stderr == said
    assert mbproj("run", "s.yaml", "--quiet", folder=tmp_path).stderr == ""
    checked = mbproj("check", "s.yaml", folder=tmp_path)
    assert (checked.returncode, checked.stderr) == (0, said)
    (note,) = json.loads(mbproj("check", "s.yaml", "--json", folder=tmp_path).stdout)["notes"]
    assert note == {
        "message": "no joint holds body 'b': it moves freely",
        "hint": None,
        "file": "s.yaml",
        "line": 5,
        "column": 3,
    }


def compact(location: str) -> str:
    """Two balls that hang on each other, the first on the ground at a place."""
    second = BALL.replace("[0, 0, 0]", "[0.6, 0, 0]")
    return scene(
        f"  a: {BALL}\n  b: {second}",
        f"  A: {{type: revolute, bodies: [ground, a], location: {location}, axis: [0, 0, 1]}}\n"
        "  B: {type: revolute, bodies: [a, b], location: [0.3, 0, 0], axis: [0, 0, 1]}",
    )


def test_one_joint_far_from_a_mechanism_is_noted() -> None:
    (note,) = notes(compact("[0, 140, 0]"))
    assert "joint 'A' is 140 m from the bodies that it holds, and all else is within 0.6 m" in note
    assert notes(compact("[0, 40, 0]")) == []


def test_several_long_pendulums_of_small_bodies_are_not() -> None:
    second = BALL.replace("[0, 0, 0]", "[0.01, 0, 0]")
    hinges = "\n".join(
        f"  {name}: {{type: revolute, bodies: [ground, {body}], location: [{x}, 0, 30], axis: [0, 1, 0]}}"
        for name, body, x in (("A", "a", 0), ("B", "b", 0.01))
    )
    assert notes(scene(f"  a: {BALL}\n  b: {second}", hinges)) == []


def test_two_joints_far_from_a_mechanism_are_noted_and_most_are_not():
    """Four balls of a ring on four joints: of these two or three are 140 m away."""

    def ring(*heights: float) -> str:
        bodies = "\n".join(f"  b{n}: {BALL.replace('[0, 0, 0]', f'[{0.3 * n}, 0, 0]')}" for n in range(4))
        joints = "\n".join(
            f"  J{n}: {{type: spherical, bodies: [{'ground' if n == 0 else f'b{n - 1}'}, b{n}], "
            f"location: [{0.3 * n - 0.15}, 0, {height}]}}"
            for n, height in enumerate(heights)
        )
        return scene(bodies, joints)

    assert notes(ring(0, 0, 0, 0)) == []
    found = notes(ring(140, 0, 140, 0))
    assert [each.split("'")[1] for each in found] == ["J0", "J2"]
    assert all("is 140 m from the bodies that it holds, and all else is within" in each for each in found)
    assert notes(ring(140, 140, 0, 140)) == []
