"""The torque of a cam: that of virtual work, F ds/dθ, with the law of the cam as a function and as a table."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.crossed import once
from tests.mechanisms.driven.linkages import block, run

LIFT, MASS, STIFFNESS, PRELOAD, GRAVITY, SPEED = 0.02, 0.8, 4000.0, 60.0, 9.81, 4.0 * np.pi
ROWS = np.array([0.0, 40.0, 80.0, 130.0, 180.0, 235.0, 300.0, 360.0])
HEIGHTS = np.array([0.0, 3.0, 14.0, 20.0, 17.0, 8.0, 1.5, 0.0])


def scene(law: str) -> str:
    bodies = {
        "cam": "{mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}",
        "follower": f"{{mass: {MASS}, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0.1]}}",
    }
    joints = {
        "shaft": "{type: revolute, bodies: [ground, cam], location: [0, 0, 0], axis: [0, 1, 0]}",
        "guide": "{type: prismatic, bodies: [ground, follower], location: [0, 0, 0.1], axis: [0, 0, 1]}",
        "lift": f"{{type: coupler, of: {{shaft: 0, guide: 1}}, function: {law}}}",
    }
    forces = {
        "spring": f"{{type: linear_spring_damper, joint: guide, stiffness: {STIFFNESS}, "
        f"free_displacement: {-PRELOAD / STIFFNESS!r}}}"
    }
    head = (
        f"mbproj: 1\ngravity: [0, 0, {-GRAVITY}]\nsimulation: {{duration: 1 s, output_step: 1 ms, kinematic: true}}\n"
    )
    motion = f"motions: {{drive: {{joint: shaft, angle: {{constant_speed: {SPEED!r}}}}}}}\n"
    return head + block("bodies", bodies) + block("joints", joints) + block("forces", forces) + motion


def of_expression(angle):
    """s, ds/dθ, d²s/dθ² of a follower that rises and falls twice a turn."""
    return (
        0.5 * LIFT * (1.0 - np.cos(2.0 * angle)) ** 2,
        2.0 * LIFT * (1.0 - np.cos(2.0 * angle)) * np.sin(2.0 * angle),
        4.0 * LIFT * (np.sin(2.0 * angle) ** 2 + (1.0 - np.cos(2.0 * angle)) * np.cos(2.0 * angle)),
    )


def of_table(angle):
    spline = CubicSpline(np.radians(ROWS), HEIGHTS / 1000.0, bc_type="periodic")
    return tuple(spline(np.remainder(angle, 2.0 * np.pi), order) for order in range(3))


TABLE = ", ".join(f"[{angle} deg, {height} mm]" for angle, height in zip(ROWS, HEIGHTS, strict=True))
LAWS = {
    "expression": (f"'{0.5 * LIFT} * (1 - cos(2*s))**2'", of_expression),
    "table": (f"{{rows: [{TABLE}], between: periodic}}", of_table),
}


@pytest.mark.parametrize(("law", "formulation"), once([*LAWS], ["planar", "reduced"]))
def test_the_torque_of_a_cam_is_its_force_times_the_slope_of_its_law(law, formulation):
    pytest.importorskip("mbproj.kernel._core")
    text, exact = LAWS[law]
    _, recorder, report = run(scene(text), formulation=formulation)
    angle = SPEED * recorder["time"]
    s, slope, bend = exact(angle)
    np.testing.assert_allclose(recorder["joints/coordinate"][:, 1], s, rtol=0.0, atol=1e-12)
    force = MASS * (SPEED**2 * bend + GRAVITY) + STIFFNESS * s + PRELOAD
    expected = force * slope
    np.testing.assert_allclose(recorder["motions/force"][:, 0], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    # The cam lifts the follower by that force, and takes it from the follower's guide.
    np.testing.assert_allclose(
        recorder["joints/reaction_force"][:, 2, 2], force, rtol=0.0, atol=1e-9 * np.abs(force).max()
    )
    assert report.energy_drift_relative < 1e-8
