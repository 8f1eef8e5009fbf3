"""Nothing goes through a stop within a step, and what bounces among several bodies comes to rest on them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crossed import crossed, full
from tests.stops.runs import DOP853, run
from tests.stops.scenes import THREE_BALLS

#: A ball that is thrown up above a point from which it keeps a distance, and falls back.
THROWN = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  ball: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.15], velocity: [0, 0, 2]}}
forces:
  {stop}
"""
SPHERE = (
    "keep: {type: stop, points: {ground: [0, 0, 0], ball: [0, 0, 0.15]}, shortest: 0.1, rigid: true, restitution: 1}"
)
#: A step of RK4, in which free fall is exact, may be as long as it likes.
STEPS = [DOP853, "integrator: dop853, tolerance: 1.0e-6, output_step: 5", "integrator: rk4, step: 0.5, output_step: 5"]


@pytest.mark.full_where(formulation="full")
@crossed("steps, formulation", STEPS, ["reduced", "full"], dear=["full"])
def test_what_rises_and_falls_through_within_a_step_is_stopped(steps, formulation):
    """It passes the whole sphere within the step, so that the gap is open at both ends of it."""
    _, recorded = run(THROWN.format(duration=5, steps=steps, formulation=formulation, stop=SPHERE))
    first = (2.0 + np.sqrt(5.0)) / 10.0
    met = [event.time for event in recorded.happened if event.kind == "impact"]
    assert met[0] == pytest.approx(first, abs=1e-12)
    assert np.diff(met) == pytest.approx(2.0 * np.sqrt(5.0) / 10.0, rel=1e-10)
    assert recorded["stops/gap"].min() > -1e-11


@pytest.mark.parametrize(("formulation", "e"), [("reduced", 0.5), ("reduced", 0.8), full("full", 0.5)])
def test_balls_that_bounce_on_each_other_come_to_rest_on_each_other(formulation, e):
    """A ball falls towards another one that the floor holds, though both fall alike without it. With e = 0.8 two of
    them meet within a step that the third has begun with a bounce."""
    _, recorded = run(THREE_BALLS.replace("0.5}}", f"{e}}}}}").format(steps=DOP853, formulation=formulation))
    rests = {event.name for event in recorded.happened if event.kind == "rest"}
    assert {"stop 'first'", "stop 'second'"} <= rests
    np.testing.assert_allclose(recorded["bodies/position"][-1, :, 2], [0.0, 0.1, 0.2], atol=1e-9)
    np.testing.assert_allclose(recorded["stops/force"][-1], [18.5, 8.5, 2.5], rtol=1e-9)
    fallen = 10.0 * (1.0 * 0.4 + 0.6 * 0.55 + 0.25 * 0.7)
    assert recorded["diagnostics/dissipation"][-1] == pytest.approx(fallen, rel=1e-9)


#: A short arm that falls on a stop at the end of its range, where it stays or bounces.
ARM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 4, output_step: 0.05, {steps}, formulation: {formulation}}}
bodies:
  arm: {{mass: 0.4, inertia: [1e-6, 3e-5, 3e-5], position: [0.025, 0, 0]}}
joints:
  hip: {{type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, 1, 0], speed: 2.0,
        limits: {{angle: {{range: [-0.5, {high}], rigid: true, restitution: {e}}}}}}}
"""
#: A wheel that turns between two stops, more than a turn from each other.
WHEEL = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 9, output_step: 0.05, {steps}, formulation: {formulation}}}
bodies:
  wheel: {{mass: 3, inertia: [0.2, 0.3, 0.2], position: [0, 0, 0]}}
joints:
  axle: {{type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], speed: 11,
         limits: {{angle: {{range: [-4, 9], rigid: true, restitution: 0.7}}}}}}
"""
CONTROLLED = [f"integrator: {name}, tolerance: 1.0e-9" for name in ("dop853", "dopri5", "radau5")]


@pytest.mark.full_where(formulation="full")
@crossed(
    "steps, e, formulation",
    [*(pytest.param(steps, 0.0) for steps in CONTROLLED), pytest.param(CONTROLLED[0], 0.4)],
    ["planar", "reduced", "full"],
    dear=["full"],
)
def test_an_angle_at_rest_behind_an_impact_gains_no_turns(steps, e, formulation):
    """Steps at rest are so long that the rate before the impact would turn by whole turns in one."""
    for high in np.linspace(0.9, 1.3, 5):
        _, recorded = run(ARM.format(steps=steps, e=e, formulation=formulation, high=high))
        met = recorded.of("rest" if e else "impact")[-1].time
        rests = recorded["time"] > met
        assert recorded["diagnostics/step_size"][rests].max() > 0.3
        np.testing.assert_allclose(recorded["joints/coordinate"][rests, 0], high, rtol=0, atol=1e-9)
        np.testing.assert_allclose(recorded["stops/gap"][rests], [[0.5 + high, 0.0]] * rests.sum(), rtol=0, atol=1e-9)


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_a_wheel_between_stops_is_followed_through_its_turns(formulation):
    """Its angle is piecewise linear: each impact keeps 0.7 of the speed, and turns it."""
    steps = "integrator: dop853, tolerance: 1.0e-9"
    _, recorded = run(WHEEL.format(steps=steps, formulation=formulation))
    times, angles, speed = [0.0], [0.0], 11.0
    while times[-1] < 9.0:
        end = 9.0 if speed > 0.0 else -4.0
        times.append(times[-1] + (end - angles[-1]) / speed)
        angles.append(end)
        speed *= -0.7
    assert len(recorded.of("impact")) == len(times) - 2 > 3
    expected = np.interp(recorded["time"], times, angles)
    np.testing.assert_allclose(recorded["joints/coordinate"][:, 0], expected, rtol=0, atol=1e-7)
