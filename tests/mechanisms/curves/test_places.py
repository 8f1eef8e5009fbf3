"""Where joints touch their curves: between centres, under rollers and faces, at pins; and expectations of it."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from mbproj.analysis.observed import datasets
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import DISCS, FLAT, ROLLER, SLOT, TOUCH, WIRE, scene
from tests.stops.runs import run

pytestmark = needs_kernel
EXPECT = "expect: {there: {joint: K, quantity: contact, component: norm, at: end, below: 10 m, source: test}}\n"


def touched(text, formulation="auto"):
    """The places of the first joint that follows a curve, and the run."""
    _, found = run(scene(text, formulation, 0.06, "10 ms"))
    return found["curves/contact"][:, 0], found


def test_discs_touch_on_the_line_of_their_middles():
    place, found = touched(DISCS.replace("JOINT", TOUCH))
    angle = -found["joints/coordinate"][:, :2]
    zero = np.zeros_like(angle[:, 0])
    first = 0.015 * np.stack([np.sin(angle[:, 0]), zero, np.cos(angle[:, 0])], axis=-1)
    arm = np.array([-0.3, 0.0, 0.015])
    cosine, sine = np.cos(angle[:, 1]), np.sin(angle[:, 1])
    second = np.stack([0.3 + arm[0] * cosine + arm[2] * sine, zero, 0.13 - arm[0] * sine + arm[2] * cosine], axis=-1)
    line = second - first
    between = first + 0.04 * line / np.linalg.norm(line, axis=-1)[:, None]
    np.testing.assert_allclose(place, between, atol=1e-12)


def test_a_roller_touches_below_its_middle():
    """At its radius from the middle, against the force."""
    place, found = touched(ROLLER)
    middle = np.array([0.0, 0.0, 0.05]) + found["joints/coordinate"][:, 1, None] * np.array([0.0, 0.0, 1.0])
    force = found["joints/reaction_force"][:, 2]
    np.testing.assert_allclose(place, middle - 0.012 * force / np.linalg.norm(force, axis=-1)[:, None], atol=1e-12)


def test_a_face_is_touched_beside_its_point():
    place, found = touched(FLAT.replace("LAW", "cycloidal").replace("SPEED", "30"))
    np.testing.assert_allclose(place[:, 2], 0.05 + found["joints/coordinate"][:, 1], atol=1e-13)
    np.testing.assert_allclose(place[:, 0], 0.013 - found["joints/coordinate"][:, 2], atol=1e-13)


@pytest.mark.parametrize("text", [SLOT, WIRE])
def test_a_slot_is_touched_at_its_pin(text):
    place, found = touched(text)
    np.testing.assert_allclose(place, found["bodies/position"][:, 1], atol=1e-13)


def test_an_expectation_may_be_about_it():
    given = read_scene_text(scene(ROLLER + EXPECT)).expectations[0]
    assert datasets(given, ()) == ("curves/contact",)
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(ROLLER + EXPECT.replace("joint: K", "joint: A")))
    assert "joint 'A' is revolute and has no 'contact'" in str(caught.value)
