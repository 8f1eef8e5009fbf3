"""The law of contacts: shares on the Delassus operator, against closed forms and against springs that give."""

from __future__ import annotations

import numpy as np
import pytest

from tests.friction.planes.scenes import HEIGHT, MASS, WEIGHT, beam, feet
from tests.kernel.scenes import needs_kernel
from tests.laws import Cone, contact_problem

pytestmark = needs_kernel


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
