"""The double pendulum against Lagrange's equations and against its normal modes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

from tests.mechanisms.running import TIGHT, assert_close, run
from tests.support import DATA


def test_against_lagranges_equations():
    exact = np.genfromtxt(DATA / "double_pendulum.csv", delimiter=",", names=True)
    heavy = {"inertia": "1", "g": "10", "start_upper": "90 deg", "start_lower": "90 deg"}
    done = run("double_pendulum", heavy, **TIGHT, duration=5, output_step=0.5)
    centre = done.column("bodies/position", "lower")
    assert_close(centre[:, 0], exact["x2"], 3e-11)
    assert_close(centre[:, 2], exact["z2"], 3e-11)
    assert_close(centre[:, 1], 0.0, 1e-13)


@pytest.mark.parametrize("mode", [0, 1])
def test_small_swings_are_the_normal_modes(mode):
    """θ = ε u cos ωt with K u = ω² M u; what is left out is of the order ε³."""
    length, mass, g, ε = 0.7, 1.0, 9.81, 1e-4
    M = mass * length**2 * np.array([[4 / 3, 1 / 2], [1 / 2, 1 / 3]])
    K = mass * g * length * np.diag([3 / 2, 1 / 2])
    squares, shapes = eigh(K, M)
    upper, lower = ε * shapes[:, mode] / np.abs(shapes[:, mode]).max()
    start = {"start_upper": repr(float(upper)), "start_lower": repr(float(lower)), "length": "0.7"}
    done = run("double_pendulum", start, integrator="dop853", step=0.02, duration=2, output_step=0.1)
    cosine = np.cos(np.sqrt(squares[mode]) * done["time"])
    first = upper - done.column("joints/coordinate", "A.angle")
    relative = lower - upper - done.column("joints/coordinate", "B.angle")
    assert_close(first, upper * cosine, 20 * ε**3)
    assert_close(relative, (lower - upper) * cosine, 100 * ε**3)
