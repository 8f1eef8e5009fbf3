"""What rolls, against closed forms and against a solution of equations of its own, in each formulation that has it."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from tests.crossed import crossed, full
from tests.rolling import scenes
from tests.support import ROOT

FORMULATIONS = ["full", "reduced"]


@pytest.fixture(params=FORMULATIONS)
def formulation(request):
    return request.param


def run(text, **settings):
    return mbproj.run(mbproj.read_scene_text(text), **settings)


@pytest.mark.full_where(formulation="full")
def test_a_coin_rolls_on_its_circle(formulation):
    r = run(scenes.coin(), formulation=formulation)
    p, t = r["bodies/position"][:, 0], r.time
    angle = scenes.PRECESSION * t
    expected = np.column_stack([np.cos(angle), np.sin(angle), np.full_like(t, scenes.RADIUS * np.sin(scenes.TILT))])
    np.testing.assert_allclose(p, expected, atol=2e-9)
    force = r["joints/reaction_force"][:, 0]
    np.testing.assert_allclose(force[:, 2], scenes.GRAVITY, rtol=1e-8)
    np.testing.assert_allclose(np.hypot(*force[:, :2].T), scenes.FRICTION, rtol=1e-8)


@pytest.mark.parametrize("formulation", [full("full"), "reduced"])
def test_a_ball_on_a_turntable_moves_on_a_circle(formulation):
    r = run(scenes.turntable(), formulation=formulation)
    np.testing.assert_allclose(r["bodies/position"][:, 1, :2], scenes.on_turntable(r.time), atol=2e-9)


@pytest.mark.full_where(formulation="full")
def test_a_ball_rolls_down_at_five_sevenths(formulation):
    plane = "plane: {location: [0, 0, 0], normal: [-sin(0.3), 0, cos(0.3)]}"
    at = "[-0.1 * sin(0.3), 0, 0.1 * cos(0.3)]"
    ball = f"  ball: {{mass: 1, shape: {{sphere: 0.1}}, position: {at}}}"
    joint = f"  B: {{type: rolling_ball, bodies: [ground, ball], {plane}, centre: {at}, radius: 0.1}}"
    r = run(scenes.scene(ball, joint), formulation=formulation)
    way = np.linalg.norm(r["bodies/position"][:, 0] - r["bodies/position"][0, 0], axis=1)
    np.testing.assert_allclose(way, 0.5 * 5.0 / 7.0 * 9.81 * np.sin(0.3) * r.time**2, atol=1e-10)


@pytest.mark.parametrize("formulation", [*FORMULATIONS, "planar"])
def test_chaplygins_sleigh(formulation):
    r = run(scenes.sleigh(duration="2 s"), formulation=formulation)
    speed, angle = scenes.of_sleigh(r.time)
    v, θ = r["bodies/velocity"][:, 0, :2], r["joints/coordinate"][:, 2]
    np.testing.assert_allclose(θ, angle, atol=1e-9)
    np.testing.assert_allclose(v[:, 0] * np.cos(θ) + v[:, 1] * np.sin(θ), speed, atol=2e-9)


def test_a_wheel_in_a_plane_moves_as_in_space():
    """On its wheel a cart runs down: in three formulations, with the reactions out of the plane."""
    bodies = (
        "  cart: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [0.1, 0, 0.5]}\n"
        "  wheel: {mass: 1, inertia: [0.02, 0.04, 0.02], position: [0, 0, 0.3]}"
    )
    joints = (
        "  rail: {type: planar, bodies: [ground, cart], location: [0, 0, 0.3], axis: [0, 1, 0]}\n"
        "  arm: {type: revolute, bodies: [cart, wheel], location: [0, 0, 0.3], axis: [0, 1, 0]}\n"
        + scenes.wheel("wheel", "[0, 0, 0.3]", "[0, 1, 0]", 0.3)
    )
    text = scenes.scene(bodies, joints, gravity="[3, 0.4, -9.81]", duration="0.3 s")
    ends = [run(text, formulation=each) for each in ("full", "reduced", "planar")]
    for each in ends[1:]:
        np.testing.assert_allclose(each["bodies/position"], ends[0]["bodies/position"], atol=1e-9)
        np.testing.assert_allclose(each["joints/reaction_force"], ends[0]["joints/reaction_force"], atol=1e-6)


@pytest.mark.parametrize("formulation", [full("full"), "reduced", "planar"])
def test_a_wheel_on_a_line_counts_how_far_it_has_rolled(formulation):
    """At position level: it is where its turns say, and F = (m + J/R²) x''."""
    body = "  wheel: {mass: 2, inertia: [0.05, 0.09, 0.05], position: [1, 0, 0.3]}"
    joint = scenes.wheel("wheel", "[1, 0, 0.3]", "[0, 1, 0]", 0.3).replace("rolling_wheel", "rolling_on_line")
    push = "forces:\n  push: {type: force, body: wheel, force: [3, 0, 0]}\n"
    r = run(scenes.scene(body, joint, push, duration="3 s"), formulation=formulation)
    s, φ = r["joints/coordinate"].T
    np.testing.assert_allclose(s, 1.0 + 0.5 * r.time**2, rtol=1e-8)
    np.testing.assert_allclose(s - 1.0, 0.3 * φ, atol=1e-13 * s.max())
    np.testing.assert_allclose(r["joints/reaction_force"][:, 0], [[-1.0, 0.0, 2 * 9.81]] * len(s), atol=1e-7)


@pytest.mark.full_where(formulation="full")
@crossed(
    "formulation, integrator, steps, least",
    FORMULATIONS,
    [pytest.param("dop853", (15, 30), 7.5), pytest.param("rk4", (60, 120), 3.8)],
    dear=["full"],
)
def test_orders_on_a_wobbling_coin(formulation, integrator, steps, least):
    reference = np.loadtxt(ROOT / "tests" / "data" / "coin_wobbling.csv", delimiter=",", skiprows=1)
    errors = []
    for count in steps:
        settings = {"tolerance": None, "step": f"{1.0 / count!r} s", "duration": "1 s", "output_step": "1 s"}
        r = run(scenes.wobbling(reference[0, 1:], integrator=integrator, **settings), formulation=formulation)
        errors.append(np.abs(r["bodies/position"][-1, 0] - reference[5, 1:4]).max())
        assert r["diagnostics/position_violation"].max() < 1e-13
        assert r["diagnostics/velocity_violation"].max() < 1e-13
    assert np.log2(errors[0] / errors[1]) > least, errors
