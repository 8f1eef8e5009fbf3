"""Motions as rheonomic rows: their derivatives in time, what they ask of the start, and jumps, which are refused."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import Mechanism, Setting, assemble, compile_system, initial_guess, simulate, solve
from mbproj.base.errors import InputError, SimulationError
from mbproj.equations.constraints import constraint_at, constraint_velocity_at, gamma, jacobian, time_derivative
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.motions import drive_at
from mbproj.equations.rank.mobility import mobility, refuse_unsolvable
from mbproj.motion.formulations.choice import choose
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run
from tests.support import assembled

ARM = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 1, step: 0.01}
bodies:
  a: {mass: 1, inertia: [1, 2, 2.5], position: [0.1, 0.2, 0.3], orientation: {quaternion: [3, 1, -2, 0.5]}}
  b: {mass: 2, inertia: [1, 1.5, 1.2], position: [1, -0.5, 0.4]}
joints:
  C: {type: cylindrical, bodies: [ground, a], location: [0, 1, 0], axis: [0, 1, 1]}
  R: {type: revolute, bodies: [a, b], location: [0.4, 0, 0.1], axis: [1, 2, -1]}
motions:
"""
DRIVEN = """\
  turn: {joint: C, angle: {harmonic: {amplitude: 2, frequency: 3, phase: 0.3}}}
  slide: {joint: C, displacement: 0.3*t**3 - exp(-t)}
  swing: {joint: R, angle: {table: [[0, 0], [1, 2], [2, -1]]}}
"""


def start_of(motions, text=ARM):
    scene = read_scene_text(text + motions, "f.yaml")
    system = compile_system(scene)
    return system, initial_guess(scene, system)


@pytest.fixture(scope="module")
def driven():
    system, _ = start_of(DRIVEN)
    q, v = np.random.default_rng(7).normal(size=(2, 14))
    return system, q, v


def test_rows(driven):
    system, q, _ = driven
    assert (system.driven, system.constraints, constraint_at(system, q, 0.5).shape) == (3, 2 + 4 + 5 + 3, (14,))
    assert system.row_owner(11) == "motion 'turn'"
    assert jacobian(system, pose_of(q)).shape == (14, 14)


def test_velocity_of_C_is_its_derivative_along_a_motion(driven):
    """C' = C_q q' + C_t, by differences of C(q + v t, t)."""
    system, q, v = driven
    t, h = 0.6, 1e-4
    shifted = {k: constraint_at(system, q + k * h * v, t + k * h) for k in (-2, -1, 1, 2)}
    derivative = (8 * (shifted[1] - shifted[-1]) - (shifted[2] - shifted[-2])) / (12 * h)
    np.testing.assert_allclose(constraint_velocity_at(system, q, v, t), derivative, atol=1e-9)
    C_t = (constraint_at(system, q, t + h) - constraint_at(system, q, t - h)) / (2 * h)
    np.testing.assert_allclose(time_derivative(system, drive_at(system, t)), C_t, atol=1e-6)
    np.testing.assert_array_equal(time_derivative(system, drive_at(system, t))[:11], 0.0)


def test_gamma_is_minus_the_derivative_of_the_velocity_along_a_motion(driven):
    """γ = -(C_q q')_q q' - C_tt (and C_qt = 0), by differences at constant q'."""
    system, q, v = driven
    t, h = 0.6, 1e-4
    shifted = {k: constraint_velocity_at(system, q + k * h * v, v, t + k * h) for k in (-2, -1, 1, 2)}
    derivative = (8 * (shifted[1] - shifted[-1]) - (shifted[2] - shifted[-2])) / (12 * h)
    pose = pose_of(q)
    found = gamma(system, pose, twist_of(pose, v), drive_at(system, t))
    np.testing.assert_allclose(found, -derivative, rtol=1e-8, atol=1e-8)


