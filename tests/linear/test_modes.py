"""Modes against closed forms and against a mechanism's own eigenvalue problem."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from scipy.special import jn_zeros

from mbproj.base.errors import InputError
from mbproj.linear.eigenvalues import ReducedEquations, eigen
from tests.linear.closed_forms import HEAD, LAVAL, TOP, chain, chain_frequencies, g, modes_of, under_gravity, weightless

BAR = under_gravity("""\
bodies:
  bar: {mass: 2, inertia: [0.1, 0.17, 0.17], position: [0, 0, AT], orientation: {axis: [0, 1, 0], angle: 90 deg}}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
""")


def test_a_pendulum():
    found = modes_of(BAR.replace("AT", "-0.5"))
    np.testing.assert_allclose(found.eigenvalues, [1j * sqrt(2 * g * 0.5 / (0.17 + 2 * 0.25))], rtol=1e-14)
    assert found.freedom == 1
    assert found.damping_ratios[0] == 0.0


def test_a_rod_upside_down_falls_at_its_rate():
    found = modes_of(BAR.replace("AT", "0.5"))
    growth = sqrt(2 * g * 0.5 / (0.17 + 2 * 0.25))
    np.testing.assert_allclose(sorted(found.eigenvalues.real), [-growth, growth], rtol=1e-14)
    np.testing.assert_array_equal(found.frequencies, 0.0)


def test_a_mass_that_round_off_of_others_hides_has_no_frequency():
    """Of a motion whose inertia is 1e-20 of another's, in coordinates that mix both."""
    M, K, none = np.array([[1.0, 1.0], [1.0, 1.0 - 1e-16]]), np.eye(2), np.zeros((2, 2))
    with pytest.raises(InputError, match="round-off of other bodies' inertia hides that of a motion"):
        eigen(ReducedEquations(M, none, K, none, np.abs(K), np.eye(2)))


@pytest.mark.parametrize("links", [1, 2, 5, 30])
def test_hanging_chains_have_the_frequencies_of_their_own_equations(links):
    found = modes_of(chain(links))
    np.testing.assert_allclose(found.eigenvalues.imag, chain_frequencies(links), rtol=1e-12)
    np.testing.assert_array_equal(found.eigenvalues.real, 0.0)


def test_a_long_chain_by_sparse_matrices():
    """And its slowest frequencies go to those of a heavy rope, ½ √(g/L) times the zeros of J0 (Bernoulli), as 1/n²."""
    found = modes_of(chain(400), count=6)
    np.testing.assert_allclose(found.eigenvalues.imag, chain_frequencies(400)[:6], rtol=1e-11)
    rope = 0.5 * sqrt(g) * jn_zeros(0, 4)
    np.testing.assert_allclose(found.eigenvalues.imag[:4], rope, rtol=1e-4)
    off = [abs(chain_frequencies(n)[0] / rope[0] - 1) for n in (20, 40)]
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("spin", [0.0, 60.0, 100.0, 200.0, 400.0])
def test_a_top_upright_nods_and_precesses(spin):
    """A ω² - C n ω + m g l = 0 of the axis' deviation x + i y = e^(iωt)."""
    A, C, mgl = 0.002 + 0.5 * 0.01, 0.0008, 0.5 * g * 0.1
    root = np.sqrt(complex((C * spin) ** 2 - 4 * A * mgl))
    expected = 1j * np.array([C * spin - root, C * spin + root]) / (2 * A)
    found = modes_of(TOP, spin=spin).eigenvalues
    moving = found[np.abs(found) > 1e-6]
    if spin == 0.0:
        expected = np.array([-1.0, -1.0, 1.0, 1.0]) * abs(expected[0])
    np.testing.assert_allclose(np.sort_complex(moving), np.sort_complex(expected), rtol=1e-9)
    assert len(found) - len(moving) == 1, "the spin itself is neutral"


