"""Rods whose length may change: driven, limited, and coupled, as the parts of a rope between points are."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbproj import InputError, read_scene_text
from tests.crossed import where
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import run

pytestmark = needs_kernel
FORMULATIONS = ("planar", "reduced", "full")
G = 9.81
HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: {duration}, integrator: {integrator}, tolerance: 1.0e-11, output_step: 10 ms,
  formulation: {formulation}}}
"""
#: A boom of 10 kg that a cylinder lifts, from 1 m below its hinge to 1 m along it.
BOOM = """
bodies:
  boom: {mass: 10, inertia: [1, 2, 3], position: [1.5, 0, 0]}
joints:
  hinge: {type: revolute, bodies: [ground, boom], location: [0, 0, 0], axis: [0, -1, 0]}
  lift: {type: telescope, bodies: [ground, boom], locations: [[0, 0, -1], [1, 0, 0]]}
"""
#: Two masses on a rope over two points, of which one hangs in several strands.
HOIST = """
bodies:
  left: {mass: 2, inertia: [1, 1, 1], position: [0, 0, -1]}
  right: {mass: 3, inertia: [1, 1, 1], position: [1, 0, -2]}
joints:
  a: {type: telescope, bodies: [ground, left], locations: [[0, 0, 0], [0, 0, -1]]}
  b: {type: telescope, bodies: [ground, right], locations: [[1, 0, 0], [1, 0, -2]], speed: 0.3}
  rope: {type: coupler, of: {a.length: 1, b.length: STRANDS}}
"""


def scene(body, formulation="auto", duration=2, integrator="dop853"):
    return HEAD.format(formulation=formulation, duration=duration, integrator=integrator) + body


def coordinates(recorded):
    """By column, in the order of the joints."""
    return recorded["joints/coordinate"].T


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS))
@pytest.mark.parametrize("motion", ["constant_speed: 10 cm/s", "expression: sqrt(2) + 0.1*t"])
def test_a_cylinder_lifts_a_boom(motion, formulation):
    """l² = 2 + 2 sin φ, and its power is that of the weight and of what the boom gains. A constant speed counts from
    the length at the scene's pose."""
    text = scene(BOOM + f"motions:\n  extend: {{joint: lift, length: {{{motion}}}}}\n", formulation)
    _, recorded = run(text.replace("formulation: full", "formulation: full, kinematic: false"))
    length = np.sqrt(2.0) + 0.1 * recorded["time"]
    sine = 0.5 * length**2 - 1.0
    phi, cosine = np.arcsin(sine), np.sqrt(1.0 - sine**2)
    rate = 0.1 * length / cosine
    acceleration = (0.1**2 + rate**2 * sine) / cosine
    angle, own = coordinates(recorded)
    np.testing.assert_allclose(own, length, rtol=0, atol=1e-13)
    np.testing.assert_allclose(angle, phi, rtol=0, atol=1e-13)
    torque = (2.0 + 10.0 * 1.5**2) * acceleration + 10.0 * G * 1.5 * cosine
    np.testing.assert_allclose(recorded["motions/force"][:, 0], torque * rate / 0.1, rtol=1e-11)
    assert not recorded["joints/reaction_force"][:, 1].any()  # it holds nothing by itself


@pytest.mark.parametrize("integrator", ["dop853", "radau5"])
@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS[1:]))
@pytest.mark.parametrize("strands", [1, 2, 8])
def test_a_tackle_gains_force_by_its_strands(strands, formulation, integrator):
    """s_a + n s_b = const: s_b'' = g (m_b - n m_a) / (m_b + n² m_a), and the rope pulls with m_a (g - s_a'')."""
    _, recorded = run(scene(HOIST.replace("STRANDS", str(strands)), formulation, 0.5, integrator))
    t, n = recorded["time"], float(strands)
    a, b = coordinates(recorded)
    acceleration = G * (3.0 - n * 2.0) / (3.0 + n * n * 2.0)
    np.testing.assert_allclose(b, 2.0 + 0.3 * t + 0.5 * acceleration * t * t, rtol=0, atol=1e-10)
    np.testing.assert_allclose(a + n * b, 1.0 + 2.0 * n, rtol=0, atol=1e-13 * n)  # what positions may be off by
    pull = 2.0 * (G + n * acceleration)
    np.testing.assert_allclose(recorded["joints/reaction_force"][:, 2, 2], n * pull, rtol=1e-9)


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS[1:]))
def test_a_swinging_atwood_machine_with_points(formulation):
    """(m1 + m2) r'' = m1 r θ'² + m1 g cos θ - m2 g, r θ'' = -2 r' θ' - g sin θ (Tufillaro 1984)."""
    swung = HOIST.replace("position: [0, 0, -1]", "position: [0.8, 0, -0.6]").replace(
        "locations: [[0, 0, 0], [0, 0, -1]]", "locations: [[0, 0, 0], [0.8, 0, -0.6]]"
    )
    text = scene(swung.replace("STRANDS", "1").replace(", speed: 0.3", ""), formulation, 1.5)
    _, recorded = run(text)

    def slope(_, y):
        r, rate, theta, omega = y
        bend = (2.0 * r * omega**2 + 2.0 * G * np.cos(theta) - 3.0 * G) / 5.0
        return rate, bend, omega, -(2.0 * rate * omega + G * np.sin(theta)) / r

    start = (1.0, 0.0, np.arctan2(0.8, 0.6), 0.0)
    own = solve_ivp(slope, (0.0, 1.5), start, "DOP853", recorded["time"], rtol=1e-13, atol=1e-13)
    r, _, theta, _ = own.y
    place = np.stack([r * np.sin(theta), 0.0 * r, -r * np.cos(theta)], axis=-1)
    np.testing.assert_allclose(recorded["bodies/position"][:, 0], place, rtol=0, atol=1e-9)


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS[1:]))
def test_a_slack_rope_becomes_taut(formulation):
    """A ball falls beside its rope's length, is held, and takes the rope's other end of 3 kg with it."""
    text = scene(
        """
bodies:
  ball: {mass: 2, inertia: [1, 1, 1], position: [0, 0, -0.5]}
joints:
  rope:
    type: telescope
    bodies: [ground, ball]
    locations: [[0, 0, 0], [0, 0, -0.5]]
    limits: {length: {range: [null, 1 m], rigid: true, restitution: 0.5}}
""",
        formulation,
        0.6,
    )
    _, recorded = run(text)
    impact = np.sqrt(2.0 * 0.5 / G)
    (first, *_) = recorded.of("impact")
    assert first.time == pytest.approx(impact, abs=1e-10)
    t = recorded["time"] - impact
    risen = 1.0 - (0.5 * G * impact * t - 0.5 * G * t * t)
    after = (t > 0.0) & (t < G * impact / G * 0.9)
    np.testing.assert_allclose(coordinates(recorded)[0][after], risen[after], rtol=0, atol=1e-9)


def test_a_rod_that_keeps_its_length_says_what_lets_it_change():
    text = scene(
        BOOM.replace("telescope", "distance") + "motions:\n  extend: {joint: lift, length: {constant_speed: 1}}\n"
    )
    hint = "it keeps its length; a joint of type 'telescope' lets it change"
    with pytest.raises(InputError, match=hint):
        read_scene_text(text)
