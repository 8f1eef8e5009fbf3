"""Nothing goes through a stop within a step, and what bounces among several bodies comes to rest on them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.stops.inside.scenes import THREE_BALLS
from tests.stops.runs import DOP853, run

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


@pytest.mark.parametrize("formulation", ["reduced", "full"])
@pytest.mark.parametrize("steps", STEPS)
def test_what_rises_and_falls_through_within_a_step_is_stopped(steps, formulation):
    """It passes the whole sphere within the step, so that the gap is open at both ends of it."""
    _, recorded = run(THROWN.format(duration=5, steps=steps, formulation=formulation, stop=SPHERE))
    first = (2.0 + np.sqrt(5.0)) / 10.0
    met = [event.time for event in recorded.happened if event.kind == "impact"]
    assert met[0] == pytest.approx(first, abs=1e-12)
    assert np.diff(met) == pytest.approx(2.0 * np.sqrt(5.0) / 10.0, rel=1e-10)
    assert recorded["stops/gap"].min() > -1e-11


@pytest.mark.parametrize(("formulation", "e"), [("reduced", 0.5), ("reduced", 0.8), ("full", 0.5)])
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
