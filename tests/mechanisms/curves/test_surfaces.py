"""Balls on surfaces of revolution: against pendulums, Clairaut's relation, and the frequencies at a bowl's bottom."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import modes, read_scene_text
from mbproj.base.errors import InputError
from mbproj.show.appearance.mechanism import look_of, view_of
from mbproj.show.appearance.motion import motion_at
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import run
from tests.support import assembled

FORMULATIONS = ["reduced", full("full")]
G, L = 9.81, 0.4
HEAD = """
mbproj: 1
gravity: [0, 0, GRAVITY]
simulation: {duration: 1.5, integrator: dop853, tolerance: 1e-12, output_step: 0.05, formulation: FORMULATION}
bodies:
  ball: {mass: 2, inertia: [0.01, 0.01, 0.01], position: PLACE, velocity: VELOCITY}
"""
#: A ball of 0.1 m in a spherical bowl of 0.5 m: its centre is a pendulum of 0.4 m.
BOWL = """
curves: {bowl: {circle: 0.5}}
joints:
  J: {type: ball_on_surface, bodies: [ground, ball], locations: [[0, 0, 0], PLACE], axis: z, curve: bowl, roller: 0.1,
    side: inside}
"""
ROD = "joints: {J: {type: distance, bodies: [ground, ball], locations: [[0, 0, 0], PLACE], length: 0.4}}\n"
#: The tube of a tyre that is higher than wide.
TYRE = """
curves: {tube: {points: [[0.6, 0], [0.4, 0.25], [0.25, 0], [0.4, -0.2]], closed: true}}
joints:
  J: {type: ball_on_surface, bodies: [ground, ball], locations: [[0, 0, 0], PLACE], axis: z, curve: tube, side: outside}
"""


def scene(joint, place, velocity, formulation="reduced", gravity=-G):
    text = HEAD.replace("FORMULATION", formulation).replace("GRAVITY", str(gravity)) + joint
    return text.replace("PLACE", str(list(place))).replace("VELOCITY", str(list(velocity)))


@needs_kernel
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_ball_goes_round_in_a_bowl_as_a_conical_pendulum(formulation):
    """ω² = g / (L cos θ), and the push m g / cos θ."""
    θ = 0.7
    ω = float(np.sqrt(G / (L * np.cos(θ))))
    place = (float(L * np.sin(θ)), 0.0, float(-L * np.cos(θ)))
    _, recorded = run(scene(BOWL, place, (0.0, ω * place[0], 0.0), formulation))
    x, y, z = recorded["bodies/position"][:, 0].T
    t = recorded["time"]
    np.testing.assert_allclose(x, place[0] * np.cos(ω * t), rtol=0, atol=1e-9)
    np.testing.assert_allclose(y, place[0] * np.sin(ω * t), rtol=0, atol=1e-9)
    np.testing.assert_allclose(z, place[2], rtol=0, atol=1e-10)
    push = np.linalg.norm(recorded["joints/reaction_force"][:, 0], axis=-1)
    np.testing.assert_allclose(push, 2.0 * G / np.cos(θ), rtol=1e-9)
    np.testing.assert_allclose(recorded["joints/coordinate"][:, 0], 0.5 * (1.5 * np.pi + θ), rtol=1e-9)


@needs_kernel
@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize(
    ("place", "velocity"),
    [
        ((0.24, 0.0, -0.32), (0.4, 1.1, 0.3)),
        ((0.24, 0.0, -0.32), (0.0, 0.0, 0.0)),  # through the axis
        ((0.0, 0.0, -0.4), (1.3, 0.6, 0.0)),  # from the axis
    ],
)
def test_it_swings_as_on_a_rod(place, velocity, formulation):
    _, found = run(scene(BOWL, place, velocity, formulation))
    _, known = run(scene(ROD, place, velocity, formulation))
    np.testing.assert_allclose(found["bodies/position"], known["bodies/position"], rtol=0, atol=1e-8)
    assert np.abs(known["bodies/position"][:, 0, 0]).max() > 0.2
    distance = np.linalg.norm(found["bodies/position"][:, 0], axis=-1)
    np.testing.assert_allclose(distance, L, rtol=0, atol=1e-13)


@needs_kernel
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_point_follows_a_geodesic_of_a_tyre(formulation):
    """Without forces its speed is constant, and so is ρ v_φ (Clairaut), while ρ changes."""
    place = (0.6, 0.0, 0.0)
    _, recorded = run(scene(TYRE, place, (0.0, 0.8, 1.2), formulation, gravity=0))
    (x, y, z), (u, v, w) = recorded["bodies/position"][:, 0].T, recorded["bodies/velocity"][:, 0].T
    moment, square = x * v - y * u, u**2 + v**2 + w**2
    np.testing.assert_allclose(moment, 0.6 * 0.8, rtol=1e-9)
    np.testing.assert_allclose(square, square[0], rtol=1e-9)
    assert np.ptp(np.hypot(x, y)) > 0.1 and np.ptp(z) > 0.2


@needs_kernel
def test_the_bottom_of_a_bowl_has_the_frequencies_of_a_pendulum():
    """At the axis itself, where ρ has a kink and the bowl has none."""
    found = modes(read_scene_text(scene(BOWL, (0.0, 0.0, -L), (0.0, 0.0, 0.0))))
    ω = sorted(abs(each) for each in found.eigenvalues)
    np.testing.assert_allclose(ω[-2:], np.sqrt(G / L), rtol=1e-9)


def test_an_open_surface_needs_limits_on_the_way_along_its_meridian():
    text = scene(BOWL, (0.24, 0.0, -0.32), (0.0, 0.0, 0.0)).replace("circle: 0.5", "points: [[0, 0], [1, 0.3], [2, 1]]")
    with pytest.raises(InputError, match="'side'"):
        read_scene_text(text.replace("side: inside", ""))
    with pytest.raises(InputError, match=r"may leave its curve, which ends; give limits: \{displacement: \{range"):
        read_scene_text(text.replace("side: inside", "side: left"))


def test_a_meridian_has_to_be_beside_the_axis():
    tube = TYRE.replace(
        "[[0.6, 0], [0.4, 0.25], [0.25, 0], [0.4, -0.2]]", "[[-0.6, 0], [-0.4, 0.25], [-0.25, 0], [-0.4, -0.2]]"
    )
    with pytest.raises(
        InputError, match="'tube' is nowhere at x > 0, and its x is the distance from the axis; mirror it"
    ):
        read_scene_text(scene(tube, (0.6, 0.0, 0.0), (0.0, 0.0, 0.0)))


def test_its_picture_has_the_whole_surface_and_nothing_through_the_axis():
    """The circle is drawn where it is beside the axis: two parts of each meridian, and no line from pole to pole."""
    bowl = read_scene_text(scene(BOWL, (0.24, 0.0, -0.32), (0.0, 1.0, 0.0)))
    system, state = assembled(bowl)
    motion = motion_at(system, state.q)
    look = look_of(bowl, motion, {})
    assert view_of(bowl, motion, look).radius > 0.5
    wires = [drawn.part.outline() for drawn in look.drawn if drawn.layer == "ground"]
    reach = [np.hypot(*wire[:, :2].T).max() for wire in wires if np.ptp(wire[:, 2]) > 0.1]
    assert len(reach) == 16
    assert min(reach) > 0.4
