"""Gears and screws at speed, and what bearings carry of the forces between teeth."""

from __future__ import annotations

import re

import numpy as np
import pytest

from mbproj import InputError
from mbproj.base.errors import SimulationError
from tests.crossed import once, where
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import run_text
from tests.stops.runs import DOP853, run

# Gears and screws that turn far within a step keep their teeth and threads, or the run says which step would do.

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


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
@pytest.mark.parametrize(("axis", "speed"), once([BEVEL, PARALLEL], [1000.0, 2000.0]))
def test_a_driven_pair_keeps_its_teeth(axis, speed, formulation):
    """60 φ1 + 20 φ2 = 0 with φ1 = ω t, though the pinion makes a turn in a step."""
    found = run_text(
        pair(axis, motion(f"{{constant_speed: {speed} rpm}}")),
        formulation=formulation,
        kinematic="false" if formulation == "full" else "true",
    )
    first, second = found["joints/coordinate"].T
    np.testing.assert_allclose(first, speed * np.pi / 30.0 * found["time"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(second, -3.0 * first, rtol=0, atol=1e-9)


@needs_kernel
@pytest.mark.parametrize("speed", [500.0, 5000.0])
@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_the_kernel_keeps_the_teeth_of_any_driven_pair(formulation, speed):
    found = run_text(pair(PARALLEL, motion(f"{{constant_speed: {speed} rad/s}}")), formulation=formulation)
    first, second = found["joints/coordinate"].T
    np.testing.assert_allclose(first, speed * found["time"], rtol=0, atol=1e-8)
    np.testing.assert_allclose(second, -3.0 * first, rtol=0, atol=1e-8)


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
def test_a_driven_screw_keeps_its_thread(formulation):
    found = run_text(SCREW, formulation=formulation, kinematic="false" if formulation == "full" else "true")
    angle, shift = found["joints/coordinate"].T
    np.testing.assert_allclose(angle, 100.0 * np.pi * found["time"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(shift, 0.001 * angle / (2.0 * np.pi), rtol=0, atol=1e-12)


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
@pytest.mark.parametrize("speed", [2000, 5000])
def test_a_step_that_cannot_tell_the_teeth_of_free_wheels_says_which_would_do(speed, formulation):
    """RK4 does not follow 1 turn a step; with the step that the message names it does, all 0.5 s long."""
    text = pair(speed=f", speed: {speed} rpm")
    with pytest.raises(SimulationError) as caught:
        run_text(text, formulation=formulation)
    reason = "at B.angle: the step is too long to tell its turns, and so which teeth or threads are in mesh"
    assert reason in str(caught.value)
    found = re.search(r"use steps of at most (\S+) s", str(caught.value))
    assert found is not None
    again = run_text(text, formulation=formulation, step=float(found[1]))
    first, second = again["joints/coordinate"].T
    np.testing.assert_allclose(second, -3.0 * first, rtol=0, atol=1e-9)


@pytest.mark.parametrize("formulation", SLOW_IN_FULL)
@pytest.mark.parametrize("tolerance", [0.1, 1e-6])
def test_error_control_shortens_such_steps(tolerance, formulation):
    """The samples lie inside the steps."""
    steps = f"tolerance: {tolerance}, integrator: dopri5"
    text = pair(speed=", speed: 2000 rpm").replace("step: 10 ms, integrator: rk4", steps)
    found = run_text(text, formulation=formulation, duration=0.1, output_step=0.001)
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
    found = run_text(text, formulation=formulation)
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
    found = run_text(text, formulation=formulation)
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], 1.5 * np.cos(found["time"]), rtol=0, atol=0.1)


# What bearings carry of the forces between teeth: spur wheels outside and inside, against statics; what is refused.

#: Wheels of 20 and 30 teeth at a distance of 0.1 m: pitch radii 40 and 60 mm. The first turns steadily.
WHEELS = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {SETTINGS, duration: 0.2}
bodies:
  one: {mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0, 0, 0]}
  two: {mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [FAR, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, one], location: [0, 0, 0], axis: [0, 0, 1]}
  B: {type: revolute, bodies: [ground, two], location: [FAR, 0, 0], axis: [0, 0, 1]}
  G: {type: gear, joints: [A, B], teeth: [20, SECOND], pressure_angle: 20 deg}
motions: {drive: {joint: A, angle: {constant_speed: 2 rad/s}}}
forces: {load: {type: torsion_spring_damper, joint: B, torque: LOAD}}
""".replace("SETTINGS", DOP853)


@needs_kernel
@pytest.mark.parametrize(
    "gear", ["{type: gear, joints: [A, B], teeth: [20, SECOND]", "{type: coupler, of: {A: 2, B: SECOND/10}"]
)
@pytest.mark.parametrize("load", [6.0, -6.0])
@pytest.mark.parametrize(("second", "far", "radius"), [(30, 0.1, 0.06), (-30, 0.02, 0.06)])
def test_bearings_carry_the_teeth(second, far, radius, load, gear):
    """F_t = τ/r across the line of centres; F_t tan 20 deg pushes wheels apart, and the wheel inside a ring inwards."""
    text = WHEELS.replace("{type: gear, joints: [A, B], teeth: [20, SECOND]", gear)
    text = text.replace("FAR", f"{far}").replace("SECOND", f"{second}").replace("LOAD", f"{load}")
    _, found = run(text)
    pitch = 0.04 if second > 0 else -0.04
    tangent = -load / (pitch - far)  # the teeth turn the second wheel against its load
    aside = abs(tangent) * np.tan(np.radians(20.0)) * (1.0 if second > 0 else -1.0)
    on_second = np.array([aside, tangent, 0.0])
    assert abs(abs(tangent) - abs(load) / radius) < 1e-9
    force = found["joints/reaction_force"]
    np.testing.assert_allclose(force[:, 2], np.tile(on_second, (len(force), 1)), atol=1e-9)
    np.testing.assert_allclose(force[:, 1], -force[:, 2], atol=1e-9)
    np.testing.assert_allclose(force[:, 0], force[:, 2], atol=1e-9)
    # the wheels are in balance: no torque is left for the bearings
    np.testing.assert_allclose(found["joints/reaction_torque"][:, :2], 0.0, atol=1e-9)


@needs_kernel
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("location: [FAR, 0, 0], axis: [0, 0, 1]", "location: [FAR, 0, 0], axis: [0, 1, 0]", "are not parallel"),
        ("pressure_angle: 20 deg", "pressure_angle: 70 deg", "is no pressure angle"),
        ("gear, joints: [A, B], teeth: [20, SECOND]", "coupler, of: {A: 20}", "is not a sum of two angles"),
        (
            "gear, joints: [A, B], teeth: [20, SECOND]",
            "coupler, of: {A: 20, B: 30}, function: 0.1*sin(s)",
            "is not a sum of two angles",
        ),
        ("bodies: [ground, two]", "bodies: [two, ground]", "the ground is the second body of joint 'B'"),
        (
            "forces: {",
            "forces: {rubs: {type: friction, joint: A, coulomb: {coefficient: 0.1, radius: 5 mm}}, ",
            "friction 'rubs' depends on the load of joint 'A' without forces of teeth",
        ),
    ],
)
def test_what_is_refused(old, new, message):
    text = WHEELS.replace(old, new).replace("FAR", "0.1").replace("SECOND", "30").replace("LOAD", "6")
    with pytest.raises(InputError) as caught:
        run(text)
    assert message in str(caught.value)
    assert "pressure_angle" in str(caught.value)
