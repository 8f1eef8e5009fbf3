"""Dry friction beside rigid stops and beside motions."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crossed import crossed, full
from tests.friction import closed_forms as exact
from tests.friction.mechanisms import incline, rotor
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import run, same, simulated

# Dry friction and a rigid stop along one coordinate: what has come to rest at the stop is held by both.

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


@needs_kernel
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


@needs_kernel
def test_a_block_that_bounces_before_it_rests_does_so_in_the_plane_and_in_space():
    plane, space = (run(block(formulation=own, restitution=0.6))[1] for own in ("planar", "reduced"))
    same(plane, space, ("bodies/position", "bodies/velocity", "friction/force", "stops/force"), 2e-8)
    assert len(plane.of("impact")) > 6


@needs_kernel
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


@needs_kernel
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


@needs_kernel
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


# Dry friction beside motions, which pay for it, and beside stops, which strike what it brakes.

J = 0.5
DRIVEN = """
motions:
  drive: {{joint: hinge, angle: {angle}}}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_motion_pays_for_the_friction_of_its_own_joint(formulation):
    """Driven to and fro: its torque is J θ'' and the brake's 4 N m against the rate, its work 4 N m times the way."""
    text = rotor("{torque: 4}", speed=1.0, duration=3.0, formulation=formulation) + DRIVEN.format(angle="sin(t)")
    _, recorded = run(text)
    t = recorded["time"]
    turns = np.abs(t - 0.5 * np.pi) > 1e-9
    assert recorded["friction/force"][turns, 0] == pytest.approx(-4.0 * np.sign(np.cos(t[turns])), abs=1e-9)
    way = np.where(t < 0.5 * np.pi, np.sin(t), 2.0 - np.sin(t))
    assert recorded["friction/dissipation"][:, 0] == pytest.approx(4.0 * way, abs=1e-8)
    kinetic = 0.5 * J * (np.cos(t) ** 2 - 1.0)
    assert recorded["diagnostics/work"] == pytest.approx(4.0 * way + kinetic, abs=1e-8)
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_motion_that_rests_holds_with_its_brake(formulation):
    """From 1 s on the motion stands still: nothing moves, and what brake and motion bear together is the load."""
    text = rotor("{torque: 4}", speed=0.0, load="3", duration=2.0, formulation=formulation)
    _, recorded = run(text + DRIVEN.format(angle="{smooth_step: {to: 1, duration: 1}}"))
    resting = recorded["time"] > 1.0
    assert recorded["joints/coordinate"][resting, 0] == pytest.approx(1.0, abs=1e-12)
    assert (np.abs(recorded["friction/force"][resting, 0]) <= 4.0 + 1e-9).all()
    assert recorded["friction/dissipation"][-1, 0] == pytest.approx(4.0, rel=1e-8)


@pytest.mark.parametrize("steps", ["dop853", "rk4"])
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_braked_rotor_strikes_a_wall_and_comes_to_rest_on_its_way_back(formulation, steps):
    """ω² falls by 2 torque/J for each radian; the wall at 20 rad gives back half of the speed."""
    text = rotor("{torque: 10}", steps=steps, formulation=formulation)
    text = text.replace(
        "axis: [0, 0, 1], ", "axis: [0, 0, 1], limits: {angle: {range: [null, 20], rigid: true, restitution: 0.5}}, "
    )
    _, recorded = run(text)
    struck = np.sqrt(30.0**2 - 2.0 * 20.0 * 20.0)
    first = (30.0 - struck) / 20.0
    time, way = exact.brake_stops(J, 0.5 * struck, 10.0)
    (hit,) = recorded.of("impact")
    assert hit.time == pytest.approx(first, abs=1e-9)
    assert hit.impulse == pytest.approx(1.5 * J * struck, rel=1e-9)
    (sticks,) = recorded.of("stick")
    assert sticks.time == pytest.approx(first + time, abs=1e-9)
    assert recorded["joints/coordinate"][-1, 0] == pytest.approx(20.0 - way, abs=1e-9)
    assert recorded.unbalanced < 1e-8


def test_a_block_slides_down_to_a_wall_and_rests_there():
    """tan 0.5 is above the static coefficient: what friction does not hold, the wall does."""
    text = incline("0.5", "{coefficient: 0.3, static: 0.4}", duration=1.5)
    text = text.replace("speed: 0.0", "speed: 0, limits: {displacement: {range: [-1, null], rigid: true}}")
    _, recorded = run(text)
    a = exact.down_an_incline(0.5, 0.3, 9.81)
    (hit,) = recorded.of("impact")
    assert hit.time == pytest.approx(np.sqrt(2.0 / a), abs=1e-9)
    assert hit.energy == pytest.approx(3.0 * a, rel=1e-9)
    assert recorded["joints/coordinate"][-1, 1] == pytest.approx(-1.0, abs=1e-10)
    together = recorded["friction/force"][-1, 0] + recorded["stops/force"][-1, 0]
    assert together == pytest.approx(3.0 * 9.81 * np.sin(0.5), rel=1e-9)
    assert abs(recorded["friction/force"][-1, 0]) <= 0.4 * 3.0 * 9.81 * np.cos(0.5) + 1e-9
    assert recorded.unbalanced < 1e-8
