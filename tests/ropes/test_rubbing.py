"""A rope that rubs on sheaves, against Euler's and Eytelwein's law: what holds, what slips, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import InputError, read_scene_text
from mbproj.results.analysis.expectations import outcomes
from tests.kernel.scenes import needs_kernel
from tests.ropes.scenes import G, scene
from tests.stops.runs import run

pytestmark = needs_kernel
#: Two weights on a rope over a sheave that does not turn.
WEIGHTS = """
parameters: {heavy: 3, turns: 0, ratio: exp(0.3*pi)}
bodies:
  light: {mass: 1, inertia: [1, 1, 1], position: [1.9, 0, -1]}
  heavy: {mass: heavy, inertia: [1, 1, 1], position: [2.1, 0, -1]}
joints:
  one: {type: prismatic, bodies: [ground, light], location: [1.9, 0, -1], axis: z}
  other: {type: prismatic, bodies: [ground, heavy], location: [2.1, 0, -1], axis: z}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: light, at: [1.9, 0, -1]}
      - {sheave: ground, at: [2, 0, 0], radius: 0.1, bends: right, turns: turns, friction: 0.3}
      - {point: heavy, at: [2.1, 0, -1]}
"""
#: A weight on a rope over a sheave, to a slider that a motion pulls away.
PULLED = """
bodies:
  slider: {mass: 1, inertia: [1, 1, 1], position: [-0.5, 0, -0.6]}
  load: {mass: 2, inertia: [1, 1, 1], position: [0.1, 0, -1]}
joints:
  rail: {type: prismatic, bodies: [ground, slider], location: [-0.5, 0, -0.6], axis: [-1, 0, 0]}
  guide: {type: prismatic, bodies: [ground, load], location: [0.1, 0, -1], axis: z}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: slider, at: [-0.5, 0, -0.6]}
      - {sheave: ground, at: [0, 0, 0], radius: 0.1, bends: right, friction: 0.25}
      - {point: load, at: [0.1, 0, -1]}
motions:
  pulls: {joint: rail, displacement: {expression: 0.3*t + 0.2*t**2}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(("turns", "heavy"), [(0, 3.0), (1, 20.0)])
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_it_slips_where_the_weights_ask_for_more(formulation, turns, heavy):
    """T2 = e^(μα) T1 at half a turn and at one and a half: s'' = g (m2 - e^(μα) m1) / (m2 + e^(μα) m1)."""
    _, found = run(scene(WEIGHTS, formulation, 0.1 if formulation == "full" else 0.5), heavy=heavy, turns=turns)
    ratio = np.exp(0.3 * np.pi * (1 + 2 * turns))
    gain = G * (heavy - ratio) / (heavy + ratio)
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], 0.5 * gain * found["time"] ** 2, atol=1e-11)
    first, second = found["ropes/tension"].T
    np.testing.assert_allclose(first, G + gain, rtol=1e-10)
    np.testing.assert_allclose(second / first, ratio, rtol=1e-12)
    assert found.unbalanced < 1e-9


@pytest.mark.parametrize(("turns", "heavy"), [(0, 2.5), (0, 0.4), (1, 16.8)])
def test_it_holds_below(turns, heavy):
    """e^(0.3 π) = 2.566, e^(0.9 π) = 16.9: the weights hang, and the tensions are theirs."""
    _, found = run(scene(WEIGHTS, "planar", 0.2), heavy=heavy, turns=turns)
    np.testing.assert_allclose(found["joints/coordinate"][:, :2], 0.0, atol=1e-13)
    np.testing.assert_allclose(found["ropes/tension"], [[G, heavy * G]] * len(found["time"]), rtol=1e-12)
    assert (found["friction/state"] == 0.0).all()


@pytest.mark.parametrize("formulation", ["planar", "full"])
def test_the_wrap_of_the_pose_counts(formulation):
    """The strand to the slider turns, and what lies on the sheave with it: T is of the moving load, T e^(μα) pulls."""
    _, found = run(scene(PULLED, formulation, 0.1 if formulation == "full" else 0.6))
    x, z = found["bodies/position"][:, 0, 0], found["bodies/position"][:, 0, 2]
    far = np.hypot(x, z)
    angle = np.arctan2(-z, -x) + np.arcsin(0.1 / far)  # of the strand up to the sheave
    wrap = angle + 0.5 * np.pi
    slack, pull = found["ropes/tension"].T[::-1]
    np.testing.assert_allclose(slack, 2.0 * (G + found["bodies/acceleration"][:, 1, 2]), rtol=1e-10)
    np.testing.assert_allclose(pull / slack, np.exp(0.25 * wrap), rtol=1e-10)
    assert np.ptp(wrap) > (0.01 if formulation == "full" else 0.1)
    assert found.unbalanced < 1e-9


def test_an_expectation_is_about_either_side_and_the_friction():
    text = (
        scene(WEIGHTS, "planar", 0.2)
        + "expect:\n"
        + (
            "  a: {joint: rope, quantity: tension_2, at: end, value: 2*3*9.81*ratio/(3 + ratio),"
            " relative: 1.0e-9, source: closed form}\n"
            "  b: {friction: rope.slip_1, quantity: state, at: end, value: -1, absolute: 1.0e-9, source: it slips}\n"
        )
    )
    parsed = read_scene_text(text)
    with mbproj.run(parsed) as results:
        assert [each.holds for each in outcomes(parsed.expectations, results)] == [True, True]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("{sheave: ground, at: [2, 0, 0]", "{wheel: light", "has 'friction' and is a wheel"),
        ("    path:", "    free: true\n    path:", "a rope whose length may change rubs on a sheave"),
        (
            "      - {point: heavy",
            "      - {sheave: ground, at: [2.8, 0, 0], radius: 0.1, bends: right, friction: 0.2}\n"
            "      - {point: heavy",
            "the rope rubs on place 2 already; make two ropes of it",
        ),
        (
            "{point: light, at: [1.9, 0, -1]}",
            "{drum: light, radius: 0.05, bends: left}",
            "turns a wheel or a drum; end it",
        ),
        (
            "{sheave: ground, at: [2, 0, 0]",
            "{sheave: loose, at: [2, 0, 0]",
            "whose body may turn against the plane of the",
        ),
        ("friction: 0.3", "friction: -0.3", "'friction' must be at least 0"),
    ],
)
def test_what_is_refused(old, new, message):
    assert old in WEIGHTS
    loose = "\nbodies:\n  loose: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0]}\n"
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(WEIGHTS.replace(old, new).replace("\nbodies:\n", loose)))
    assert message in str(caught.value)
