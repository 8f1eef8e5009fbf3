"""Feet that stick and share a load: the share that a run keeps has a margin, and what is at an edge is decided once."""

from __future__ import annotations

import numpy as np
import pytest

from tests.friction.planes.scenes import box
from tests.kernel.scenes import needs_kernel
from tests.laws import FrictionBalance
from tests.stops.runs import run

pytestmark = needs_kernel

MASS, INERTIA, STATIC = 3.0, np.array([0.1, 0.15, 0.12]), 0.5


def two_feet(first, second, force):
    """A box on two feet at rest, with a force in its centre and its weight."""
    inverse = np.concatenate([[MASS] * 3, INERTIA]) ** -0.5
    places = [np.array([*first, -0.25]), np.array([*second, -0.25])]

    def row(place, along):
        return np.concatenate([along, np.cross(place, along)]) * inverse

    x, y, z = np.eye(3)
    A = np.array([*(row(place, z) for place in places), *(row(place, along) for place in places for along in (x, y))])
    return FrictionBalance(
        A=A,
        b=A @ (np.array([*force, -10.0 * MASS, 0.0, 0.0, 0.0]) * inverse),
        static=np.full(4, STATIC),
        sliding=np.full(4, STATIC),
        direction=np.zeros(4),
        partner=np.array([1, 0, 3, 2]),
        stop=np.array([0, 0, 1, 1]),
        loads=lambda y: y[[0, 0, 1, 1]],
    )


@pytest.mark.parametrize("part", [0.0, 0.5, 0.9, 0.99, 0.9999])
def test_the_share_that_holds_has_a_margin(part):
    """Pushed along the line between them two feet hold while the force is below μ m g. In proportion to their pushes
    each uses that part of what it can hold; of the margin that this leaves a tenth is kept at least."""
    found = two_feet((0.2, 0.0), (-0.4, 0.0), (part * STATIC * 30.0, 0.0)).balanced()
    push, along = found.y[:2], found.y[2:].reshape(2, 2)
    assert push == pytest.approx([20.0 + part * 6.25, 10.0 - part * 6.25], abs=1e-8)
    assert along.sum(axis=0) == pytest.approx([-part * 15.0, 0.0], abs=1e-8)
    used = np.linalg.norm(along, axis=1) / (STATIC * push)
    assert used.max() < 1.0 - 0.05 * (1.0 - part)


@pytest.mark.parametrize("part", [0.0, 0.1, 0.2])
def test_the_least_share_is_kept_where_it_has_a_margin(part):
    """Of all shares that carry the load it is the one of least norm, which the pseudoinverse gives."""
    problem = two_feet((0.2, 0.0), (-0.4, 0.0), (part * STATIC * 30.0, 0.0))
    least = -np.linalg.pinv(problem.A @ problem.A.T, rcond=1e-12, hermitian=True) @ problem.b
    assert problem.balanced().y == pytest.approx(least, abs=1e-9)


@pytest.mark.parametrize("angle", [0.3, 1e-2, 2e-3, 1e-4, 1e-6, 0.0])
def test_two_feet_that_stick_hold_five_rows_of_six(angle):
    """Along the line between them one row is too many, however near to a tangent that line is."""
    x, y = 0.35 * np.cos(angle), 0.35 * np.sin(angle)
    problem = two_feet((0.02 + x, y - 0.05), (0.02 - x, -y - 0.05), (1.0, -3.0))
    found = problem.balanced()
    assert found.stuck.sum() == 3
    assert np.abs(problem.accelerations(found.y)).max() < 1e-11


@pytest.mark.parametrize("steps", ["dop853", "radau5"])
def test_feet_come_to_rest_at_the_edge_of_what_they_bear(steps):
    """A box on two feet on an incline, with a push that turns: both slide, and stick at 0.6 s with a share at the edge
    of one of them."""
    feet = {"a": (0.33, 0.01), "b": (-0.35, -0.29)}
    push = '["24.1*sin(8*t)", "8*cos(8*t)", 0]'
    _, recorded = run(box(feet, "0.52", force=push, gravity=(2.44, 0, -10), duration=0.9, steps=steps))
    happened = [(event.kind, round(event.time, 5)) for event in recorded.of("slip", "stick")]
    assert happened[:4] == [("slip", 0.00639), ("slip", 0.00639), ("stick", 0.59759), ("stick", 0.60008)]
    assert recorded.unbalanced < 1e-6


@pytest.mark.parametrize("steps", ["dop853", "rk4"])
def test_feet_that_lose_their_push_at_once_are_let_go_together(steps):
    """Of four feet that slide two lose it in one instant, where the box begins to tip over the other two. One of them
    had been without a push before. The fixed steps find the same rest within a step."""
    feet = {"a": (-0.03, -0.23), "b": (-0.32, 0.29), "c": (-0.18, -0.12), "d": (0.25, -0.3)}
    falls = "{coefficient: 0.48, static: 0.672, stribeck_speed: 0.2}"
    friction = {"a": "0.14", "b": falls, "c": "0.58", "d": "{coefficient: 0.38, static: 0.532}"}
    push = '["3.6*sin(3.6*t)", "9.5*cos(3.6*t)", 0]'
    given = {"velocity": (0.1, -0.73, 0), "spin": (0, 0, -1.22), "force": push, "duration": 0.15, "steps": steps}
    _, recorded = run(box(feet, friction, **given))
    happened = [(event.name, event.kind, round(event.time, 6)) for event in recorded.of("release", "stick", "slip")]
    assert happened == [
        ("stop 'a'", "release", 0.100288),
        ("friction 'b'", "stick", 0.10989),
        ("friction 'd'", "stick", 0.10989),
    ]
    assert recorded.unbalanced < 1e-6