@pytest.mark.parametrize("spin", [0.0, 100.0, 400.0])
def test_a_rotor_whirls_forward_and_backward(spin):
    """Shifts √(2k/m); tilts J ω² - C Ω ω - κ = 0 with κ = 2 k a (a + d), forward one root and backward the other."""
    k, a, d, A, C, m = 1000.0, 0.2, 0.3, 0.02, 0.03, 3.0
    κ = 2 * k * a * (a + d)
    root = sqrt((C * spin) ** 2 + 4 * A * κ)
    tilts = [(root - C * spin) / (2 * A), (root + C * spin) / (2 * A)]
    shift = sqrt(2 * k / m)
    expected = np.sort([0.0, *tilts, shift, shift, sqrt(2 * k / m)])
    found = modes_of(LAVAL, spin=spin)
    np.testing.assert_allclose(np.sort(found.eigenvalues.imag), expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.eigenvalues.real, 0.0, atol=1e-9)


def test_a_whirl_has_the_sense_of_its_direction():
    found = modes_of(LAVAL, spin=400.0)
    tilts = [shape[0] for shape in found.shapes if abs(shape[0, 3]) > 0.5]
    backward, forward = (tilt[4] / tilt[3] for tilt in tilts)
    np.testing.assert_allclose([backward, forward], [1j, -1j], atol=1e-9)


def test_damping_of_one_mass():
    """λ² m + λ c + k = 0 below and above the aperiodic limit."""
    text = under_gravity("""\
parameters: {c: 1}
bodies:
  m: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  j: {type: prismatic, bodies: [ground, m], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  s: {type: linear_spring_damper, joint: j, stiffness: 50, damping: c}
""")
    for c in (0.5, 5.0, 40.0):
        found = modes_of(text, c=c).eigenvalues
        expected = [value for value in np.roots([2, c, 50]) if value.imag >= 0]
        np.testing.assert_allclose(
            np.sort_complex(found), np.sort_complex(np.array(expected, dtype=complex)), rtol=1e-12
        )


def test_equal_pendulums_have_one_frequency_many_times_and_shapes_of_their_own():
    bodies = "".join(f"  p{i}: {{mass: 1, inertia: [1, 1, 1], position: [{i}, 0, -1]}}\n" for i in range(4))
    joints = "".join(
        f"  j{i}: {{type: revolute, bodies: [ground, p{i}], location: [{i}, 0, 0], axis: [0, 1, 0]}}\n"
        for i in range(4)
    )
    found = modes_of(HEAD + "bodies:\n" + bodies + "joints:\n" + joints)
    np.testing.assert_allclose(found.eigenvalues, 1j * sqrt(g / 2), rtol=1e-14)
    assert np.linalg.matrix_rank(found.coordinates) == 4


def test_a_free_body_has_six_neutral_directions():
    text = HEAD.replace("-9.81", "0") + "bodies:\n  b: {mass: 1, inertia: [1, 2, 2.5], position: [0, 0, 0]}\n"
    found = modes_of(text)
    np.testing.assert_array_equal(found.eigenvalues, np.zeros(6))
    assert np.linalg.matrix_rank(found.shapes.reshape(6, 6)) == 6


def test_two_masses_and_a_spring_in_space():
    """Of twelve directions one oscillates, √(k/μ); the spring, which has no preload, holds no other."""
    text = weightless("""\
bodies:
  a: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  b: {mass: 3, inertia: [1, 1, 1], position: [1, 0, 0]}
forces:
  s: {type: spring_damper, bodies: [a, b], locations: {a: [0, 0, 0], b: [1, 0, 0]}, stiffness: 12}
""")
    found = modes_of(text)
    assert np.count_nonzero(found.eigenvalues == 0.0) == 11
    np.testing.assert_allclose(found.eigenvalues[-1], 4j, rtol=1e-13)
    assert found.kinetic[-1] == pytest.approx([0.75, 0.25])
    assert found.strain[-1] == pytest.approx([1.0, 0.0], abs=1e-9)


def test_a_sliding_block_with_friction_alone():
    """One neutral direction, and one that dies down: λ m + c = 0."""
    text = under_gravity("""\
bodies:
  m: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  j: {type: prismatic, bodies: [ground, m], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  s: {type: friction, joint: j, coefficient: 3}
""")
    np.testing.assert_allclose(np.sort(modes_of(text).eigenvalues.real), [-1.5, 0.0], rtol=1e-13)


