"""Couplings of joints against closed forms: racks, belts, differentials, sums of any coordinates, functions of one."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crossed import full, once
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import run

pytestmark = needs_kernel
FORMULATIONS = ("planar", "reduced", "full")
G = 9.81

HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: {duration}, integrator: {integrator}, tolerance: 1.0e-11, output_step: 0.05,
  formulation: {formulation}}}
"""
#: A wheel on a pin, and a weight on an upright rail.
LIFT = """
bodies:
  wheel: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  weight: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [0.05, 0, 0.3]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0]}
  rail: {type: prismatic, bodies: [ground, weight], location: [0.05, 0, 0.3], axis: [0, 0, 1]}
"""
#: Shafts in a line with moments of inertia of 0.2, 0.3 and 0.7 kg m², of which the first is driven.
SHAFTS = """
bodies:
  first: {mass: 1, inertia: [1, 0.2, 1], position: [0, 0, 0]}
  second: {mass: 1, inertia: [1, 0.3, 1], position: [1, 0, 0]}
  third: {mass: 1, inertia: [1, 0.7, 1], position: [2, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, first], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [ground, second], location: [1, 0, 0], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [ground, third], location: [2, 0, 0], axis: [0, 1, 0]}
"""
TORQUE = "forces:\n  drive: {type: torsion_spring_damper, joint: A, torque: 4}\n"


def scene(body, formulation="planar", duration=None, integrator="dop853"):
    if duration is None:
        duration = 0.5 if formulation == "full" else 2  # in NumPy: seconds, or minutes
    return HEAD.format(formulation=formulation, duration=duration, integrator=integrator) + body


def coordinates(recorded):
    """By column, in the order of the joints."""
    return recorded["joints/coordinate"].T


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    ("rack", "formulation", "integrator"),
    once(
        ["{type: rack, joints: [pin, rail], radius: 5 cm}", "{type: coupler, of: {pin: -5 cm, rail: 1}}"],
        FORMULATIONS,
        ["dop853", "radau5"],
    ),
)
def test_a_weight_that_falls_turns_a_wheel(rack, formulation, integrator):
    """(m + J / r²) s'' = -m g, through 56 turns, and the tooth force is what turns the wheel."""
    _, recorded = run(scene(LIFT + f"  mesh: {rack}\n", formulation, integrator=integrator))
    angle, s = coordinates(recorded)
    fall = -3.0 * G / (3.0 + 0.1 / 0.05**2)
    np.testing.assert_allclose(s, 0.5 * fall * recorded["time"] ** 2, rtol=0, atol=9e-11)
    np.testing.assert_allclose(0.05 * angle, s, rtol=0, atol=1e-13)
    force = recorded["joints/reaction_force"][:, 2]  # on the weight
    np.testing.assert_allclose(force, np.tile([0.0, 0.0, 3.0 * (G + fall)], (len(force), 1)), rtol=0, atol=1e-8)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    ("radii", "ratio", "formulation"),
    once([pytest.param("[6 cm, 15 cm]", 0.4), pytest.param("[6 cm, -15 cm]", -0.4)], FORMULATIONS),
)
def test_a_belt_turns_pulleys_by_their_radii(radii, ratio, formulation):
    belt = f"  belt: {{type: belt, joints: [A, B], radii: {radii}}}\n"
    _, recorded = run(scene(SHAFTS + belt + TORQUE, formulation))
    first, second, _ = coordinates(recorded)
    np.testing.assert_allclose(first, 2.0 / (0.2 + ratio**2 * 0.3) * recorded["time"] ** 2, rtol=0, atol=1e-8)
    np.testing.assert_allclose(second, ratio * first, rtol=0, atol=1e-13)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(("formulation", "integrator"), once(FORMULATIONS, ["esdirk4", "dop853"]))