def test_assembly_closes_at_the_motions_of_the_start():
    motions = "  turn: {joint: C, angle: 0.4 + 3*t}\n  swing: {joint: R, angle: {constant_speed: -2}}\n"
    system, guess = start_of(motions)
    state = assemble(system, guess)
    assert np.abs(constraint_at(system, state.q)).max() < 1e-13
    assert np.abs(constraint_velocity_at(system, state.q, state.v)).max() < 1e-12
    assert mobility(system, pose_of(state.q)).degrees_of_freedom == 1


def test_turns_of_the_start_are_counted():
    system, guess = start_of("  turn: {joint: C, angle: 13 + 3*t}\n")
    assert assemble(system, guess).turns.tolist() == [2, 0, 0]
    turned = ARM.replace("axis: [1, 2, -1]}", "axis: [1, 2, -1], angle: 7}")
    system, guess = start_of("  turn: {joint: R, angle: {constant_speed: 3}}\n", turned)
    state = assemble(system, guess)
    assert state.turns.tolist() == [0, 0, 1]
    assert drive_at(system, 0.5).value == pytest.approx([8.5])


SPEED = ARM.replace("axis: [1, 2, -1]}", "axis: [1, 2, -1], speed: 3, angle: 0.5}")
BEGINS = "f.yaml:11:24: error: motion 'm' begins with R.angle at"
CONTRADICTORY = {
    "{joint: R, angle: 0.4 + 3*t}": f"{BEGINS} 0.4 rad, and the joint's own condition asks for 0.5; "
    "take the joint's condition out",
    "{joint: R, angle: 0.5 + 4*t}": f"{BEGINS} 4 rad per s, and the joint's own condition asks for 3; "
    "take the joint's condition out",
}


@pytest.mark.parametrize("motion", CONTRADICTORY)
def test_conditions_that_contradict_a_motion(motion):
    system, guess = start_of(f"  m: {motion}\n", SPEED)
    with pytest.raises(InputError) as caught:
        assemble(system, guess)
    assert str(caught.value).splitlines()[0] == CONTRADICTORY[motion]


def test_conditions_that_agree_with_a_motion():
    system, guess = start_of("  m: {joint: R, angle: {constant_speed: 3}}\n", SPEED)
    assert np.abs(constraint_at(system, assemble(system, guess).q)).max() < 1e-13


FOUR_BAR = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 1, step: 0.01}
bodies:
  crank: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.5]}
  coupler: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 1.25]}
  rocker: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0.75]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: spherical, bodies: [crank, coupler], location: [0, 0, 1]}
  C: {type: universal, bodies: [coupler, rocker], location: [2, 0, 1.5], axes: [[0, 1, 0], [1, 0, 0]]}
  D: {type: revolute, bodies: [ground, rocker], location: [2, 0, 0], axis: [0, 1, 0]}
