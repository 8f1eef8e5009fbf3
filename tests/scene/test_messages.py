"""Each rule of the format, by the exact message that breaking it gives; and several problems at once."""

from __future__ import annotations

import re

import pytest

from mbproj.errors import InputError
from mbproj.joints import JOINTS
from tests.scene.scenes import GOOD, IDS, ROWS, changed, errors, read


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