MASSLESS = weightless("""\
parameters: {c: 0}
bodies:
  light: {mass: 0, inertia: [0, 0, 0], position: [0.5, 0, 0]}
  heavy: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  a: {type: prismatic, bodies: [ground, light], location: [0, 0, 0], axis: [1, 0, 0]}
  b: {type: prismatic, bodies: [light, heavy], location: [0.5, 0, 0], axis: [1, 0, 0]}
forces:
  first: {type: linear_spring_damper, joint: a, stiffness: 30, damping: c}
  second: {type: linear_spring_damper, joint: b, stiffness: 60}
""")


def test_a_body_without_mass_between_two_springs():
    """They act in series: 30 and 60 N/m make 20. With a damper beside one of them the body has a mode of its own."""
    found = modes_of(MASSLESS)
    np.testing.assert_allclose(found.eigenvalues, [1j * sqrt(20 / 2)], rtol=1e-13)
    assert found.strain[0] == pytest.approx([2 / 3, 1 / 3, 0.0], abs=1e-9)
    damped = modes_of(MASSLESS, c=4.0).eigenvalues
    # 2 λ² x + 60 (x - y) = 0 and 4 λ y + 30 y + 60 (y - x) = 0
    expected = np.roots(np.polysub(np.polymul([2, 0, 60], [4, 90]), [3600]))
    np.testing.assert_allclose(np.sort_complex(damped), np.sort_complex(expected[expected.imag >= -1e-12]), rtol=1e-10)


def test_a_motion_without_mass_that_nothing_holds_is_refused():
    text = MASSLESS.replace("stiffness: 30", "stiffness: 0").replace("stiffness: 60", "stiffness: 0")
    with pytest.raises(InputError, match="a motion moves no mass, and no force holds it"):
        modes_of(text)


def test_redundant_joints_change_nothing():
    """A planar four-bar on four pins, three rows too many, beside one whose loop a ball and a universal joint close."""
    text = under_gravity("""\
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, -0.5]}
  b: {mass: 2, inertia: [0.3, 0.3, 0.3], position: [0.5, 0, -1]}
  c: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, -0.5]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [a, b], location: [0, 0, -1], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [b, c], location: [1, 0, -1], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [c, ground], location: [1, 0, 0], axis: [0, 1, 0]}
""")
    found = modes_of(text)
    expected = sqrt((2 * 0.5 * g + 2 * g) / (2 * (0.1 + 0.25) + 2))
    np.testing.assert_allclose(found.eigenvalues, [1j * expected], rtol=1e-13)
    loose = text.replace("C: {type: revolute", "C: {type: spherical").replace(", axis: [0, 1, 0]}\n  D", "}\n  D")
    loose = loose.replace(
        "B: {type: revolute, bodies: [a, b], location: [0, 0, -1], axis: [0, 1, 0]}",
        "B: {type: universal, bodies: [a, b], location: [0, 0, -1], axes: [[0, 1, 0], [0, 0, 1]]}",
    )
    np.testing.assert_allclose(modes_of(loose).eigenvalues, [1j * expected], rtol=1e-13)


def test_motions_hold_what_they_drive():
    """A pendulum on a driven crank that stands still, and one on a rotor that turns at a constant speed Ω, whose hinge
    is across the axis: cos of the hang against Ω² (Watt's governor with a rigid shaft) is tested with --at steady."""
    text = under_gravity("""\
bodies:
  crank: {mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0]}
  bob: {mass: 1, inertia: [0.2, 0.2, 0.2], position: [1, 0, -0.5]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [crank, bob], location: [1, 0, 0], axis: [0, 1, 0]}
motions:
  hold: {joint: A, angle: 0}
""")
    np.testing.assert_allclose(modes_of(text).eigenvalues, [1j * sqrt(0.5 * g / 0.45)], rtol=1e-13)


