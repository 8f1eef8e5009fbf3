"""Rollers that roll on curves without slip: a row at position level, arc length against turns, laps counted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipeinc, ellipj, ellipk

import mbproj
from mbproj import Mechanism
from mbproj.base.errors import InputError
from mbproj.motion.simulate import simulate
from tests.crossed import crossed
from tests.rolling import scenes
from tests.rolling.scenes import run

FORMULATIONS = ["full", "reduced", "planar"]
FEW = {"duration": "0.3 s", "output_step": "0.1 s", "tolerance": 1e-8}


def roller(curve: str, at: tuple[float, float], rest: str = "", moves: str = "", own: str = "", **simulation) -> str:
    """A disk of 0.1 m, 2 kg and 0.015 kg m² with its centre there touches a curve in the plane of x and z."""
    centre = f"[{at[0]!r}, 0, {at[1]!r}]"
    body = f"  disk: {{mass: 2, inertia: [0.01, 0.015, 0.01], position: {centre}{moves}}}"
    joints = (
        f"  P: {{type: planar, bodies: [ground, disk], location: {centre}, axis: [0, -1, 0]}}\n"
        f"  R: {{type: rolling_on_curve, bodies: [ground, disk], curve: track, locations: [[0, 0, 0], {centre}], "
        f"axis: [0, -1, 0], x_axis: [1, 0, 0], roller: 0.1{own}}}"
    )
    text = scenes.scene(body, joints, rest, **simulation)
    return text.replace("bodies:\n", f"curves: {{track: {curve}}}\nbodies:\n", 1)


def coordinate(r, name):
    return r["joints/coordinate"][:, r.names("coordinates").index(name)]


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_disk_in_a_bowl_is_a_pendulum_and_turns_as_it_rolls(formulation):
    """Its centre swings on 0.2 m as one does under g / (1 + J / m r²), from 60 degrees: sin(θ/2) = k cd(ω t)."""
    high, arm = np.radians(60.0), 0.2
    few = FEW if formulation == "full" else {"duration": "1.5 s"}
    start = (arm * float(np.sin(high)), -arm * float(np.cos(high)))
    r = run(roller("{ellipse: [0.3, 0.3]}", start, own=", side: inside", **few), formulation=formulation)
    x, _, z = r["bodies/position"][:, 0].T
    θ = np.arctan2(x, -z)
    k, ω = np.sin(0.5 * high), np.sqrt(scenes.GRAVITY / arm / (1.0 + 0.015 / (2.0 * 0.01)))
    sn, *_ = ellipj(ω * r.time + ellipk(k**2), k**2)
    np.testing.assert_allclose(θ, 2.0 * np.arcsin(k * sn), atol=1e-7 if formulation == "full" else 2e-9)
    np.testing.assert_allclose(coordinate(r, "R.angle"), -(arm / 0.1) * (θ - high), atol=1e-12)
    np.testing.assert_allclose(np.hypot(x, z), arm, atol=1e-13)


@pytest.mark.full_where(formulation="full")
@crossed("rim, formulation", [0.1, 0.1 * np.sqrt(7.0)], FORMULATIONS, dear=["full"])
def test_a_disk_goes_round_a_circle_again_and_again(formulation, rim):
    """It turns (R + r) / r times a lap, whatever the ratio; one of the same radius writes a cardioid."""
    arm, rounds = rim + 0.1, 0.63 if formulation == "full" else 2.66
    rest = "motions:\n  drive: {joint: R, lap: 2 * pi * t}\nmarkers:\n"
    rest += "  rim: {body: disk, location: {disk: [-0.1, 0, 0]}}\n"
    settings = {"duration": f"{rounds} s", "tolerance": None, "integrator": "rk4"}
    settings |= {"step": "10 ms", "output_step": "70 ms"}
    text = roller(f"{{ellipse: [{float(rim)!r}, {float(rim)!r}]}}", (float(arm), 0.0), rest, **settings)
    r = run(text, formulation=formulation, kinematic=formulation != "full")
    θ = 2.0 * np.pi * r.time
    np.testing.assert_allclose(coordinate(r, "R.lap"), θ, atol=1e-12)
    np.testing.assert_allclose(coordinate(r, "R.angle"), arm / 0.1 * θ, rtol=1e-12, atol=1e-12)
    centre = arm * np.exp(1j * θ)
    expected = centre - 0.1 * np.exp(1j * arm / 0.1 * θ)
    found = r["markers/position"][:, 0]
    np.testing.assert_allclose(found[:, 0] + 1j * found[:, 2], expected, atol=1e-12)
    assert r["diagnostics/position_violation"].max() < 1e-13


@pytest.mark.parametrize(("side", "sign"), [("inside", 1.0), ("outside", -1.0)])
def test_what_the_contact_passes_on_an_ellipse_is_what_the_roller_unrolls(side, sign):
    """σ of the profile against r (φ - θ) of the rim, over more than a lap: θ is the angle of the tangent."""
    a, b = 0.5, 0.35
    rest = "motions:\n  drive: {joint: R, lap: 2 * pi * t}\n"
    settings = {"duration": "1.3 s", "tolerance": None, "integrator": "rk4", "step": "20 ms"}
    text = roller(f"{{ellipse: [{a}, {b}]}}", (a - sign * 0.1, 0.0), rest, own=f", side: {side}", **settings)
    r = run(text, formulation="planar")
    x, _, z = r["bodies/position"][:, 0].T
    s = np.zeros_like(x)  # the parameter of the foot, by Newton's method on its equation
    s = np.arctan2(z / b, x / a) + 2.0 * np.pi * np.round(r.time - np.arctan2(z / b, x / a) / (2.0 * np.pi))
    for _ in range(30):
        f = (x - a * np.cos(s)) * -a * np.sin(s) + (z - b * np.sin(s)) * b * np.cos(s)
        slope = -(a**2) * np.sin(s) ** 2 - b**2 * np.cos(s) ** 2
        slope += (x - a * np.cos(s)) * -a * np.cos(s) - (z - b * np.sin(s)) * b * np.sin(s)
        s -= f / slope
    σ = b * ellipeinc(s, 1.0 - (a / b) ** 2)
    θ = np.unwrap(np.arctan2(b * np.cos(s), -a * np.sin(s))) - 0.5 * np.pi
    np.testing.assert_allclose(σ + sign * 0.1 * (coordinate(r, "R.angle") - θ), 0.0, atol=1e-11)


OPEN = "{points: [[-1, 0.3], [-0.4, 0.05], [0, 0], [0.5, 0.1], [1, 0.4]]}"
LIMITS = ", side: left, limits: {displacement: {range: [0.1, 2.1], rigid: true}}"


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_over_the_knots_of_a_spline_its_energy_stays(formulation):
    """It rolls down from the left and up again, past three knots: m g z is ½ (m + J/r²) v² all along."""
    text = roller(OPEN, (-0.7, 0.3), own=LIMITS, duration="1.5 s", tolerance=1e-10, adjust_joints="1 m")
    r = run(text, formulation=formulation)
    z, v = r["bodies/position"][:, 0, 2], r["bodies/velocity"][:, 0]
    energy = 0.5 * (2.0 + 0.015 / 0.01) * (v**2).sum(axis=1) + 2.0 * scenes.GRAVITY * z
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    assert np.ptp(r["bodies/position"][:, 0, 0]) > 1.0
    assert r["diagnostics/position_violation"].max() < 1e-13


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (", roller: 0.1", "", "missing key 'roller'"),
        ("roller: 0.1", "roller: 0.4", "does not fit curve 'track'"),
        ("side: inside", "side: left", "curve 'track' is closed"),
    ],
)
def test_mistakes_are_told(old, new, message):
    text = roller("{ellipse: [0.3, 0.3]}", (0.2, 0.0), own=", side: inside")
    with pytest.raises(InputError, match=message):
        mbproj.read_scene_text(text.replace(old, new), "f.yaml")


@pytest.mark.full_where(formulation="full")
@crossed("radius, formulation", [0.05, 0.1], FORMULATIONS, dear=["full"])
def test_a_run_from_any_state_knows_how_far_the_roller_has_come(formulation, radius):
    """After half a turn the pose alone has another angle: once the row was off by a turn of the roller, 2 π r."""
    start, few = (0.7 + radius, 0.0), {"duration": "0.7 s", "output_step": "0.1 s", "tolerance": 1e-9}
    text = roller("{ellipse: [0.7, 0.6]}", start, **few).replace("roller: 0.1", f"roller: {radius}")
    ready = Mechanism.of(mbproj.read_scene_text(text))
    whole = replace(ready.scene.settings, formulation=formulation)
    states = [simulate(ready.system, ready.state, replace(whole, duration=end)).state for end in (0.6, 0.7)]
    assert abs(states[0].turns).max() == 1
    again = simulate(ready.system, states[0], replace(whole, duration=0.1)).state
    np.testing.assert_allclose(again.q, states[1].q, atol=1e-8)
