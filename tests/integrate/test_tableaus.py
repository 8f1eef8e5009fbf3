"""The implicit methods: order conditions, stiff accuracy, L-stability, estimates and extensions."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.integrate.steppers.implicit_tableau import load_implicit_tableau
from mbproj.integrate.steppers.stability_region import amplification

NAMES = ("esdirk4", "radau5")
#: The trees up to order 5 as weights of the stages, with 1 / density (Hairer, Nørsett & Wanner 1993, table II.2.2).
TREES = {
    1: [lambda A, c: (np.ones_like(c), 1)],
    2: [lambda A, c: (c, 2)],
    3: [lambda A, c: (c**2, 3), lambda A, c: (A @ c, 6)],
    4: [
        lambda A, c: (c**3, 4),
        lambda A, c: (c * (A @ c), 8),
        lambda A, c: (A @ c**2, 12),
        lambda A, c: (A @ A @ c, 24),
    ],
    5: [
        lambda A, c: (c**4, 5),
        lambda A, c: (c**2 * (A @ c), 10),
        lambda A, c: (c * (A @ c**2), 15),
        lambda A, c: (c * (A @ A @ c), 30),
        lambda A, c: ((A @ c) ** 2, 20),
        lambda A, c: (A @ c**3, 20),
        lambda A, c: (A @ (c * (A @ c)), 40),
        lambda A, c: (A @ A @ c**2, 60),
        lambda A, c: (A @ A @ A @ c, 120),
    ],
}


def trees(tableau, order):
    """Of all trees of an order: the weight of each stage, and 1 / density."""
    return [tree(tableau.a, tableau.c) for tree in TREES[order]]


@pytest.mark.parametrize("name", NAMES)
def test_order_conditions(name):
    """All trees up to the order are met, and not all of the next; the rows of a sum to c."""
    tableau = load_implicit_tableau(name)
    for order in range(1, tableau.order + 1):
        for weights, density in trees(tableau, order):
            assert tableau.b @ weights == pytest.approx(1.0 / density, abs=2e-16 * 8)
    np.testing.assert_allclose(tableau.a.sum(axis=1), tableau.c, atol=1e-15)
    if tableau.order == 4:
        assert any(abs(tableau.b @ weights - 1.0 / density) > 1e-4 for weights, density in trees(tableau, 5))


@pytest.mark.parametrize("name", NAMES)
def test_estimates_vanish_up_to_their_order(name):
    """The weights of the estimate are those of a difference of two methods, the second of order 3."""
    tableau = load_implicit_tableau(name)
    for order in range(1, tableau.error_order + 1):
        for weights, _ in trees(tableau, order):
            assert tableau.error @ weights == pytest.approx(0.0, abs=1e-15)
    assert any(abs(tableau.error @ weights) > 1e-4 for weights, _ in trees(tableau, tableau.error_order + 1))


@pytest.mark.parametrize("name", NAMES)
def test_extensions_are_of_order_4_at_every_theta(name):
    """All trees up to order 4 are met within the step; values and slopes are those of both ends."""
    tableau = load_implicit_tableau(name)
    powers = np.arange(1, tableau.dense.shape[1] + 1)
    for theta in (0.2, 0.45, 0.7, 1.0):
        within = tableau.dense @ theta**powers
        for order in range(1, 5):
            for weights, density in trees(tableau, order):
                assert within @ weights == pytest.approx(theta**order / density, abs=2e-15)
    np.testing.assert_allclose(tableau.dense.sum(axis=1), tableau.b, atol=2e-15)
    np.testing.assert_allclose(tableau.dense[:, 0], np.eye(tableau.stages)[0], atol=1e-15)
    np.testing.assert_allclose(tableau.dense @ powers, np.eye(tableau.stages)[-1], atol=1e-14)


def test_radau_is_collocation():
    """Its nodes are the roots of Radau's polynomial; B(5), C(3) and D(2) hold (Hairer & Wanner 1996, sect. IV.5)."""
    tableau = load_implicit_tableau("radau5")
    a, b, c = tableau.a[1:, 1:], tableau.b[1:], tableau.c[1:]
    np.testing.assert_allclose(c, [0.4 - np.sqrt(0.06), 0.4 + np.sqrt(0.06), 1.0], rtol=2e-16)
    for k in range(1, 6):
        assert b @ c ** (k - 1) == pytest.approx(1.0 / k, abs=1e-15)
    for k in range(1, 4):
        np.testing.assert_allclose(a @ c ** (k - 1), c**k / k, atol=1e-15)
    for k in range(1, 3):
        np.testing.assert_allclose((b * c ** (k - 1)) @ a, b * (1.0 - c**k) / k, atol=1e-15)
    real = np.linalg.eigvals(a)
    assert tableau.gamma == pytest.approx(float(real[np.abs(real.imag) < 1e-12].real[0]), rel=1e-14)


@pytest.mark.parametrize("name", NAMES)
def test_stiffly_accurate_and_l_stable(name):
    """The last stage is the step; |R| <= 1 on the imaginary axis, no pole is on the left, and R is 0 at infinity."""
    tableau = load_implicit_tableau(name)
    np.testing.assert_array_equal(tableau.a[-1], tableau.b)
    assert tableau.c[-1] == 1.0
    assert np.all(np.linalg.eigvals(tableau.a[1:, 1:]).real > 0.0)
    assert max(amplification(tableau, 1j * y) for y in np.geomspace(1e-3, 1e6, 400)) <= 1.0 + 1e-14
    assert amplification(tableau, -1e6) < 2e-5 and amplification(tableau, 1e6j) < 2e-5


def test_damping_of_vibration():
    """|R| at z = i, 10 i and 100 i: little, much and nearly all of a vibration is lost in a step."""
    found = {name: [amplification(load_implicit_tableau(name), z) for z in (1j, 10j, 100j)] for name in NAMES}
    assert found["esdirk4"] == pytest.approx([0.99998, 0.75, 0.09], rel=0.05)
    assert found["radau5"] == pytest.approx([0.9999, 0.32, 0.03], rel=0.05)


def test_only_radau_couples_its_stages():
    assert [bool(np.triu(load_implicit_tableau(name).a, 1).any()) for name in NAMES] == [False, True]


def test_coupled_stages_are_solved_one_by_one():
    """A pass over the stages multiplies the error of their slopes by Z = z (I - z L)⁻¹ (A - L), of spectral radius
    at most 0.2733 on the left half plane."""
    tableau = load_implicit_tableau("radau5")
    A, L = tableau.a[1:, 1:], tableau.splitting[1:, 1:]
    np.testing.assert_array_equal(np.triu(L), tableau.gamma * np.eye(3))
    assert not tableau.splitting[0].any() and not tableau.splitting[:, 0].any()

    def radius(z: complex) -> float:
        return float(np.abs(np.linalg.eigvals(z * np.linalg.solve(np.eye(3) - z * L, A - L))).max())

    for angle in np.linspace(0.5, 1.0, 6) * np.pi:
        assert max(radius(y * np.exp(1j * angle)) for y in np.geomspace(1e-3, 1e6, 100)) < 0.2733
    np.testing.assert_array_equal(load_implicit_tableau("esdirk4").splitting, load_implicit_tableau("esdirk4").a)
