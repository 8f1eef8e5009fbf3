"""Each rule of the format by the message that breaking it gives, and notes on what may be a mistake."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

from mbproj.base.errors import InputError
from mbproj.joints.table import JOINTS
from mbproj.scene.blocks.oversights import notes_on
from mbproj.scene.scene import read_scene, read_scene_text
from tests.cli.commands import mbproj
from tests.scene.scenes import GOOD, IDS, ROWS, changed, errors, read
from tests.support import MECHANISMS

# Each rule of the format, by the exact message that breaking it gives; and several problems at once.


@pytest.mark.parametrize(("old", "new", "message"), ROWS, ids=IDS)
def test_the_first_message(old: str, new: str, message: str) -> None:
    assert errors(changed(old, new))[0] == message


TOO_LONG = {
    "(" * 101 + "1" + ")" * 101: "111: error: the expression has more than 100 levels",
    "+".join("1" * 101): "11: error: the expression has more than 100 levels",
    "1" * 1001: "11: error: the expression has 1001 characters, at most 1000 are allowed",
}


@pytest.mark.parametrize("expression", TOO_LONG, ids=["parentheses", "sum", "number"])
def test_expressions_are_bounded(expression: str) -> None:
    message = f"f.yaml:15:{TOO_LONG[expression]}; name parts of it under 'parameters'"
    assert errors(changed("mass: 0.12", f"mass: {expression}")) == [message]


SEVERAL = """\
mbproj: 1
gravity: [0, 0, -9.8, 0]
parameters: {length: 2 * widht, width: 80 mm}
bodies:
  crank:
    mas: 0.12
    inertia: [1, 1, 3]
    position: [0, 0, length]
  rod: {mass: 1, inertia: [1, 1, 1], position: [0, 0, "1 + 2 *"]}
joints:
  A: {type: revolute, bodies: [ground, crnk], location: [0, 0, 0], axis: [0, 0, 0]}
  A: {type: spherical}
simulation: {step: -1, integrator: rk}
"""
REPORT = """\
f.yaml:2:10: error: 'gravity' needs 3 numbers, found 4
    gravity: [0, 0, -9.8, 0]
             ^
f.yaml:3:26: error: unknown name 'widht'; did you mean 'width'?
    parameters: {length: 2 * widht, width: 80 mm}
                             ^
f.yaml:5:3: error: missing key 'mass'; add it: a number in kg
      crank:
      ^
f.yaml:6:5: error: unknown key 'mas'; did you mean 'mass'?
        mas: 0.12
        ^
f.yaml:7:14: error: 'inertia' breaks the triangle inequality: 3 exceeds the sum of the other two (principal moments 1, \
1 and 3); it is about the centre of mass, in kg m^2
        inertia: [1, 1, 3]
                 ^
f.yaml:9:63: error: the expression ends too early
      rod: {mass: 1, inertia: [1, 1, 1], position: [0, 0, "1 + 2 *"]}
                                                                  ^
f.yaml:11:40: error: unknown body 'crnk'; did you mean 'crank'?
      A: {type: revolute, bodies: [ground, crnk], location: [0, 0, 0], axis: [0, 0, 0]}
                                           ^
f.yaml:11:74: error: 'axis' is a zero vector; a direction needs a length
      A: {type: revolute, bodies: [ground, crnk], location: [0, 0, 0], axis: [0, 0, 0]}
                                                                             ^
f.yaml:12:3: error: duplicate key 'A'; it is first given in line 11
      A: {type: spherical}
      ^
f.yaml:13:20: error: 'step' must be greater than 0, found -1
    simulation: {step: -1, integrator: rk}
                       ^
