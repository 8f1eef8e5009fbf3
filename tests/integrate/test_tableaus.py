"""The tableaus of all methods: order conditions, orders of a step, estimates, extensions, stability."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.registry import explicit_integrators, implicit_integrators, integrators
from mbproj.motion.numpy_loop import error_norm
from mbproj.motion.steppers.runge_kutta import ExplicitRungeKutta, amplification, reach, real_axis_limit
from mbproj.motion.steppers.tableau import load_implicit_tableau, load_tableau

# Every tableau: order conditions, orders of the step, the estimate and the extension on a nonlinear equation.

EXPLICIT = explicit_integrators()
EMBEDDED = [name for name in EXPLICIT if integrators()[name].embedded]


E = 0.3  # eccentricity


def f(t: float, y: np.ndarray) -> np.ndarray:
    """Kepler's problem: a planet about a fixed sun, semi-axis 1, period 2π."""
    return np.concatenate([y[2:], -y[:2] / np.hypot(*y[:2]) ** 3])


def exact(t: float, E: float = E) -> np.ndarray:
    """From the eccentric anomaly u, t = u - e sin u, by Newton's method."""
    u = t
    for _ in range(50):
        u -= (u - E * np.sin(u) - t) / (1.0 - E * np.cos(u))
    b, rate = np.sqrt(1.0 - E * E), 1.0 / (1.0 - E * np.cos(u))
    return np.array([np.cos(u) - E, b * np.sin(u), -np.sin(u) * rate, b * np.cos(u) * rate])


def one_step(name: str, h: float, t: float = 0.3):
    y = exact(t)
    return ExplicitRungeKutta(load_tableau(name)).attempt(f, t, y, h, f(t, y))


def slope(errors: list[float], ratio: float = 2.0) -> float:
    return float(np.log(errors[0] / errors[1]) / np.log(ratio))


@pytest.mark.parametrize("name", EXPLICIT)
def test_quadrature_conditions(name):
    """Σ b_i c_i^k = 1/(k+1) up to the order, and the rows of a sum to c."""
    tableau = load_tableau(name)
    for power in range(tableau.order):
        assert tableau.b @ tableau.c**power == pytest.approx(1.0 / (power + 1), abs=4e-15)
    np.testing.assert_allclose(tableau.a.sum(axis=1), tableau.c, atol=4e-15)


@pytest.mark.parametrize("name", EXPLICIT)
def test_order_of_convergence(name):
    """The global error falls with the order of the method, within 0.15."""
    tableau = load_tableau(name)
    steps = next(count for order, count in ((2, 1280), (4, 640), (6, 320), (99, 40)) if tableau.order <= order)
    eccentricity = 0.05 if tableau.order > 6 else E  # above round-off
    errors = []
    for count in (steps, 2 * steps):
        t, y, h = 0.0, exact(0.0, eccentricity), 8.0 / count
        for k in range(count):
            y = ExplicitRungeKutta(tableau).attempt(f, t, y, h, f(t, y)).y_new
            t = (k + 1) * h
        errors.append(float(np.abs(y - exact(8.0, eccentricity)).max()))
    assert slope(errors) == pytest.approx(tableau.order, abs=0.15)


@pytest.mark.parametrize("name", EMBEDDED)
def test_estimates_are_of_their_orders(name):
    """Of DOP853's two estimates the first is of order 6 in h, the second of order 4."""
    tableau = load_tableau(name)
    estimates = []
    for h in (0.1, 0.05):
        step = one_step(name, h)
        estimates.append(np.abs(ExplicitRungeKutta(tableau).error(f, 0.3 + h, step)[1]).max(axis=1))
    for row, expected in enumerate({"bs32": [3], "dopri5": [5], "dop853": [6, 4]}[name]):
        assert slope([float(estimate[row]) for estimate in estimates]) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize("name", EMBEDDED)
def test_continuous_extension(name):
    """It joins both ends, and its error within a step is of order 4 (Hermite), 5 and 8 in h."""
    tableau, expected = load_tableau(name), {"bs32": 4, "dopri5": 5, "dop853": 8}[name]
    errors = []
    coarse = 0.25 if expected == 8 else 0.1
    for h in (coarse, coarse / 2):
        step = one_step(name, h)
        stepper = ExplicitRungeKutta(tableau)
        at = stepper.extend(f, stepper.error(f, 0.3 + h, step)[0]).at
        np.testing.assert_allclose(at(0.0), step.y, rtol=1e-15)
        np.testing.assert_allclose(at(1.0), step.y_new, rtol=1e-13)
        middle = [np.abs(at(theta) - exact(0.3 + theta * h)).max() for theta in (0.2, 0.37, 0.5, 0.81)]
        errors.append(float(max(middle)))
    assert slope(errors) == pytest.approx(expected, abs=0.3)


def test_registry_knows_which_methods_estimate_their_error():
    for name in EXPLICIT:
        assert load_tableau(name).embedded == integrators()[name].embedded
    assert EMBEDDED == ["bs32", "dopri5", "dop853"]


