"""What rolls, on planes and on ellipsoids, against closed forms and equations of its own; the path of contact."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipeinc

import mbproj
from mbproj.base.errors import InputError
from mbproj.model.euler_parameters import product
from mbproj.show.appearance.mechanism import look_of
from mbproj.show.appearance.motion import PoseHistory
from tests.crossed import crossed, full
from tests.rolling import scenes
from tests.rolling.scenes import ellipsoid, of_rattleback, rattleback, run
from tests.support import ROOT

# What rolls, against closed forms and against a solution of equations of its own, in each formulation that has it.

FORMULATIONS = ["full", "reduced"]


@pytest.fixture(params=FORMULATIONS)
def formulation(request):
    return request.param


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


# What rolls on an ellipsoid: a rattleback against equations of its own, a ball, an ellipse in a plane.


@pytest.mark.parametrize(("spin", "skew", "turns"), [(-3.0, 0.1, True), (3.0, 0.1, False), full(3.0, -0.1, True)])
def test_a_rattleback_turns_back_where_it_is_spun_against_its_sense(spin, skew, turns):
    r = run(rattleback(spin, skew, duration="0.8 s", tolerance=1e-12), formulation="reduced")
    position, ω = of_rattleback(r.time, spin, skew)
    np.testing.assert_allclose(r["bodies/angular_velocity"][:, 0], ω, atol=2e-8)
    np.testing.assert_allclose(r["bodies/position"][:, 0], position, atol=2e-9)
    assert (r["bodies/angular_velocity"][-1, 0, 2] * spin < 0.0) == turns
    assert r["diagnostics/position_violation"].max() < 1e-13
    assert r["diagnostics/velocity_violation"].max() < 1e-13
    energy = r["diagnostics/kinetic_energy"] + r["diagnostics/potential_energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_the_full_formulation_rolls_it_alike():
    settings = {"tolerance": 1e-11, "duration": "0.05 s", "output_step": "0.05 s"}
    ends = [run(rattleback(-3.0, 0.1, **settings), formulation=each) for each in ("full", "reduced")]
    for name in ("bodies/position", "bodies/angular_velocity", "joints/reaction_force"):
        np.testing.assert_allclose(ends[0][name][-1], ends[1][name][-1], rtol=1e-9, atol=1e-10)


def test_a_ball_is_an_ellipsoid_and_rolls_alike_on_a_turntable():
    ball = scenes.turntable()
    (joint,) = [line for line in ball.splitlines() if "rolling_ball" in line]
    other = ball.replace(joint, ellipsoid("ball", "[0.5, 0.1, 0.1]", 0.3, [0.1, 0.1, 0.1], "table"))
    ends = [run(text, formulation="reduced") for text in (ball, other)]
    for name in ("bodies/position", "bodies/velocity", "bodies/angular_velocity"):
        np.testing.assert_allclose(ends[0][name], ends[1][name], atol=1e-11)
    np.testing.assert_allclose(ends[1]["bodies/position"][:, 1, :2], scenes.on_turntable(ends[1].time), atol=2e-9)


def elliptic(**simulation: object) -> str:
    """A cylinder of elliptic section, which a joint keeps in a plane, stands on end a little off and falls over."""
    body = "  egg: {mass: 2, inertia: [0.01, 0.02, 0.02], position: [0, 0, 0.3], angular_velocity: [0, 0.5, 0], "
    body += "velocity: [0.15, 0, 0]}"
    joints = "  P: {type: planar, bodies: [ground, egg], location: [0, 0, 0.3], axis: [0, 1, 0]}\n"
    return scenes.scene(body, joints + ellipsoid("egg", "[0, 0, 0.3]", 0.0, [0.1, 0.2, 0.3]), **simulation)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["full", "reduced", "planar"])
def test_an_ellipse_rolls_its_circumference_along_a_line(formulation):
    """It touches where the arc from its lowest point at the start ends; its energy says how fast it turns."""
    few = {"duration": "0.4 s", "output_step": "0.2 s", "tolerance": 1e-8} if formulation == "full" else {}
    r = run(elliptic(**few), formulation=formulation)
    x, _, z = r["bodies/position"][:, 0].T
    θ = r["joints/coordinate"][:, r.names("coordinates").index("P.angle")]
    a, c = 0.1, 0.3
    height = np.hypot(a * np.sin(θ), c * np.cos(θ))
    np.testing.assert_allclose(z, height, atol=1e-13)
    aside = (a**2 - c**2) * np.sin(θ) * np.cos(θ) / height  # of the lowest point, from the centre
    lowest = np.arctan2(a * np.sin(θ), c * np.cos(θ))  # its parameter on the ellipse
    lowest += 2.0 * np.pi * np.round((θ - lowest) / (2.0 * np.pi))
    arc = a * ellipeinc(lowest, 1.0 - (c / a) ** 2)
    bound = 1e-6 if formulation == "full" else 2e-9
    np.testing.assert_allclose(x + aside, arc, atol=bound)
    ω = r["bodies/angular_velocity"][:, 0, 1]
    inertia = 0.02 + 2.0 * (height**2 + aside**2)
    energy = 0.5 * inertia * ω**2 + 2.0 * scenes.GRAVITY * z
    np.testing.assert_allclose(energy, energy[0], rtol=bound)
    assert abs(θ[-1]) > 0.2


def test_its_contact_is_drawn_on_the_plane_below_it():
    scene = mbproj.read_scene_text(rattleback(-3.0, 0.1))
    lean = 0.02
    orientation = np.array([[np.cos(lean / 2.0), np.sin(lean / 2.0), 0.0, 0.0]])
    s, c = np.sin(lean), np.cos(lean)
    squares = 0.03**2 * np.cos(0.1) ** 2 + 0.2**2 * np.sin(0.1) ** 2, 0.02**2
    reach = np.sqrt(squares[0] * s**2 + squares[1] * c**2)
    middle = [[0.0, 0.01 * s, reach - 0.01 * c]]
    motion = PoseHistory(np.zeros(1), np.array([middle]), orientation[:, None])
    (contact,) = look_of(scene, motion, {}).touching
    (found,) = contact.path(motion)
    assert found[2] == pytest.approx(0.0, abs=1e-15)
    assert found[1] == pytest.approx((squares[1] - squares[0]) * s * c / reach, abs=1e-15)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("x_axis: [cos(0.1), -sin(0.1), 0]", "x_axis: [0, 0, 2]", "'x_axis' is along the axis"),
        ("x_axis: [cos(0.1), -sin(0.1), 0], ", "", "missing key 'x_axis'"),
        ("x_axis: [cos(0.1), -sin(0.1), 0]", "x_axis: {celt: [1, 0, 0]}", "mixes global and local: its 'x_axis'"),
        ("[0.2, 0.03, 0.02]", "[0.2, 0.03]", "semi-axes"),
        ("[0.2, 0.03, 0.02]", "[0.2, 0, 0.02]", "semi_axes"),
        ("[0.2, 0.03, 0.02]", "[0.2 kg, 0.1, 0.02]", "semi_axes"),
    ],
)
def test_mistakes_are_told_at_their_line(old, new, message):
    text = rattleback(-3.0, 0.1)
    assert old in text
    with pytest.raises(InputError, match=message) as error:
        mbproj.read_scene_text(text.replace(old, new), "f.yaml")
    assert "f.yaml:7:" in str(error.value)


# Pictures draw the path on which a wheel touches its plane.


def test_the_path_of_a_contact_is_on_the_plane_and_below_a_wheel():
    """A coin's centre goes round at 1 m, and the coin touches at 1 + R cos θ."""
    scene = mbproj.read_scene_text(scenes.coin())
    turns = np.linspace(0.0, 2.0, 5)
    half, lean = 0.5 * turns, 0.5 * scenes.TILT
    position = [np.cos(turns), np.sin(turns), np.full(5, scenes.RADIUS * np.sin(scenes.TILT))]
    about_z = np.column_stack([np.cos(half), 0 * half, 0 * half, np.sin(half)])
    orientation = product(about_z, np.array([np.cos(lean), 0.0, np.sin(lean), 0.0]))
    motion = PoseHistory(turns, np.column_stack(position)[:, None], orientation[:, None])
    (contact,) = look_of(scene, motion, {}).touching
    far = 1.0 + scenes.RADIUS * np.cos(scenes.TILT)
    expected = np.column_stack([far * np.cos(turns), far * np.sin(turns), 0.0 * turns])
    np.testing.assert_allclose(contact.path(motion), expected, atol=1e-15)
