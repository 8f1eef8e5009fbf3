"""Samples inside a step: recorded on the constraints, or the run says why not."""

from __future__ import annotations

import sys
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis.strategies import floats

from mbproj import (
    assemble,
    compile_system,
    initial_guess,
    read_scene,
    read_scene_text,
    settings_to_run,
    simulate,
)
from mbproj.base.settings import Settings
from mbproj.scene.sampling import output_times
from tests.kernel.scenes import needs_kernel
from tests.support import ROOT, Recorder

QUICK_RETURN = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2, integrator: dop853, tolerance: 0.021, output_step: 0.001, kinematic: false}
bodies:
  crank: {mass: 1, shape: {rod: {length: 0.1, axis: x}}, position: [0.05, 0, 0.2]}
  rocker:
    mass: 2
    shape: {rod: {length: 0.5, axis: x}}
    position: [0.1118, 0, 0.2236]
    orientation: {axis: [0, -1, 0], angle: 63.43 deg}
  link: {mass: 0.5, shape: {rod: {length: 0.2, axis: x}}, position: [0.32, 0, 0.4736]}
  ram: {mass: 3, inertia: [0.01, 0.01, 0.01], position: [0.4165, 0, 0.5]}
joints:
  O: {type: revolute, bodies: [ground, rocker], location: [0, 0, 0], axis: [0, 1, 0]}
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0.2], axis: [0, 1, 0]}
  B: {type: point_on_line, bodies: [rocker, crank], location: [0.1, 0, 0.2], axis: [1, 0, 2]}
  C: {type: revolute, bodies: [rocker, link], location: [0.2236, 0, 0.4472], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [link, ram], location: [0.4165, 0, 0.5], axis: [0, 1, 0]}
  guide: {type: prismatic, bodies: [ground, ram], location: [0.4165, 0, 0.5], axis: [1, 0, 0]}
motions:
  drive: {joint: A, angle: {constant_speed: 60 rpm}}
"""


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
@pytest.mark.parametrize("tolerance", [0.01, 0.021, 0.03, 0.1])
def test_no_sample_is_recorded_with_an_open_joint(tolerance, formulation):
    """Some ten steps pass the fast return of the ram twice: what is interpolated leaves the joints far open."""
    scene = read_scene_text(QUICK_RETURN, "f", {}, {"tolerance": tolerance, "formulation": formulation})
    system, recorder = compile_system(scene), Recorder()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    assert report.counters["steps"] < 15
    assert len(recorder["time"]) == 2001
    assert recorder["diagnostics/position_violation"].max() <= 1e-13


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_samples_inside_steps_are_as_closed_as_their_ends(formulation):
    """Several in each step of a pendulum of five bars, whose interpolation alone leaves the joints open by 1e-7 m."""
    options = {"tolerance": 1e-6, "integrator": "dopri5", "output_step": 0.005, "formulation": formulation}
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml", {}, {**options, "duration": 1.0})
    system, recorder = compile_system(scene), Recorder()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    assert report.counters["steps"] < 100
    assert recorder["diagnostics/position_violation"].max() <= 1e-13
    assert recorder["diagnostics/velocity_violation"].max() <= 1e-12


@given(start=floats(-10.0, 10.0), interval=floats(1e-3, 0.3), duration=floats(1.0, 9.0))
def test_samples_are_at_multiples_of_the_output_step_and_at_the_end(start, interval, duration) -> None:
    """To the last bit."""
    listed = list(output_times(Settings(duration=duration, tolerance=1e-6, output_step=interval), start))
    assert listed[0] == start
    assert listed[-1] == start + duration
    assert all(time == start + k * interval for k, time in enumerate(listed[:-1]))
    assert all(before < after for before, after in pairwise(listed))


def test_times_of_a_million_samples_take_no_memory() -> None:
    times = output_times(Settings(duration=1e3, tolerance=1e-6, output_step=1e-3), 0.0)
    assert len(times) == 10**6 + 1
    assert (times[-1], times[-2], times[10:12]) == (1e3, 999999 * 1e-3, [10 * 1e-3, 11 * 1e-3])
    assert sys.getsizeof(times) + sum(map(sys.getsizeof, vars(times).values())) < 1000


TURNS = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1.5, integrator: rk4, step: 0.01, output_step: OUTPUT, kinematic: false}
bodies: {b: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0.3, 0.1]}}
joints: {A: {type: revolute, bodies: [ground, b], location: [0, 0, 0], axis: AXIS}}
motions: {drive: {joint: A, angle: "2*pi*t"}}
"""


@needs_kernel
@pytest.mark.parametrize("output_step", ["0.05", "0.0625"])
def test_at_half_a_turn_an_angle_has_the_turns_of_the_pose_that_is_recorded(output_step):
    """There round-off tells on which side of ±π the kernel has it, and on which side the pose that is recorded."""
    rng = np.random.default_rng(0)
    for axis in rng.normal(size=(20, 3)).tolist():
        text = TURNS.replace("AXIS", str(axis)).replace("OUTPUT", output_step)
        scene = read_scene_text(text, "f", {}, {"formulation": "reduced", "step": float(output_step) / 5.0})
        system, recorder = compile_system(scene), Recorder()
        simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
        np.testing.assert_allclose(recorder["joints/coordinate"][:, 0], 2.0 * np.pi * recorder["time"], atol=1e-12)