def test_two_estimates_are_combined_as_in_dop853():
    """|e5|² / √(|e5|² + 0.01 |e3|²), in units of the tolerance times 1 + |y|: 9 / √(9 + 16) of 3 and 40, at y = 1."""
    y, estimates = np.ones(4), np.array([[3.0], [40.0]]) * np.full(4, 2e-6)
    assert error_norm(estimates, y, np.zeros(4), 1e-6, np.ones(4)) == pytest.approx(9.0 / 5.0, rel=1e-14)
    assert error_norm(estimates[:1], y, np.zeros(4), 1e-6, np.ones(4)) == pytest.approx(3.0, rel=1e-14)


# Where the integrators are stable: the limits that books give, and runs that grow beyond them.

STABLE = ("heun2", "bs32", "rk4", "dopri5", "dop853")


@pytest.mark.parametrize(("name", "limit"), [("bs32", np.sqrt(3.0)), ("rk4", np.sqrt(8.0)), ("heun2", 0.0)])
def test_the_imaginary_axis_is_left_where_hairer_and_wanner_say(name, limit):
    assert reach(load_tableau(name), 1j, slack=1e-9) == pytest.approx(limit, abs=0.02)


@pytest.mark.parametrize("name", STABLE)
@pytest.mark.parametrize("eigenvalue", [-1.0, 1j, -0.3 + 0.7j])
def test_a_step_grows_by_the_stability_function(name, eigenvalue):
    """Of y' = λ y as a real system, in one step of each method."""
    tableau, h = load_tableau(name), 3.0
    matrix = np.array([[eigenvalue.real, -eigenvalue.imag], [eigenvalue.imag, eigenvalue.real]])
    y = np.array([1.0, 0.0])
    stepped = ExplicitRungeKutta(tableau).attempt(lambda t, y: matrix @ y, 0.0, y, h, matrix @ y).y_new
    assert np.linalg.norm(stepped) == pytest.approx(amplification(tableau, h * eigenvalue), rel=1e-12)


@pytest.mark.parametrize("name", STABLE)
def test_within_reach_nothing_grows_and_beyond_it_does(name):
    tableau = load_tableau(name)
    for direction in (-1.0, -0.5 + 0.866j):
        limit = reach(tableau, direction, slack=0.0)
        assert all(amplification(tableau, part * limit * direction) <= 1.0 + 1e-12 for part in np.linspace(0, 1, 50))
        assert amplification(tableau, 1.01 * limit * direction) > 1.0
    assert reach(tableau, -1.0, slack=0.0) == real_axis_limit(tableau)


@pytest.mark.parametrize("name", implicit_integrators())
@pytest.mark.parametrize("size", [1.0, 1e8, 1e20, 1e30])
def test_implicit_methods_are_stable_however_fast_a_mode_is(name, size):
    """Both are L-stable: |R| falls as 1/|z|."""
    tableau = load_implicit_tableau(name)
    for direction in (-1.0, 1j, -0.6 + 0.8j):
        assert amplification(tableau, size * direction) <= min(1.0 + 1e-12, 30.0 / size + 1e-13)


# The implicit methods: order conditions, stiff accuracy, L-stability, estimates and extensions.

IMPLICIT = ("esdirk4", "radau5")
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


@pytest.mark.parametrize("name", IMPLICIT)
def test_order_conditions(name):
    """All trees up to the order are met, and not all of the next; the rows of a sum to c."""
    tableau = load_implicit_tableau(name)
    for order in range(1, tableau.order + 1):
        for weights, density in trees(tableau, order):
            assert tableau.b @ weights == pytest.approx(1.0 / density, abs=2e-16 * 8)
    np.testing.assert_allclose(tableau.a.sum(axis=1), tableau.c, atol=1e-15)
    if tableau.order == 4:
        assert any(abs(tableau.b @ weights - 1.0 / density) > 1e-4 for weights, density in trees(tableau, 5))


@pytest.mark.parametrize("name", IMPLICIT)
def test_estimates_vanish_up_to_their_order(name):
    """The weights of the estimate are those of a difference of two methods, the second of order 3."""
    tableau = load_implicit_tableau(name)
    for order in range(1, tableau.error_order + 1):
        for weights, _ in trees(tableau, order):
            assert tableau.error @ weights == pytest.approx(0.0, abs=1e-15)
    assert any(abs(tableau.error @ weights) > 1e-4 for weights, _ in trees(tableau, tableau.error_order + 1))


@pytest.mark.parametrize("name", IMPLICIT)
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


@pytest.mark.parametrize("name", IMPLICIT)
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
    found = {name: [amplification(load_implicit_tableau(name), z) for z in (1j, 10j, 100j)] for name in IMPLICIT}
    assert found["esdirk4"] == pytest.approx([0.99998, 0.75, 0.09], rel=0.05)
    assert found["radau5"] == pytest.approx([0.9999, 0.32, 0.03], rel=0.05)


def test_only_radau_couples_its_stages():
    assert [bool(np.triu(load_implicit_tableau(name).a, 1).any()) for name in IMPLICIT] == [False, True]


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