def test_a_differential_gives_both_shafts_the_same_torque(formulation, integrator):
    """Whatever loads them: J0 φ0'' = M - T, J1 φ1'' = J2 φ2'' = T / 2, φ0 = (φ1 + φ2) / 2."""
    gear = "  gears: {type: differential, joints: [A, B, C]}\n"
    report, recorded = run(scene(SHAFTS + gear + TORQUE, formulation, integrator=integrator))
    assert report.degrees_of_freedom == 2
    T = 4.0 / (1.0 + 0.2 / 4.0 * (1.0 / 0.3 + 1.0 / 0.7))
    half = 0.25 * T * recorded["time"] ** 2
    _, second, third = coordinates(recorded)
    np.testing.assert_allclose(second, half / 0.3, rtol=0, atol=1e-8)
    np.testing.assert_allclose(third, half / 0.7, rtol=0, atol=1e-8)
    torque = recorded["joints/reaction_torque"][:, 3, 1]  # of the gears on the last shaft
    np.testing.assert_allclose(torque, 0.5 * T, rtol=0, atol=1e-8)


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_a_planetary_set_has_the_speeds_of_its_teeth(formulation):
    """20 φ_sun + 60 φ_ring = 80 φ_carrier (Willis), with the ring held."""
    gears = "  gears: {type: coupler, of: {A: 20, B: 60, C: -80}}\n"
    text = SHAFTS + gears + TORQUE + "motions:\n  held: {joint: B, angle: 0}\n"
    _, recorded = run(scene(text, formulation))
    sun, _, carrier = coordinates(recorded)
    np.testing.assert_allclose(carrier, sun / 4.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(sun, 2.0 / (0.2 + 0.7 / 16.0) * recorded["time"] ** 2, rtol=0, atol=1e-8)


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_an_indexing_drive_steps_by_quarters_of_a_turn(formulation):
    """Cycloidal steps of a shaft that a motion drives at 3 turns a second; the motion's work is the shaft's energy."""
    index = '  index: {type: coupler, of: {A: 0, B: 1}, function: "-(s - sin(s)) / 4"}\n'
    text = SHAFTS + index + "motions:\n  turn: {joint: A, angle: {constant_speed: 180 rpm}}\n"
    _, recorded = run(scene(text, formulation, duration=1))
    s, found, _ = coordinates(recorded)
    assert s[-1] == pytest.approx(6.0 * np.pi, abs=1e-12)
    np.testing.assert_allclose(found, -(s - np.sin(s)) / 4.0, rtol=0, atol=1e-12)
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_a_table_that_repeats_lifts_in_each_turn(formulation):
    """Of one row a tenth of a turn, from a cosine: 40 (1 - cos s) mm to the error of a spline."""
    rows = ", ".join(f"[{36 * k} deg, {0.04 * (1 - np.cos(np.pi * k / 5)) if k % 10 else 0.0:.17g}]" for k in range(11))
    lift = f"  lift: {{type: coupler, of: {{pin: 0, rail: 1}}, function: {{rows: [{rows}], between: periodic}}}}\n"
    text = LIFT + lift + "motions:\n  turn: {joint: pin, angle: {constant_speed: 120 rpm}}\n"
    _, recorded = run(scene(text, formulation, duration=1.5))
    s, found = coordinates(recorded)
    np.testing.assert_allclose(found, 0.04 * (1.0 - np.cos(s)), rtol=0, atol=4e-5)
    turn = 10  # samples
    np.testing.assert_allclose(found[turn:], found[:-turn], rtol=0, atol=1e-13)


@pytest.mark.parametrize("wave", ["sin(s)", "sin(2*s)", "sin(s)**2", "sin(16*s)"])
def test_a_lift_that_is_nothing_at_half_a_turn_lifts_elsewhere(wave):
    """f(π) = f(-π) to round-off, which is no change with a turn; the row is closed before the run, and in it."""
    pin, turned = "location: [0, 0, 0], axis", "location: [0, 0, 0], angle: 50 deg, axis"
    text = LIFT.replace(pin, turned) + f"  lift: {{type: coupler, of: {{pin: 0, rail: 1}}, function: 0.04*{wave}}}\n"
    _, recorded = run(scene(text, duration=0.1))
    s, found = coordinates(recorded)
    assert abs(found[0]) > 0.01
    np.testing.assert_allclose(found, 0.04 * eval(wave, {"sin": np.sin, "s": s}), rtol=0, atol=1e-12)


def test_a_constant_says_where_it_begins():
    """The row closes before the run: Σ kᵢ sᵢ = constant."""
    _, recorded = run(
        scene(LIFT + "  mesh: {type: coupler, of: {pin: -5 cm, rail: 1}, constant: 2 mm}\n", duration=0.1)
    )
    angle, s = coordinates(recorded)
    np.testing.assert_allclose(s - 0.05 * angle, 0.002, rtol=0, atol=1e-15)


@pytest.mark.parametrize("constant", [2.0, 4.0, 5.0, -20.0])
def test_a_constant_of_any_size_is_closed_at_the_next_turn(constant):
    """φA + φB = c, but for whole turns, nearest to the pose of the scene."""
    row = f"  sum: {{type: coupler, of: {{A: 1, B: 1}}, constant: {constant}}}\n"
    _, recorded = run(scene(SHAFTS + row, duration=0.1))
    first, second, _ = coordinates(recorded)
    left = constant - 2.0 * np.pi * np.round(constant / (2.0 * np.pi))
    np.testing.assert_allclose(first + second, left, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ('{type: coupler, of: {A: 0, B: 1}, function: "abs(s)"}', "the function of 'J' has edges"),
        ('{type: coupler, of: {A: 0, B: 1}, function: "s**2"}', "the function of 'J' changes with a turn"),
        ("{type: coupler, of: {A: 1, B: pi}}", "'J' couples several angles whose turns have no common measure"),
    ],
)
def test_what_cannot_be_a_row_is_refused_at_its_line(row, words):
    with pytest.raises(Exception, match=rf"(?s):\d+:\d+: error: {words}"):
        run(scene(SHAFTS + f"  J: {row}\n"))
