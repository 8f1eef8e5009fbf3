"""The problem of contacts at an instant: laws, shares on the Delassus operator, and the margin of what sticks."""

from __future__ import annotations

import numpy as np
import pytest

from tests.friction.planes.scenes import HEIGHT, MASS, WEIGHT, beam, box, feet
from tests.kernel.scenes import needs_kernel
from tests.laws import Cone, FrictionBalance, contact_problem, coulomb_problem
from tests.stops.runs import run

pytestmark = needs_kernel


# The law of contacts: shares on the Delassus operator, against closed forms and against springs that give.


def test_what_sticks_takes_the_least_forces_that_hold():
    B, b = beam([-0.4, 0.1, 0.3], 4.0, -HEIGHT)
    y = contact_problem(B, b, feet(3, 0.5))
    held = np.linalg.lstsq(B, -b, rcond=1e-12)[0]
    assert np.abs(held[3:]).max() < 0.5 * held[:3].min()
    assert y == pytest.approx(held, abs=1e-9)


@pytest.mark.parametrize("part", [0.5, 0.97, 0.999, 1.0 - 1e-9])
def test_it_sticks_while_some_share_does(part):
    """Two feet bear unequal parts of the load, and all that both can hold counts."""
    B, b = beam([-0.5, 0.3], part * 0.4 * WEIGHT, -HEIGHT)
    y = contact_problem(B, b, feet(2, 0.4))
    assert np.abs(b + B @ y).max() < 1e-9
    assert (np.abs(y[2:]) <= 0.4 * y[:2] * (1.0 + 1e-12)).all()
    assert contact_problem(*beam([-0.5, 0.3], 0.4 * WEIGHT * (1.0 + 1e-8), -HEIGHT), feet(2, 0.4)) is None


@pytest.mark.parametrize("places", [[-0.4, 0.1, 0.3], [-0.3, -0.1, 0.05, 0.6]])
def test_what_slides_shares_as_springs_do_that_hardly_give(places):
    """The limit of (B + ε I) z + b >= 0, z >= 0: feet that this leaves without a load have none."""
    count, friction = len(places), 0.6
    B, b = beam(places, 0.0, 0.0)
    y = contact_problem(B, b, feet(count, 0.0, (-friction,)))
    slid = B[:count, :count] - friction * B[:count, count:]
    z = np.full(count, WEIGHT / count)
    for _ in range(5):  # of the feet that push, those that springs still press
        pushed = z > 0.0
        z = np.zeros(count)
        z[pushed] = np.linalg.solve((slid + 1e-7 * np.eye(count))[np.ix_(pushed, pushed)], -b[:count][pushed])
    assert y[:count] == pytest.approx(np.maximum(z, 0.0), abs=1e-4)
    assert y[:count].sum() == pytest.approx(WEIGHT)


def test_the_order_of_the_feet_is_no_part_of_it():
    B, b = beam([-0.4, 0.1, 0.3], 11.0, -HEIGHT)
    order = [2, 0, 1]
    rows = [*order, *(3 + k for k in order)]
    y = contact_problem(B, b, feet(3, 0.5))
    assert contact_problem(B[np.ix_(rows, rows)], b[rows], feet(3, 0.5)) == pytest.approx(y[rows], abs=1e-9)


def test_two_joints_of_a_limit_each_and_a_foot_that_slides():
    """Intervals, and a foot whose friction follows its push, in closed form: 3 x'' = F - f₁ - f₂ - 0.5 z."""
    row = np.array([[0.0, 1.0]] + [[1.0, 0.0]] * 3) / np.sqrt(MASS)
    cones = [Cone(0, (1,), slides=(-0.5,)), Cone(-1, (2,), 4.0), Cone(-1, (3,), 9.0)]
    y = contact_problem(row @ row.T, np.array([-WEIGHT, 22.0, 22.0, 22.0]) / MASS, cones)
    assert y == pytest.approx([WEIGHT, -0.5 * WEIGHT, -3.5, -3.5], abs=1e-9)
    y = contact_problem(row @ row.T, np.array([-WEIGHT, 26.0, 26.0, 26.0]) / MASS, cones)
    assert y == pytest.approx([WEIGHT, -0.5 * WEIGHT, -4.0, -7.0], abs=1e-9)
    assert contact_problem(row @ row.T, np.array([-WEIGHT, 28.1, 28.1, 28.1]) / MASS, cones) is None


