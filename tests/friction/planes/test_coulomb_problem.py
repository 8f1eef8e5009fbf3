"""Coulomb's law at an instant, for bodies on more feet than rigid bodies can say the loads of: what it asks holds, and
the motion is that of closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from tests.friction.planes.scenes import MASS, WEIGHT, beam, feet
from tests.kernel.scenes import needs_kernel
from tests.laws import Cone, coulomb_problem

pytestmark = needs_kernel


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
