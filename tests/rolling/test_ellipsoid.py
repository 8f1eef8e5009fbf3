"""What rolls on an ellipsoid: a rattleback against equations of its own, a ball, an ellipse in a plane."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipeinc

import mbproj
from mbproj.errors import InputError
from mbproj.pages import PoseHistory, look_of
from tests.crossed import full
from tests.rolling import scenes
from tests.rolling.scenes import ellipsoid, of_rattleback, rattleback


def run(text, **settings):
    return mbproj.run(mbproj.read_scene_text(text), **settings)


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
