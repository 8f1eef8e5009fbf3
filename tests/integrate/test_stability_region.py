"""Where the integrators are stable: the limits that books give, and runs that grow beyond them."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.registry import implicit_integrators
from mbproj.motion.steppers.runge_kutta import ExplicitRungeKutta, amplification, reach, real_axis_limit
from mbproj.motion.steppers.tableau import load_implicit_tableau, load_tableau

NAMES = ("heun2", "bs32", "rk4", "dopri5", "dop853")


@pytest.mark.parametrize(("name", "limit"), [("bs32", np.sqrt(3.0)), ("rk4", np.sqrt(8.0)), ("heun2", 0.0)])
def test_the_imaginary_axis_is_left_where_hairer_and_wanner_say(name, limit):
    assert reach(load_tableau(name), 1j, slack=1e-9) == pytest.approx(limit, abs=0.02)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("eigenvalue", [-1.0, 1j, -0.3 + 0.7j])
def test_a_step_grows_by_the_stability_function(name, eigenvalue):
    """Of y' = λ y as a real system, in one step of each method."""
    tableau, h = load_tableau(name), 3.0
    matrix = np.array([[eigenvalue.real, -eigenvalue.imag], [eigenvalue.imag, eigenvalue.real]])
    y = np.array([1.0, 0.0])
    stepped = ExplicitRungeKutta(tableau).attempt(lambda t, y: matrix @ y, 0.0, y, h, matrix @ y).y_new
    assert np.linalg.norm(stepped) == pytest.approx(amplification(tableau, h * eigenvalue), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
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
