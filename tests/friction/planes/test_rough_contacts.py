"""Stops with friction: forces within their cones, and one motion in the plane and in space."""

from __future__ import annotations

import numpy as np
import pytest

from tests.friction.mechanisms import block
from tests.friction.planes.scenes import CORNERS, IN_PLANE, box, puck
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import run, same, simulated

pytestmark = needs_kernel

INCLINE = (10.0 * np.sin(0.3), 0.0, -10.0 * np.cos(0.3))
STATIC = "{coefficient: 0.3, static: 0.5}"
STRIBECK = "{coefficient: 0.3, static: 0.5, stribeck_speed: 0.2}"
FRO, ROUND = '["20*sin(6*t)", 0, 0]', '["20*sin(5*t)", "7*cos(5*t)", 0]'
WIDE = {"a": (-0.36, 0.26), "b": (0.45, -0.07), "c": (-0.19, 0.04), "d": (-0.08, -0.38)}
TWO, THREE = {"a": (-0.45, 0.0), "b": (0.4, 0.0)}, {"a": (-0.4, 0.0), "b": (0.1, 0.0), "c": (0.35, 0.0)}


def scenes(steps):
    """Each with the formulations that it is for."""
    thrown = {"velocity": (1, 0.4, 0), "spin": (0, 0, 5), "duration": 0.4, "steps": steps}
    return {
        "a puck that turns downhill": puck("0.4", [0, 2, 0], gravity=INCLINE, steps=steps),
        "a puck that bounces": puck(STATIC, [1, 0.5, -1], height=0.2, e=0.5, duration=1.5, steps=steps),
        "a puck of Stribeck's": puck(STRIBECK, [1, 2, 0], steps=steps),
        "two feet in the plane": box(TWO, STATIC, push=19, joint=IN_PLANE, formulation="planar", steps=steps),
        "three feet in the plane": box(
            THREE, "0.25", velocity=(1.02, 0, 0), joint=IN_PLANE, formulation="planar", steps=steps
        ),
        "three feet": box({name: CORNERS[name] for name in "abc"}, STATIC, **thrown),
        "four feet": box(CORNERS, "0.25", **thrown),
        "four feet that are pushed": box(CORNERS, STATIC, push=19, duration=0.9, steps=steps),
        "two feet that are pushed to and fro": box(
            TWO, STATIC, force=FRO, height=0.05, joint=IN_PLANE, formulation="planar", steps=steps
        ),
        "a box that lifts a foot while it slides": box(
            WIDE, STRIBECK, velocity=(-0.48, 0.5, 0), force=ROUND, height=0.22, duration=0.8, steps=steps
        ),
        "a block that rocks": block(0.6, 0.1, R=0.5, α=0.3, duration=0.6, steps=steps),
    }


RECORDED = ("bodies/position", "bodies/velocity", "stops/force", "friction/force", "friction/dissipation")


#: All by error, and every other one with either kind of fixed steps.
CASES = [(name, steps) for k, name in enumerate(scenes("rk4")) for steps in ("dop853", ("rk4", "radau5")[k % 2])]


@pytest.mark.parametrize(("name", "steps"), CASES)
def test_forces_are_within_their_cones(name, steps):
    """No stop pulls, what pushes is closed, and friction is at most the largest coefficient times the push."""
    _, recorded = run(scenes(steps)[name])
    assert len(recorded.happened) > 0
    push, rub = recorded["stops/force"], recorded["friction/force"]
    assert push.min() >= 0.0
    assert (recorded["stops/gap"] * push).max() < 1e-7 * push.max()
    assert recorded["stops/gap"].min() > -1e-7
    across = np.hypot(rub[:, ::2], rub[:, 1::2])
    assert (across - 0.5 * push).max() < 1e-6 * push.max()  # no scene here has a larger one
    assert np.diff(recorded["friction/dissipation"], axis=0).min() > -1e-7


@pytest.mark.parametrize("steps", ["dop853", "rk4"])
@pytest.mark.parametrize("name", [name for name in scenes("rk4") if "in the plane" in name or "to and fro" in name])
def test_it_is_the_same_in_the_plane_and_in_space(name, steps):
    """With loads that stops share, and joints: what they bear beside the plane is told, too."""
    text = scenes(steps)[name]
    assert "formulation: planar" in text
    _, space = run(text.replace("formulation: planar", "formulation: reduced"))
    same(run(text)[1], space, RECORDED, 1e-7)


def test_the_least_share_within_the_cones_is_reported():
    """Two feet bear half of what pushes each, until one can bear no more."""
    text = box(TWO, STATIC, push=20, joint=IN_PLANE, formulation="planar", duration=0.7)
    _, recorded = run(text)
    push, bears = 20.0 * recorded["time"], recorded["stops/force"][:, 0]
    least = np.minimum(0.5 * push, 0.5 * bears)
    assert (least < 0.5 * push - 0.1).any()
    np.testing.assert_allclose(-recorded["friction/force"][:, 0], least, atol=1e-7)
    np.testing.assert_allclose(-recorded["friction/force"][:, 2], push - least, atol=1e-7)


@pytest.mark.parametrize("steps", ["dop853", "rk4"])
@pytest.mark.parametrize("until", [0.13, 0.31])
def test_a_run_goes_on_with_the_bits_of_a_longer_one(steps, until):
    """While four feet slide, which share a load at will."""
    given = {"velocity": (1, 0.4, 0), "spin": (0, 0, 5), "steps": steps}
    whole, _ = simulated(box(CORNERS, "0.25", duration=0.5, **given))
    _, kept = simulated(box(CORNERS, "0.25", duration=until, **given))
    rest, _ = simulated(box(CORNERS, "0.25", duration=0.5, **given), kept[-1])
    after = whole["time"] > kept[-1]["t"]
    for path in ("time", *RECORDED):
        assert np.array_equal(rest[path], whole[path][after]), path
    assert rest.happened == whole.happened
