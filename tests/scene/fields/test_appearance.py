"""How a body looks: its shapes, from its centre of mass, and its `appearance`. Neither has a say in its motion."""

from __future__ import annotations

import pytest

from mbproj.scene.records import COLOURS, Appearance, PlacedShape
from mbproj.scene.scene import read_scene_text

TEXT = """\
mbproj: 1
gravity: [0, 0, -9.8]
bodies:
  hammer:
    origin: [3, 0, 0]
    shapes:
      - {box: [0.1, 0.02, 0.02], mass: 1, position: [0.05, 0, 0]}
      - {cylinder: {radius: 30 mm, length: 60 mm, axis: y}, mass: 3, position: [0.1, 0, 0]}
    LOOK
"""


def hammer(look=""):
    (body,) = read_scene_text(TEXT.replace("LOOK", look), "f.yaml").bodies
    return body


def test_shapes_are_placed_from_the_centre_of_mass():
    handle, head = hammer().shapes
    assert (handle.kind, dict(handle.sizes), handle.axis) == ("box", {"a": 0.1, "b": 0.02, "c": 0.02}, "z")
    assert handle.position == pytest.approx((-0.0375, 0.0, 0.0))  # the centre is at 0.0875
    assert (head.kind, dict(head.sizes), head.axis) == ("cylinder", {"radius": 0.03, "length": 0.06}, "y")
    assert head.position == pytest.approx((0.0125, 0.0, 0.0))


def test_an_appearance_changes_nothing_but_the_looks():
    look = "appearance: {colour: steel, opacity: 0.5, shapes: [{sphere: 0.1, position: [0, 0, 1]}]}"
    shape = PlacedShape("sphere", {"r": 0.1}, position=(0.0, 0.0, 1.0))
    assert hammer(look).appearance == Appearance(COLOURS["steel"], 0.5, (shape,))
    assert hammer(look) == hammer()  # as far as the motion goes
    assert hammer().appearance is None


def test_a_colour_may_be_given_in_hexadecimal():
    assert hammer('appearance: {colour: "#44AA77"}').appearance == Appearance("#44aa77")
