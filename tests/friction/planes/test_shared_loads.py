"""Bodies on more feet than rigid bodies can say the loads of: what does not depend on how they share is as it must be,
whatever the order of the feet, and what does is told."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from mbproj.integrate import START
from tests.friction.planes.scenes import CORNERS, IN_PLANE, box
from tests.laws import FrictionBalance
from tests.stops.runs import run, simulated


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_beam_on_three_points_slides_as_on_one(formulation):
    """It is slowed down by μ g, whatever each foot bears."""
    places = {"a": (-0.4, 0.0), "b": (0.1, 0.0), "c": (0.35, 0.0)}
    _, recorded = run(box(places, 0.25, velocity=(1, 0, 0), joint=IN_PLANE, formulation=formulation))
    assert recorded["bodies/position"][-1, 0, 0] == pytest.approx(0.5 / 2.5, abs=1e-9)
    assert [event.time for event in recorded.of("stick")] == pytest.approx([0.4] * 3, abs=1e-5)
    assert recorded["stops/force"].sum(axis=1) == pytest.approx(30.0)
    assert recorded.unbalanced < 1e-9


def test_a_box_that_is_thrown_straight_slides_straight_on():
    report, recorded = run(box(CORNERS, 0.25, velocity=(1, 0, 0), steps="rk4"))
    assert recorded["bodies/position"][-1, 0] == pytest.approx([0.2, 0.0, 0.25], abs=1e-9)
    assert recorded["stops/force"].min() > 0.0
    assert {f"stop '{name}'" for name in "abcd"} <= {event.name for event in recorded.of("shared")}
    assert not report.decided_by_shares


def test_the_order_of_the_feet_changes_nothing_where_the_motion_depends_on_their_shares():
    """And it is said that it does."""
    ends = []
    for names in itertools.islice(itertools.permutations("abcd"), 0, None, 7):
        places = {name: CORNERS[name] for name in names}
        report, recorded = run(box(places, 0.25, velocity=(1, 0.4, 0), spin=(0, 0, 5), duration=0.3))
        assert "'a'" in report.decided_by_shares and "first at t = 0 s" in report.decided_by_shares
        ends.append(recorded["bodies/position"][-1, 0])
    assert np.ptp(ends, axis=0).max() < 1e-9


@pytest.mark.parametrize(("height", "formulation"), [(0.25, "planar"), (0.02, "planar"), (0.02, "reduced")])
def test_what_is_pushed_slips_where_all_feet_together_hold_no_more(height, formulation):
    """At static m g, however the feet share it."""
    places = {"a": (-0.45, 0.0), "b": (0.4, 0.0)}
    friction = "{coefficient: 0.3, static: 0.5}"
    text = box(places, friction, push=20, height=height, joint=IN_PLANE, formulation=formulation)
    _, recorded = run(text)
    assert [event.time for event in recorded.of("slip")] == pytest.approx([15.0 / 20.0] * 2, abs=1e-7)


def test_a_box_on_four_feet_slips_there_too():
    _, recorded = run(box(CORNERS, "{coefficient: 0.3, static: 0.5}", push=20, duration=0.8))
    assert [event.time for event in recorded.of("slip")] == pytest.approx([15.0 / 20.0] * 4, abs=1e-6)


JAWS = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: 0.1, tolerance: 1.0e-8, integrator: dop853, output_step: 0.01}}
bodies:
  jaw: {{mass: 0.3, inertia: [1.0e-4, 1.0e-4, 1.0e-4], position: [-0.03, 0, 0]}}
  part: {{mass: 0.8, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0, 0, 0]}}
joints:
  guide: {{type: prismatic, bodies: [ground, jaw], location: [-0.03, 0, 0], axis: [1, 0, 0]}}
forces:
  spring: {{type: linear_spring_damper, joint: guide, force: {force}}}
{points}
"""
POINT = """  {side}{z}:
    type: stop
    plane: {{body: {body}, location: [{x}, 0, 0], normal: [{normal}, 0, 0]}}
    point: {{body: part, location: [{x}, 0, {z}e-3]}}
    rigid: true
    friction: 0.3
"""


def jaws(force):
    sides = {"l": ("jaw", -0.02, 1), "r": ("ground", 0.02, -1)}
    points = (
        POINT.format(side=side, body=body, x=x, normal=normal, z=z)
        for side, (body, x, normal) in sides.items()
        for z in (7, -7)
    )
    return JAWS.format(force=force, points="".join(points))


def test_a_part_is_held_by_two_points_and_two():
    """Each pushes by half of what the jaw is pressed with, and bears a quarter of the weight."""
    _, recorded = run(jaws(50.0))
    assert np.abs(recorded["bodies/velocity"]).max() < 1e-9
    assert recorded["stops/force"] == pytest.approx(np.full((11, 4), 25.0))
    assert {"stop 'l7'", "stop 'r-7'"} <= {event.name for event in recorded.of("shared")}


def test_and_it_falls_where_they_press_too_little():
    """Four points, each with μ F/2, hold 0.6 F, less than the weight: the rest makes it fall."""
    _, recorded = run(jaws(10.0))
    assert recorded["bodies/velocity"][-1, 1, 2] == pytest.approx(-0.1 * (8.0 - 6.0) / 0.8, rel=1e-6)


def test_a_run_with_shared_loads_goes_on_as_one_run():
    text = box(CORNERS, 0.25, velocity=(1, 0.4, 0), spin=(0, 0, 5), duration=0.3)
    _, marks = simulated(text.replace("duration: 0.3", "duration: 0.2"))
    whole, _ = simulated(text, START)
    rest, _ = simulated(text, marks[-1])
    assert np.array_equal(rest["bodies/position"][-1], whole["bodies/position"][-1])


def test_the_least_share_of_what_holds_is_reported():
    """Two feet of one block bear the same part of the push, until one is at its edge."""
    places = {"a": (-0.45, 0.0), "b": (0.4, 0.0)}
    text = box(places, "{coefficient: 0.3, static: 0.5}", push=20, joint=IN_PLANE, duration=0.3)
    _, recorded = run(text)
    force = recorded["friction/force"][:, ::2]
    assert force == pytest.approx(np.repeat(-10.0 * recorded["time"][:, None], 2, axis=1), abs=1e-8)


def test_feet_that_want_what_no_forces_give_are_soon_found_out():
    """Two rows of friction are one, but for round-off: no forces hold both, and rounds would go on and on."""
    row, rounds = np.array([1.0, 0.5]), []

    def loads(y):
        rounds.append(1)
        return np.full(2, y[0])

    problem = FrictionBalance(
        A=np.array([[0.0, 1.0], row, row]),
        b=np.array([-1e-15, 1e-16, -3e-16]),
        static=np.full(2, 0.4),
        sliding=np.full(2, 0.4),
        direction=np.zeros(2),
        partner=np.full(2, -1),
        stop=np.zeros(2, dtype=int),
        loads=loads,
    )
    y = problem.forces()
    assert (np.abs(y[1:]) <= 0.4 * y[0] * (1.0 + 1e-12)).all()
    assert (problem.accelerations(y)[:1] >= -1e-25).all()
    assert len(rounds) < 5000