f.yaml:13:36: error: unknown integrator 'rk'; did you mean 'rk4'?
    simulation: {step: -1, integrator: rk}
                                       ^"""


def test_all_problems_are_reported_at_once_in_text_order() -> None:
    with pytest.raises(InputError) as raised:
        read(SEVERAL)
    assert str(raised.value) == REPORT


def test_a_problem_in_what_an_alias_repeats_is_reported_once() -> None:
    text = changed(
        "rod: {mass: 0.5, inertia: [4e-3, 4e-4, 4e-3], position: [0.1, 0.05, 0.1]}",
        "rod: &rod {mass: -1, inertia: [4e-3, 4e-4, 4e-3], position: [0.1, 0.05, 0.1]}\n  twin: *rod",
    )
    assert errors(text) == ["f.yaml:21:20: error: 'mass' must be at least 0, found -1"]


def test_a_wrong_parameter_is_reported_where_it_is_given_and_nowhere_else() -> None:
    text = changed("crank_length: 0.08", "crank_length: 1/0").replace("mass: 0.12", "mass: crank_length")
    assert errors(text) == ["f.yaml:4:29: error: division by zero"]


def test_the_checks_of_a_joint_of_unknown_type_go_on() -> None:
    text = changed("type: spherical, bodies: [crank, rod]", "type: ball, bodies: [crank, crank]")
    assert errors(text) == [
        f"f.yaml:25:13: error: unknown joint type 'ball'; choose from: {', '.join([*JOINTS][:20])}, ...",
        "f.yaml:25:27: error: 'bodies' names 'crank' twice; give two different ones",
    ]


def test_what_a_comma_cuts_off_is_one_problem_and_the_rest_is_still_read() -> None:
    text = changed("angle: 90 deg}", "angle: max(0, 1 + x), axs: 1}").replace("speed: 6 rad/s", "speed: max(0, -1)")
    cut = "this value is cut off: inside { } a comma ends it; put it in quotes:"
    assert errors(text) == [
        f'f.yaml:18:43: error: {cut} angle: "max(0, 1 + x)"',
        "f.yaml:18:54: error: unknown name 'x'; parameters are defined under 'parameters'",
        "f.yaml:18:58: error: unknown key 'axs'; did you mean 'axis'?",
        f'f.yaml:24:98: error: {cut} speed: "max(0, -1)"',
    ]


def test_a_parenthesis_that_stays_open_cuts_nothing_off() -> None:
    text = changed("angle: 90 deg}", "angle: (1, b: 2, c: 3)}")
    assert errors(text)[:1] == ["f.yaml:18:45: error: ')' is missing"]
    text = changed("position: [0, 0.1, 0.12]", "position: [(0, 0.1, 0.12]")
    assert errors(text) == ["f.yaml:17:18: error: ')' is missing"]


@pytest.mark.parametrize("hint", ['angle: "max(0, pi/2)"', "angle: 0.5"])
def test_what_the_hint_says_is_read(hint: str) -> None:
    wrong = hint.replace('"', "").replace(".", ",")
    with pytest.raises(InputError, match=re.escape(hint)):
        read(changed("angle: 90 deg", wrong))
    read(changed("angle: 90 deg", hint))


def test_a_wrong_setting_does_not_hide_that_the_others_contradict_each_other() -> None:
    text = changed("step: 0.01\n  integrator", "step: 0.003\n  integrator").replace("mass: 0.12", "mass: -1")
    assert errors(text) == [
        "f.yaml:11:16: error: 'output_step' (0.01 s) is not a whole multiple of 'step' (0.003 s); "
        "set 'output_step' to 0.009 s",
        "f.yaml:15:11: error: 'mass' must be at least 0, found -1",
    ]


def test_a_long_line_is_shown_around_the_column() -> None:
    with pytest.raises(InputError) as raised:
        read(changed("mass: 0.12", f"mass: {'1 + ' * 50}x{' + 1' * 49}"))
    _, line, caret = str(raised.value).splitlines()
    assert (len(line), line[124], caret) == (4 + 120 + 120, "x", " " * 124 + "^")


def test_many_unknown_names_among_many_cost_no_suggestions() -> None:
    bodies = "".join(f"  body_{i}: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\n" for i in range(301))
    text = f"mbproj: 1\ngravity: [0, 0, 0]\nbodies:\n{bodies}markers:\n  tip: {{body: bdy_1, location: [0, 0, 0]}}\n"
    listed = ", ".join(f"body_{i}" for i in range(20))
    assert errors(text) == [f"f.yaml:306:15: error: unknown body 'bdy_1'; choose from: {listed}, ..."]


def test_the_good_scene_has_none() -> None:
    assert read(GOOD).title == "Spatial slider-crank (Zhang, Liu & Liu 2015, sect. 5.2)"


# Notes on what may be a mistake: angles in degrees, bodies that nothing holds, joints far from their bodies.

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
