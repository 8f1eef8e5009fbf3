"""Dry friction where motions drive everything: a force that follows the rate of its joint, and decides no motion."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crossed import crossed, full
from tests.integrate.kinematic.scenes import FORMULATIONS, FOUR_BAR, run

TORQUE = 2.0
SWING = "expression: '0.3*sin(5*t)'"


def smooth_step(start: float, end: float) -> str:
    """From 0 to 1, at rest before and after."""
    x = f"max(0, min(1, (t - {start})/({end} - {start})))"
    return f"({x})**3*(10 - 15*{x} + 6*({x})**2)"


#: There, at rest from 0.3 s to 0.45 s, and back.
THERE_AND_BACK = f"expression: '{smooth_step(0.1, 0.3)} - {smooth_step(0.45, 0.6)}'"
PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1.3 s, output_step: 10 ms, kinematic: true}
bodies:
  arm: {mass: 2, inertia: [0.05, 0.05, 0.05], position: [0, 0, -0.4]}
joints:
  pin: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, -1, 0]}
motions:
  drive: {joint: pin, angle: {expression: '0.8*sin(3*t)'}}
forces:
  rub: {type: friction, joint: pin, coulomb: {coefficient: 0.2, radius: 30 mm}}
"""


def four_bar(law: str, joint: str = "") -> str:
    """The four bars with this law of their crank, and dry friction at a joint."""
    rub = f"forces: {{rub: {{type: friction, joint: {joint}, coulomb: {{torque: {TORQUE}}}}}}}\n" if joint else ""
    return FOUR_BAR.replace("constant_speed: 60 rpm", law) + rub


@pytest.mark.full_where(formulation="full")
@crossed(
    "joint, column, formulation", [pytest.param("A", 0), pytest.param("D", 3)], ["full", *FORMULATIONS], dear=["full"]
)
def test_a_swing_takes_what_friction_loses_in_either_direction(joint, column, formulation):
    """Through two reversals, or one in full, the drive adds M |s'| / θ', s' the rate of the joint that rubs and θ' that
    of the drive."""
    until = "0.6 s" if formulation == "full" else "1.2 s"  # in NumPy: seconds
    options = {"formulation": formulation, "duration": until, "output_step": "25 ms"}
    report, found, _ = run(four_bar(SWING, joint), **options)
    _, without, _ = run(four_bar(SWING), **options | {"formulation": "reduced"})
    assert report.kinematic
    t, rate = found["time"], found["joints/speed"][:, column]
    drive = 1.5 * np.cos(5.0 * t)
    np.testing.assert_allclose(found["friction/force"][:, 0], -TORQUE * np.sign(rate), rtol=1e-14)
    more = found["motions/force"][:, 0] - without["motions/force"][:, 0]
    np.testing.assert_allclose(more, TORQUE * np.abs(rate) / drive, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(found["joints/coordinate"], without["joints/coordinate"], rtol=0.0, atol=1e-12)
    assert report.energy_drift_relative < 1e-9


@pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS])
def test_the_work_of_a_swing_is_its_torque_times_the_way(formulation):
    report, found, _ = run(four_bar(SWING, "A"), formulation=formulation, duration="1.2 s", output_step="0.1 s")
    t = found["time"]
    quarter = np.floor(5.0 * t / np.pi + 0.5)  # half turns of the sine that are over
    way = 0.3 * (2.0 * quarter + np.cos(np.pi * quarter) * np.sin(5.0 * t))
    np.testing.assert_allclose(found["diagnostics/dissipation"], TORQUE * way, rtol=0.0, atol=1e-10)
    assert report.energy_drift_relative < 1e-9


@pytest.mark.parametrize(
    ("formulation", "joint", "column"),
    [full("full", "A", 0), *((each, "D", 3) for each in FORMULATIONS)],  # the full one takes 0.1 s an event
)
def test_at_rest_friction_bears_nothing_and_the_motion_all(formulation, joint, column):
    options = {"formulation": formulation, "duration": "0.7 s", "output_step": "10 ms"}
    report, found, _ = run(four_bar(THERE_AND_BACK, joint), **options)
    _, without, _ = run(four_bar(THERE_AND_BACK), **options | {"formulation": "reduced"})
    assert report.kinematic
    t, force = found["time"], found["friction/force"][:, 0]
    rests = (t < 0.1) | ((t > 0.305) & (t < 0.45)) | (t > 0.605)
    moves = ((t > 0.1) & (t < 0.3)) | ((t > 0.45) & (t < 0.6))
    rate = found["joints/speed"][:, column]
    np.testing.assert_array_equal(force[rests], 0.0)
    np.testing.assert_array_equal(found["friction/state"][rests, 0], 0)
    np.testing.assert_allclose(rate[rests], 0.0, atol=1e-20)
    np.testing.assert_allclose(force[moves], -TORQUE * np.sign(rate[moves]), rtol=1e-14)
    np.testing.assert_allclose(
        found["motions/force"][rests, 0], without["motions/force"][rests, 0], rtol=0.0, atol=1e-12
    )
    way = np.abs(np.diff(found["joints/coordinate"][:, column])).sum()
    assert found["diagnostics/dissipation"][-1] == pytest.approx(TORQUE * way, rel=2e-3 if joint == "D" else 1e-9)
    assert report.energy_drift_relative < 1e-8


@pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS])
def test_friction_that_goes_by_the_load_of_its_bearing_turns_with_the_rate(formulation):
    """m g a sin θ + J θ'' + μ r |F| sign θ', with F what holds the arm's mass on its circle."""
    report, found, _ = run(PENDULUM, formulation=formulation)
    t = found["time"]
    angle, rate, bend = 0.8 * np.sin(3.0 * t), 2.4 * np.cos(3.0 * t), -7.2 * np.sin(3.0 * t)
    m, a, J, g = 2.0, 0.4, 0.05, 9.81
    along, across = m * (a * rate**2 + g * np.cos(angle)), m * (a * bend + g * np.sin(angle))
    expected = (J + m * a**2) * bend + m * g * a * np.sin(angle)
    expected += 0.2 * 0.03 * np.hypot(along, across) * np.sign(rate)
    np.testing.assert_allclose(found["motions/force"][:, 0], expected, rtol=0.0, atol=1e-12)
    assert report.kinematic and report.energy_drift_relative < 1e-9


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_what_rests_under_load_does_no_work(formulation):
    """A spring holds its force through a rest in which the arm's velocity is no more than round-off."""
    text = PENDULUM.replace("0.8*sin(3*t)", f"0.5*{smooth_step(0.8, 1.2)}").replace("-9.81]", "0]")
    text = (
        text[: text.index("forces:")]
        + "forces: {k: {type: torsion_spring_damper, joint: pin, stiffness: 40, free_angle: 1}}\n"
    )
    report, found, _ = run(text, formulation=formulation)
    rests = found["time"] < 0.8
    np.testing.assert_allclose(found["bodies/velocity"][rests], 0.0, atol=1e-20)
    np.testing.assert_allclose(found["diagnostics/work"][rests], 0.0, atol=1e-20)
    np.testing.assert_allclose(found["motions/force"][rests, 0], -40.0, rtol=1e-13)
    assert report.energy_drift_relative < 1e-9
