"""Gears and screws that turn far within a step keep their teeth and threads, or the run says which step would do."""

from __future__ import annotations

import re

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.base.errors import SimulationError
from tests.crossed import once, where
from tests.kernel.scenes import needs_kernel
from tests.support import Recorder

BEVEL, PARALLEL = "[1, 0, 0]", "[0, 0, 1]"
EVERYWHERE = ["full", pytest.param("reduced", marks=needs_kernel)]
SLOW_IN_FULL = where(lambda formulation: formulation != "full", EVERYWHERE)


def pair(pinion_axis: str = BEVEL, driven: str = "", speed: str = "") -> str:
    """A wheel of 60 teeth and a pinion of 20."""
    return f"""
mbproj: 1
gravity: [0, 0, 0]
bodies:
  wheel: {{mass: 1, inertia: [0.01, 0.01, 0.02], position: [0, 0, 0]}}
  pinion: {{mass: 0.5, inertia: [0.001, 0.001, 0.001], position: [0.1, 0, 0]}}
joints:
  A: {{type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 0, 1]{speed}}}
  B: {{type: revolute, bodies: [ground, pinion], location: [0.1, 0, 0], axis: {pinion_axis}}}
  G: {{type: gear, joints: [A, B], teeth: [60, 20]}}
{driven}
simulation: {{duration: 0.5, step: 10 ms, integrator: rk4}}
"""


def motion(function: str) -> str:
    return f"motions:\n  m: {{joint: A, angle: {function}}}"


SCREW = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {nut: {mass: 1, inertia: [0.01, 0.01, 0.02], position: [0, 0, 0]}}
joints: {S: {type: screw, bodies: [ground, nut], location: [0, 0, 0], axis: [0, 0, 1], pitch: 1 mm}}
motions: {m: {joint: S, angle: {constant_speed: 3000 rpm}}}
simulation: {duration: 0.5, step: 10 ms, integrator: rk4}
"""


def run(text: str, formulation: str, **simulation):
    scene = read_scene_text(text, simulation={"formulation": formulation, **simulation})
    system = compile_system(scene)
    recorder, state = Recorder(), assemble(system, initial_guess(scene, system))
    simulate(system, state, settings_to_run(scene), recorder)
    return recorder


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
@pytest.mark.parametrize(("axis", "speed"), once([BEVEL, PARALLEL], [1000.0, 2000.0]))
def test_a_driven_pair_keeps_its_teeth(axis, speed, formulation):
    """60 φ1 + 20 φ2 = 0 with φ1 = ω t, though the pinion makes a turn in a step."""
    found = run(pair(axis, motion(f"{{constant_speed: {speed} rpm}}")), formulation, kinematic=formulation != "full")
    first, second = found["joints/coordinate"].T
    np.testing.assert_allclose(first, speed * np.pi / 30.0 * found["time"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(second, -3.0 * first, rtol=0, atol=1e-9)


@needs_kernel
@pytest.mark.parametrize("speed", [500.0, 5000.0])
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_the_kernel_keeps_the_teeth_of_any_driven_pair(formulation, speed):
    found = run(pair(PARALLEL, motion(f"{{constant_speed: {speed} rad/s}}")), formulation)
    first, second = found["joints/coordinate"].T
    np.testing.assert_allclose(first, speed * found["time"], rtol=0, atol=1e-8)
    np.testing.assert_allclose(second, -3.0 * first, rtol=0, atol=1e-8)


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
def test_a_driven_screw_keeps_its_thread(formulation):
    found = run(SCREW, formulation, kinematic=formulation != "full")
    angle, shift = found["joints/coordinate"].T
    np.testing.assert_allclose(angle, 100.0 * np.pi * found["time"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(shift, 0.001 * angle / (2.0 * np.pi), rtol=0, atol=1e-12)


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
@pytest.mark.parametrize("speed", [2000, 5000])
def test_a_step_that_cannot_tell_the_teeth_of_free_wheels_says_which_would_do(speed, formulation):
    """RK4 does not follow 1 turn a step; with the step that the message names it does, all 0.5 s long."""
    text = pair(speed=f", speed: {speed} rpm")
    with pytest.raises(SimulationError) as caught:
        run(text, formulation)
    reason = "at B.angle: the step is too long to tell its turns, and so which teeth or threads are in mesh"
    assert reason in str(caught.value)
    found = re.search(r"use steps of at most (\S+) s", str(caught.value))
    assert found is not None
    again = run(text, formulation, step=float(found[1]))
    first, second = again["joints/coordinate"].T
    np.testing.assert_allclose(second, -3.0 * first, rtol=0, atol=1e-9)


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
@pytest.mark.parametrize("tolerance", [0.1, 1e-6])
def test_error_control_shortens_such_steps(tolerance, formulation):
    """The samples lie inside the steps."""
    steps = f"tolerance: {tolerance}, integrator: dopri5"
    text = pair(speed=", speed: 2000 rpm").replace("step: 10 ms, integrator: rk4", steps)
    found = run(text, formulation, duration=0.1, output_step=0.001)
    first, second = found["joints/coordinate"].T
    np.testing.assert_allclose(second, -3.0 * first, rtol=0, atol=1e-9)
    if tolerance < 0.01:
        np.testing.assert_allclose(first, 200.0 / 3.0 * np.pi * found["time"], rtol=0, atol=1e-4)


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
def test_a_driven_angle_counts_the_turns_of_its_motion(formulation):
    """16 turns in 2 ms, between two points of the time axis at which nothing moves."""
    wheel = pair().replace("joints: [A, B]", "joints: [A, A]")
    text = wheel.replace("  G: {type: gear, joints: [A, A], teeth: [60, 20]}\n", "").replace(
        "simulation:", motion("{smooth_step: {to: 100.5, start: 0.103, duration: 0.002}}") + "\nsimulation:"
    )
    found = run(text, formulation)
    late = found["time"] > 0.105
    np.testing.assert_allclose(found["joints/coordinate"][late, 0], 100.5, rtol=0, atol=1e-9)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", [*EVERYWHERE, pytest.param("planar", marks=needs_kernel)])
def test_stages_tell_the_turns_where_the_rates_at_the_ends_do_not(formulation):
    """A wheel on a spring swings by 1.5 rad to each side: φ = 1.5 cos(ω t), with h ω = 2 by DOP853. In the first step
    it turns by -2.1 rad, and the trapezoidal rule has -1.4."""
    text = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {wheel: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 0, 1], angle: 1.5}}
forces: {s: {type: torsion_spring_damper, joint: A, stiffness: 1}}
simulation: {duration: 20, step: 2, integrator: dop853}
"""
    found = run(text, formulation)
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], 1.5 * np.cos(found["time"]), rtol=0, atol=0.1)
