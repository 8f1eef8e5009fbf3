"""What `mbproj check` says of ropes."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.base.errors import InputError
from mbproj.base.mechanisms_folder import mechanism


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
