"""A scene's text is taken apart once: a reading with other values is that of the text with these values, to the bit."""

from __future__ import annotations

import math
from dataclasses import fields

import pytest

from mbproj.base.errors import InputError
from mbproj.base.mechanisms_folder import mechanism, validation_scenes
from mbproj.scene import scene as read
from mbproj.scene.scene import SceneText, read_scene
from mbproj.scene.text.document import compose
from tests.crossed import where

SCENES = [mechanism("five_bar"), mechanism("locomotive"), mechanism("stewart_platform"), *validation_scenes()[:6]]
#: A scene in which a value follows from a parameter by another one, names occur in laws, and a unit depends on a name.
TEXT = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {a: 1 m, b: 2 * a, k: 3, slow: 1}
simulation: {duration: 1, step: 0.01}
bodies:
  bar: {mass: k, inertia: [0.1, 0.1, 0.1], position: [0.5 * b, 0, 0]}
  rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 3]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  drag: {type: force, body: rod, force: [slow * sin(t), 0, 0]}
"""


def same(one, other):
    """All that the two scenes say; where it says it is known of at least as much."""
    said = {field.name for field in fields(one)} - {"places"}
    assert {name: getattr(one, name) for name in said} == {name: getattr(other, name) for name in said}
    assert one.places.items() >= other.places.items()


@pytest.mark.parametrize(
    "path", where(lambda path: path.stem != "stewart_platform", SCENES), ids=lambda path: path.stem
)
def test_every_parameter_and_mass_changed_in_turn(path):
    text = path.read_text(encoding="utf-8")
    again = SceneText(text, "a")
    plain = again.scene()
    changes = [{name: value * 1.01} for name, value in plain.parameters.items()]
    changes += [{f"bodies.{body.name}.mass": body.mass + 1.0} for body in plain.bodies[:3]]
    for change in [{}, *changes, {}]:
        try:
            expected = SceneText(text, "a").scene(change)
        except InputError as error:
            with pytest.raises(InputError) as raised:
                again.scene(change)
            assert raised.value.problems == error.problems
            continue
        same(again.scene(change), expected)


def test_zeros_of_both_signs_are_two_values():
    text = SceneText(TEXT.replace("position: [0, 0, 3]", "position: [0, 0, 'atan2(slow, -1) / (1 rad)']"), "a")
    places = [text.scene({"slow": zero}).bodies[1].position[2] for zero in (0.0, 0.0, -0.0, 0.0)]
    assert places == [math.pi, math.pi, -math.pi, math.pi]


def test_what_does_not_follow_from_what_changed_is_not_read_again():
    text = SceneText(TEXT, "a")
    first, second, third = text.scene(), text.scene({"a": 1.5}), text.scene({"a": 1.6})
    assert third.bodies[1] is second.bodies[1]
    assert third.joints[0] is second.joints[0]
    assert [scene.bodies[0].position[0] for scene in (first, second, third)] == [1.0, 1.5, 1.6]
    law = text.scene({"slow": 2}).forces
    assert law != third.forces
    assert text.scene({"a": 1.7}).forces[0] is third.forces[0]


def test_a_reading_that_fails_leaves_nothing_behind():
    text = SceneText(TEXT, "a")
    text.scene()
    with pytest.raises(InputError, match=r"unknown name 'x'"):
        text.scene({"a": 4.0, "bodies.rod.mass": "x"})
    for value in (2.0, 3.0):
        same(text.scene({"a": value}), SceneText(TEXT, "a").scene({"a": value}))
    with pytest.raises(InputError, match=r"'mass' must be"):
        text.scene({"k": -1.0})
    same(text.scene({"k": 5.0}), SceneText(TEXT, "a").scene({"k": 5.0}))


def test_a_file_that_is_read_again_is_taken_apart_once_and_anew_when_it_has_changed(tmp_path, monkeypatch):
    composed = []
    monkeypatch.setattr(read, "compose", lambda text, name: composed.append(name) or compose(text, name))
    path = tmp_path / "scene.yaml"
    path.write_text(TEXT, encoding="utf-8")
    for value in (1.5, 1.6, 1.7):
        same(read_scene(path, {"a": value}), SceneText(TEXT, str(path), path).scene({"a": value}))
    assert composed == [str(path)] * 4  # one of the file, three of the text
    path.write_text(TEXT.replace("mass: 2", "mass: 5"), encoding="utf-8")
    assert read_scene(path, {"a": 1.5}).bodies[1].mass == 5.0
