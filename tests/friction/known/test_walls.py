"""Dry friction and a rigid stop along one coordinate: what has come to rest at the stop is held by both."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crossed import crossed, full
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import run, same, simulated

pytestmark = needs_kernel

#: A block on a rail with two ends, with friction, pushed to and fro.
BLOCK = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: {duration}, {steps}, output_step: {output_step}, formulation: {formulation}}}
bodies:
  block: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
joints:
  rail:
    type: prismatic
    bodies: [ground, block]
    location: [0, 0, 0]
    axis: [1, 0, 0]
    speed: 1
    limits: {{displacement: {{range: [-0.1, 0.1], rigid: true, restitution: {restitution}}}}}
forces:
  rub: {{type: friction, joint: rail, coulomb: {{force: 2, static: 3}}}}
  push: {{type: force, body: block, location: [0, 0, 0], force: ["8 * sin(3 * t)", 0, 0]}}
"""
DOP853 = "integrator: dop853, tolerance: 1.0e-11"
STEPS = {
    "dop853": DOP853,
    "rk4": "integrator: rk4, step: 5.0e-3",
    "radau5": "integrator: radau5, tolerance: 1.0e-9",
    "auto": "integrator: auto, tolerance: 1.0e-9",
}
#: When the push on the block, away from the end at which it rests, is as large as static friction.
SLIPS = (np.pi * np.arange(1, 5) + np.arcsin(3.0 / 8.0)) / 3.0


def block(steps=DOP853, duration=4.5, output_step=0.01, formulation="planar", restitution=0.0):
    return BLOCK.format(
        steps=steps, duration=duration, output_step=output_step, formulation=formulation, restitution=restitution
    )


#: With the equations in NumPy a run takes many seconds: one explicit method and one implicit.
RUNS = [
    *((steps, formulation) for formulation in ("planar", "reduced") for steps in STEPS),
    full("rk4", "full"),
    full("radau5", "full"),
]


@pytest.mark.parametrize(("steps", "formulation"), RUNS)
def test_it_rests_until_the_push_away_exceeds_static_friction(steps, formulation):
    """And the end and friction bear half each of what pushes it there, or friction as much as it can."""
    duration, slips = (1.3, SLIPS[:1]) if formulation == "full" else (4.5, SLIPS)
    _, recorded = run(block(STEPS[steps], duration, formulation=formulation))
    for kind in ("slip", "release"):
        assert [event.time for event in recorded.of(kind)] == pytest.approx(slips, abs=1e-8)
    assert len(recorded.of("contact")) == len(recorded.of("stick")) == len(slips)
    t, x, v = recorded["time"], recorded["bodies/position"][:, 0, 0], recorded["bodies/velocity"][:, 0, 0]
    rests = (np.abs(np.abs(x) - 0.1) < 1e-12) & (np.abs(v) < 1e-12)
    assert rests.sum() > 100
    side = np.sign(x[rests])
    inward = side * 8.0 * np.sin(3.0 * t[rests])  # the load, towards the end
    by_friction = np.where(inward > 0.0, np.minimum(0.5 * inward, 3.0), inward)
    np.testing.assert_allclose(recorded["friction/force"][rests, 0], -side * by_friction, atol=1e-8)
    np.testing.assert_allclose(recorded["stops/force"][rests].sum(axis=1), inward - by_friction, atol=1e-8)


def test_a_block_that_bounces_before_it_rests_does_so_in_the_plane_and_in_space():
    plane, space = (run(block(formulation=own, restitution=0.6))[1] for own in ("planar", "reduced"))
    same(plane, space, ("bodies/position", "bodies/velocity", "friction/force", "stops/force"), 2e-8)
    assert len(plane.of("impact")) > 6


def test_recording_has_no_say():
    """Neither how often nor how long is recorded decides what happens, and when."""
    cases = [(3.3, 0.9), (5.0, 0.9), (3.3, 0.01)]
    found = [run(block(duration=d, output_step=every, restitution=0.6))[1] for d, every in cases]
    expected = [event for event in found[0].happened if event.time < 3.2]
    assert len(expected) > 20
    for each in found[1:]:
        own = [event for event in each.happened if event.time < 3.2]
        assert [(event.kind, event.name) for event in own] == [(event.kind, event.name) for event in expected]
        assert [event.time for event in own] == pytest.approx([event.time for event in expected], abs=1e-9)


@pytest.mark.parametrize("steps", ["dop853", "rk4"])
def test_a_run_goes_on_from_where_it_rests(steps):
    whole, _ = simulated(block(STEPS[steps]))
    for until in (0.5, 1.1, 1.3, 2.0):
        _, kept = simulated(block(STEPS[steps], duration=until))
        rest, _ = simulated(block(STEPS[steps]), kept[-1])
        after = whole["time"] > kept[-1]["t"]
        for path in ("time", "bodies/position", "bodies/velocity", "friction/force", "stops/force"):
            assert np.array_equal(rest[path], whole[path][after]), path
        assert rest.happened == whole.happened


@pytest.mark.full_where(formulation="full")
@crossed("load, formulation", [-2.0, 0.0, 2.0], ["planar", "full"], dear=["full"])
def test_it_may_begin_at_an_end(formulation, load):
    """At rest, with nothing that pushes it, towards the end or away."""
    text = block(formulation=formulation, duration=0.5).replace("speed: 1", "speed: 0")
    text = text.replace("range: [-0.1, 0.1]", "range: [-0.2, 0]")
    text = text.replace('"8 * sin(3 * t)"', str(load))
    _, recorded = run(text)
    assert sorted(event.kind for event in recorded.happened) == ["contact", "shared", "shared"]
    np.testing.assert_allclose(recorded["bodies/position"][:, 0, 0], 0.0, atol=1e-15)
    np.testing.assert_allclose(recorded["stops/force"][:, 1], max(load, 0.0) / 2.0, atol=1e-12)
    np.testing.assert_allclose(recorded["friction/force"][:, 0], -load if load < 0.0 else -0.5 * load, atol=1e-12)
