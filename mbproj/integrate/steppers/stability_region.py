"""The stability region of a Runge-Kutta method: |R(z)| <= 1 at z = h λ. The stability function R(z) = 1 + z bᵀ(I -
zA)⁻¹1 is a polynomial for an explicit method (Hairer & Wanner 1996, sect. IV.2 and IV.3)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau
from mbproj.integrate.steppers.tableau import Tableau
from mbproj.thresholds import THRESHOLDS

#: The largest |z| that is scanned, the step of the scan, and the number of halvings at the boundary.
FARTHEST, SCAN, HALVINGS = 20.0, 5e-3, 50


@cache
def stability_function(tableau: Tableau) -> Callable[[Any], Any]:
    """Return R of an explicit method, for one z or several."""
    coefficients, powers = [1.0], np.ones(tableau.stages)
    for _ in range(tableau.stages):
        coefficients.append(float(tableau.b @ powers))
        powers = tableau.a @ powers
    return np.polynomial.Polynomial(coefficients)


def amplification(tableau: Tableau | ImplicitTableau, z: complex) -> float:
    """Return |R(z)|, the growth of a mode in a step, where z = h λ."""
    if isinstance(tableau, ImplicitTableau):
        stages = np.linalg.solve(np.eye(tableau.stages) - z * tableau.a, np.ones(tableau.stages))
        return float(abs(stages[-1]))  # the end of the step: 1 + z bᵀ(...) would lose all digits at large |z|
    with np.errstate(over="ignore", invalid="ignore"):  # far outside it may overflow
        return float(np.nan_to_num(np.abs(stability_function(tableau)(np.complex128(z))), nan=np.inf))


@cache
def reach(tableau: Tableau | ImplicitTableau, direction: complex, slack: float = THRESHOLDS.stalled) -> float:
    """Return the largest r up to which |R(r direction)| <= 1 + slack, for a direction of size 1 that does not grow. It
    is infinite for implicit methods, which are A-stable."""
    if isinstance(tableau, ImplicitTableau):
        return float("inf")
    R = stability_function(tableau)
    r = np.arange(SCAN, FARTHEST, SCAN)
    high = float(r[int(np.argmax(np.abs(R(r * direction)) > 1.0 + slack))])
    low = high - SCAN
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if abs(R(middle * direction)) > 1.0 + slack else (middle, high)
    return low


def real_axis_limit(tableau: Tableau | ImplicitTableau) -> float:
    """Return the largest x up to which |R(-x)| <= 1."""
    return reach(tableau, -1.0, slack=0.0)