def test_reflected_inertia_slows_a_pendulum():
    text = (
        BAR.replace("AT", "-0.5")
        .replace("axis: [0, 1, 0]}\n", "axis: [0, 1, 0], reflected_inertia: 0.4}\n")
        .replace("orientation: {axis: [0, 1, 0], reflected_inertia: 0.4}", "orientation: {axis: [0, 1, 0]}")
    )
    found = modes_of(text)
    np.testing.assert_allclose(found.eigenvalues.imag, sqrt(g / (0.17 + 0.5 + 0.4)), rtol=1e-13)
    assert found.kinetic[0, 1] == pytest.approx(0.4 / 1.07)
    assert found.kinetic_names == ("bar", "pin.angle.inertia")


def test_away_from_balance_a_pendulum_has_the_slope_of_its_equation():
    """θ'' = -(mgd/I) sin θ, linearised at any θ: -(mgd/I) cos θ, whatever the acceleration there."""
    tilted = BAR.replace("position: [0, 0, AT]", "position: [0.3, 0, -0.4]").replace(
        "angle: 90", "angle: 53.13010235415598"
    )
    found = modes_of(tilted)
    expected = 2 * g * 0.5 / (0.17 + 2 * 0.25) * 0.8
    np.testing.assert_allclose(found.eigenvalues, [1j * sqrt(expected)], rtol=1e-9)
    assert found.reference.imbalance.relative == pytest.approx(0.6 * 0.5 / 1.0, rel=0.5)


def test_and_so_it_has_while_it_swings():
    moving = BAR.replace("AT", "-0.5").replace("location: [0, 0, 0]", "location: [0, 0, 0], speed: 3")
    found = modes_of(moving)
    np.testing.assert_allclose(found.eigenvalues, [1j * sqrt(2 * g * 0.5 / 0.67)], rtol=1e-9)
    assert 2 * pi * found.frequencies[0] == pytest.approx(abs(found.eigenvalues[0]))


def test_a_structure_that_cannot_move_has_no_modes():
    text = (
        BAR.replace("AT", "-0.5")
        + "  pin2: {type: revolute, bodies: [ground, bar], location: [1, 0, 0], axis: [0, 1, 0]}\n"
    )
    found = modes_of(text)
    assert (found.freedom, len(found.eigenvalues), found.shapes.shape) == (0, 0, (0, 1, 6))


DAMPED = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {a: {mass: 2, inertia: [1e-3, 1e-3, 1e-3], position: [0.1, 0, 0]}}
joints: {A: {type: prismatic, bodies: [ground, a], location: [0, 0, 0], axis: [1, 0, 0]}}
forces: {s: {type: linear_spring_damper, joint: A, stiffness: 90, damping: 70}}
"""


def test_what_a_damper_takes_is_not_kept_by_gravity():
    """Of a mode that creeps the spring keeps all, whatever the damper takes; and nothing weighs without gravity."""
    found = modes_of(DAMPED)
    assert found.eigenvalues.imag.tolist() == [0.0, 0.0]
    assert found.strain_names == ("s", "preload")
    np.testing.assert_allclose(found.strain, [[1.0, 0.0], [1.0, 0.0]], atol=1e-9)


def test_what_a_damped_bushing_takes_is_not_kept_by_preload():
    """Of 2 λ² + c λ + k = 0 with c² > 8 k: both motions along x creep, and the stiffness keeps all of either."""
    text = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {a: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}}
joints: {A: {type: prismatic, bodies: [ground, a], location: [0, 0, 0], axis: [1, 0, 0]}}
forces:
  b:
    type: bushing
    bodies: [ground, a]
    location: [0, 0, 0]
    stiffness: {translation: [4, 4, 4]}
    damping: {translation: [12, 12, 12]}
"""
    found = modes_of(text)
    np.testing.assert_allclose(np.sort(found.eigenvalues.real), np.sort(np.roots([2, 12, 4])), rtol=1e-12)
    assert found.strain_names[-1] == "preload"
    np.testing.assert_allclose(found.strain[:, -1], 0.0, atol=1e-9)