motions:
"""
LOCKED = {
    "  m: {joint: A, angle: t}\n  n: {joint: D, angle: 3*t}\n": "f.yaml:15:24: error: the mechanism cannot move as "
    "motion 'n' asks at the start; its joints, or other motions "
    "and speeds, hold it: drive no more than there are degrees of freedom",
    "  m: {joint: A, angle: 0.01*t}\n  n: {joint: D, angle: 1 + t}\n": "f.yaml:15:24: error: the mechanism cannot "
    "reach where motion 'n' begins; begin at the pose that 'bodies' "
    "gives, or take out other motions and conditions",
    "  m: {joint: A, angle: t**2}\n  n: {joint: D, angle: 3*t**2}\n": "f.yaml:15:24: error: motion 'n' locks the "
    "mechanism: the coordinate that it drives already follows from the joints and the "
    "motions before it; drive no more coordinates than there are degrees of freedom, and none at a dead centre",
}


@pytest.mark.parametrize("motions", LOCKED)
def test_motions_that_lock_the_mechanism(motions):
    system, guess = start_of(motions, FOUR_BAR)
    with pytest.raises(InputError) as caught:
        refuse_unsolvable(system, mobility(system, pose_of(assemble(system, guess).q)))
    assert str(caught.value).splitlines()[0] == LOCKED[motions]


def test_a_mechanism_that_does_not_close_is_not_blamed_on_a_motion():
    apart = FOUR_BAR.replace(
        "location: [2, 0, 1.5], axes: [[0, 1, 0], [1, 0, 0]]",
        "location: {coupler: [9, 0, 0], rocker: [0, 0, 0]}, axes: {coupler: [0, 1, 0], rocker: [1, 0, 0]}",
    )
    system, guess = start_of("  m: {joint: A, angle: t}\n", apart)
    with pytest.raises(InputError, match="the mechanism does not close: joint"):
        assemble(system, guess)


def test_an_expression_that_fails_at_the_start():
    system, guess = start_of("  m: {joint: R, angle: log(t)}\n")
    with pytest.raises(SimulationError) as caught:
        assemble(system, guess)
    assert str(caught.value) == (
        "stopped at t = 0 s at motion 'm': 'log(t)' fails: log(0) is not finite; correct the expression, or end "
        "the run before that time"
    )


def test_an_angle_is_driven_over_many_turns():
    """C of a driven angle does not see whole turns."""
    system, guess = start_of("  m: {joint: R, angle: {constant_speed: 2000}}\n")
    q = assemble(system, guess).q
    for turns in (1, 10, 1000):
        assert np.abs(constraint_at(system, q, np.pi * turns / 1000.0)).max() < 1e-12


# Motions that jump are refused with their place, the time and the size; those whose acceleration alone jumps run.

WHEEL = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: {duration}, step: 0.01, formulation: {formulation}}}
bodies:
  wheel: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
joints:
  A: {{type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 0, 1]}}
motions:
  drive: {{joint: A, angle: {angle}}}
"""
FORMULATIONS = ("full", "reduced", "planar")


def started(angle, formulation="full", duration=1.0):
    scene = read_scene_text(WHEEL.format(angle=angle, formulation=formulation, duration=duration), "wheel.yaml")
    return *assembled(scene), settings_to_run(scene)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize(
    ("angle", "said"),
    [
        ("floor(2*t)", "motion 'drive' jumps by 1 rad at t = 0.5 s"),
        ("abs(t - 0.5)", "motion 'drive' changes its velocity by 2 rad/s at once at t = 0.5 s"),
        ('"max(0, t - 0.3)"', "motion 'drive' changes its velocity by 1 rad/s at once at t = 0.3 s"),
        ("abs(t)", "motion 'drive' changes its velocity by 1 rad/s at once at t = 0 s"),
        ("sqrt((t - 0.25)**2)", "motion 'drive' changes its velocity by 2 rad/s at once at t = 0.25 s"),
    ],
)
def test_a_jump_is_refused_with_its_place(formulation, angle, said):
    with pytest.raises(InputError) as refused:
        simulate(*started(angle, formulation))
    assert str(refused.value).startswith(f"wheel.yaml:9:28: error: {said}; a motion needs a continuous velocity")


@pytest.mark.parametrize("formulation", FORMULATIONS[1:])
def test_a_jump_of_the_acceleration_alone_runs_right(formulation):
    """A table that is clamped at its ends stands still before and after: it has turned by 1 rad."""
    system, state, settings = started("{table: {rows: [[0.2, 0], [0.8, 1]], between: clamped}}", formulation)
    report = simulate(system, state, settings)
    assert report.position_violation.value < 1e-13
    corner = WHEEL.format(angle='"max(0, t - 0.5)**2"', formulation="auto", duration=1)
    mechanism = Mechanism.of(read_scene_text(corner))
    solution = solve(mechanism, Setting("gpopm", "rk4", step=0.01), [0.0, 0.5, 1.0])
    assert solution.failure is None


def test_what_comes_after_the_end_of_the_run_does_not_matter():
    assert simulate(*started("abs(t - 2)", "reduced")).position_violation.value < 1e-13
    with pytest.raises(InputError, match="at t = 2 s"):
        simulate(*started("abs(t - 2)", duration=3.0))


def test_a_check_refuses_as_a_run_does():
    system, state, settings = started("floor(t + 0.5)")
    with pytest.raises(InputError, match=r"jumps by 1 rad at t = 0\.5 s"):
        choose(system, state, settings)