# Coulomb's law at an instant, for bodies on more feet than rigid bodies can say the loads of: what it asks holds, and
# the motion is that of closed forms.


def test_a_beam_that_is_pulled_harder_than_it_holds_accelerates_by_what_is_left():
    """x'' = (F - μ m g) / m, however the feet share the load."""
    B, b = beam([-0.4, 0.1, 0.3], 0.5 * WEIGHT + 6.0, -0.25)
    a = b + B @ coulomb_problem(B, b, feet(3, 0.5))
    assert a[:3] == pytest.approx([0.0] * 3, abs=1e-9)
    assert a[3:] == pytest.approx([6.0 / MASS] * 3, abs=1e-9)


def test_feet_whose_motion_is_given_slide_with_it():
    """A slider at a dead centre: no force changes its acceleration along the floor. All of its friction resists."""
    rows = np.array([[1.0, 0.3], [1.0, -0.3]])
    B = np.zeros((4, 4))
    B[:2, :2] = rows @ rows.T
    B[2:, 2:] = 1e-30
    y = coulomb_problem(B, np.array([-10.0, -10.0, 7.0, 7.0]), feet(2, 0.4))
    assert y[:2].sum() == pytest.approx(10.0) and y[2:] == pytest.approx(-0.4 * y[:2])


def rigid_body(random):
    """B and b of a body on two to six feet with inertias down to 1e-4 of m x², and the cones of the feet."""
    count, friction = int(random.integers(2, 7)), float(random.uniform(0.05, 0.9))
    places = np.column_stack([random.uniform(-0.5, 0.5, (count, 2)), np.full(count, -random.uniform(0.0, 0.3))])
    if random.random() < 0.3:
        places[:, 1] = 0.0  # in line
    mass = random.uniform(0.5, 10.0)
    inverse = np.diag([1.0 / mass] * 3 + list(1.0 / (mass * 10.0 ** random.uniform(-4, 0, 3))))
    axes = np.eye(3)
    rows = [np.r_[axes[2], np.cross(place, axes[2])] for place in places]
    rows += [np.r_[axes[k], np.cross(place, axes[k])] for place in places for k in (0, 1)]
    forces = np.r_[
        random.uniform(-1.5, 1.5, 2) * friction * mass * 10, -mass * 10, random.uniform(-1, 1, 3) * 0.1 * mass
    ]
    cones = [Cone(k, (count + 2 * k, count + 2 * k + 1), friction) for k in range(count)]
    return np.array(rows) @ inverse @ np.array(rows).T, np.array(rows) @ inverse @ forces, cones


def test_random_bodies_on_feet_obey_coulombs_law():
    """No foot pulls or sinks, none that opens pushes, no friction leaves its cone, and all is against the slip."""
    random, none = np.random.default_rng(70), 0
    for _ in range(200):
        B, b, cones = rigid_body(random)
        y = coulomb_problem(B, b, cones)
        if y is None:
            none += 1
            continue
        a, near = b + B @ y, 1e-8 * max(np.abs(b).max(), np.abs(np.diag(B) * y).max())
        for push, tangents, most, _ in cones:
            along, slip = y[list(tangents)], a[list(tangents)]
            assert y[push] > -1e-15 and a[push] > -near and y[push] * a[push] < near * max(y.max(), 1.0)
            assert np.linalg.norm(along) <= most * y[push] * (1.0 + 1e-6) + 1e-12
            size = np.linalg.norm(slip)
            assert np.linalg.norm(size * along + most * y[push] * slip) < 10.0 * near * max(y.max(), 1.0)
    assert none <= 8  # these are left to a slower method


# Feet that stick and share a load: the share that a run keeps has a margin, and what is at an edge is decided once.

BOX, INERTIA, STATIC = 3.0, np.array([0.1, 0.15, 0.12]), 0.5


def two_feet(first, second, force):
    """A box on two feet at rest, with a force in its centre and its weight."""
    inverse = np.concatenate([[BOX] * 3, INERTIA]) ** -0.5
    places = [np.array([*first, -0.25]), np.array([*second, -0.25])]

    def row(place, along):
        return np.concatenate([along, np.cross(place, along)]) * inverse

    x, y, z = np.eye(3)
    A = np.array([*(row(place, z) for place in places), *(row(place, along) for place in places for along in (x, y))])
    return FrictionBalance(
        A=A,
        b=A @ (np.array([*force, -10.0 * BOX, 0.0, 0.0, 0.0]) * inverse),
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
