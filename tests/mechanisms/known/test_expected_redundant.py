"""The numbers in the `expect` blocks of redundant linkages and of the massless rod, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.mechanisms.closed_forms import Linkage, bare, bennett_poses, bricard_poses, expected, piston, reached_at
from tests.mechanisms.running import assert_close


def test_bennetts_linkage_by_energy_and_its_relation():
    known = bare("bennett")
    linkage = Linkage(known, lambda u: bennett_poses(known, u))
    start = known.parameters["start"]
    θ = reached_at(2.0, 30.0, start, known.parameters["speed"], linkage.moment, linkage.potential)
    assert_close(expected("bennett", "crank"), θ - start, 1e-10)
    r, A = bennett_poses(known, θ)
    assert_close(expected("bennett", "coupler_point"), (r[1] + A[1] @ [0.0, 0.06, 0.0]).real, 1e-10)


@pytest.mark.full
def test_the_invertible_cube_by_energy_and_its_closed_curve():
    """From the cube, tan(45° + β/2) = √3 sin u = 1, where β' = √3 cos u u'."""
    known = bare("bricard")
    linkage = Linkage(known, lambda u: bricard_poses(known, u))
    start = np.arcsin(np.sqrt(1 / 3))
    speed = known.parameters["speed"] / (np.sqrt(3) * np.cos(start))
    u = reached_at(2.0, 25.0, start, speed, linkage.moment, linkage.potential)
    β = 2 * np.arctan(np.sqrt(3) * np.sin(u)) - np.pi / 2
    assert_close(expected("bricard", "pin"), β, 1e-10)
    assert_close(expected("bricard", "third_pin"), β, 1e-10)
    r, A = bricard_poses(known, u)
    side = known.parameters["side"]
    assert_close(expected("bricard", "far_corner"), (r[2] + A[2] @ [0.0, -side / 2, 0.0]).real, 1e-10)


def test_the_n_four_bar_by_its_equation():
    """φ'' = g (3/2 + 2) / (3/3 + 2) sin φ for N = 2."""
    known = bare("n_four_bar").parameters
    rate = 9.81 * 3.5 / 3.0 / known["length"]
    done = solve_ivp(
        lambda t, y: [y[1], rate * np.sin(y[0])],
        (0.0, 10.0),
        [0.0, known["speed"]],
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
    )
    for entry in ("turned", "last_bar"):
        assert_close(expected("n_four_bar", entry), done.y[0, -1], 1e-9)


def test_the_locomotives_wheels_by_energy():
    known = bare("locomotive").parameters
    m, r = known["rod"], known["pin"]
    moment = lambda θ: 2 * known["wheel"] + 2 * m * r**2  # noqa: E731
    potential = lambda θ: m * 9.81 * r * (np.sin(θ) + np.cos(θ))  # noqa: E731
    θ = reached_at(3.0, 30.0, 0.0, known["speed"], moment, potential)
    for entry in ("rear", "front"):
        assert_close(expected("locomotive", entry), θ, 1e-10)


def test_the_massless_rod_by_energy_and_the_pistons_acceleration():
    """With I = J + m s'², I θ'' = -m s' s'' θ'² - m_c g c cos θ, and the rod pushes with m (s' θ'' + s'' θ'²)."""
    known = bare("massless_coupler")
    p = known.parameters
    moment = lambda θ: p["flywheel"] + p["piston"] * float(piston(known, θ)[1]) ** 2  # noqa: E731
    potential = lambda θ: p["crank_mass"] * 9.81 * p["centre"] * np.sin(θ)  # noqa: E731
    θ = reached_at(2.0, 40.0, p["start"], p["speed"], moment, potential)
    assert_close(expected("massless_coupler", "crank"), θ - p["start"], 1e-10)
    s, slope, bend = piston(known, θ)
    assert_close(expected("massless_coupler", "piston"), s, 1e-11)
    energy = moment(p["start"]) * p["speed"] ** 2 / 2 + potential(p["start"])
    square = 2 * (energy - potential(θ)) / moment(θ)
    weight = p["crank_mass"] * 9.81 * p["centre"] * np.cos(θ)
    push = p["piston"] * (bend * square - slope * (p["piston"] * slope * bend * square + weight) / moment(θ))
    lean = np.arcsin(p["crank"] / p["rod"] * np.sin(θ))
    assert_close(expected("massless_coupler", "crank_pin"), [push, 0.0, -push * np.tan(lean)], 1e-9)
