"""Every tableau: order conditions, orders of the step, the estimate and the extension on a nonlinear equation."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.registry import explicit_integrators, integrators
from mbproj.motion.numpy_loop import error_norm
from mbproj.motion.steppers.runge_kutta import ExplicitRungeKutta
from mbproj.motion.steppers.tableau import load_tableau

NAMES = explicit_integrators()
EMBEDDED = [name for name in NAMES if integrators()[name].embedded]


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


@pytest.mark.parametrize("name", NAMES)
def test_quadrature_conditions(name):
    """Σ b_i c_i^k = 1/(k+1) up to the order, and the rows of a sum to c."""
    tableau = load_tableau(name)
    for power in range(tableau.order):
        assert tableau.b @ tableau.c**power == pytest.approx(1.0 / (power + 1), abs=4e-15)
    np.testing.assert_allclose(tableau.a.sum(axis=1), tableau.c, atol=4e-15)


@pytest.mark.parametrize("name", NAMES)
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
    for name in NAMES:
        assert load_tableau(name).embedded == integrators()[name].embedded
    assert EMBEDDED == ["bs32", "dopri5", "dop853"]


def test_two_estimates_are_combined_as_in_dop853():
    """|e5|² / √(|e5|² + 0.01 |e3|²), in units of the tolerance times 1 + |y|: 9 / √(9 + 16) of 3 and 40, at y = 1."""
    y, estimates = np.ones(4), np.array([[3.0], [40.0]]) * np.full(4, 2e-6)
    assert error_norm(estimates, y, np.zeros(4), 1e-6, np.ones(4)) == pytest.approx(9.0 / 5.0, rel=1e-14)
    assert error_norm(estimates[:1], y, np.zeros(4), 1e-6, np.ones(4)) == pytest.approx(3.0, rel=1e-14)
