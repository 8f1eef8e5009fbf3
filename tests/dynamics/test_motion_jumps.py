"""Motions that jump are refused with their place, the time and the size; those whose acceleration alone jumps run."""

from __future__ import annotations

import pytest

from mbproj import Mechanism, Setting, assemble, compile_system, initial_guess, simulate, solve
from mbproj.base.errors import InputError
from mbproj.motion.formulations.choice import choose
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run

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
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system)), settings_to_run(scene)


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
