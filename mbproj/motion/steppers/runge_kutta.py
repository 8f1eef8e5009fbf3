"""Explicit Runge-Kutta steps for y' = f(t, y), their error estimates and continuous extensions: the first stepper.

A stepper has {attempt, error, extend, at} and states their cost. The time loop knows no more of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from mbproj.base.arrays import Array, may_overflow
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.motion.steppers.tableau import ImplicitTableau, Tableau

RightHandSide = Callable[[float, Array], Array]


@dataclass(frozen=True, eq=False)
class Step:
    """A step from (t, y) over h to `y_new` (N,), with its stages k (s, N), and f at the new point, `last`, where its
    error was estimated."""

    t: float
    h: float
    y: Array
    y_new: Array
    k: Array
    last: Array | None = None


@dataclass(frozen=True, eq=False)
class Extension:
    """The continuous extension of a step, by the coefficients of θ, θ², … (d, N)."""

    step: Step
    slopes: Array

    def at(self, theta: float) -> Array:
        """Return y(t + θh), θ in [0, 1]."""
        total = np.zeros_like(self.step.y)
        for slope in self.slopes[::-1]:
            total = theta * (slope + total)
        return self.step.y + self.step.h * total


@dataclass(frozen=True, eq=False)
class ExplicitRungeKutta:
    """An explicit method with its tableau. `*_cost`: evaluations of f beyond the first, which the step before has
    made."""

    tableau: Tableau
    error_cost = 1

    @property
    def order(self) -> int:
        return self.tableau.order

    @property
    def error_order(self) -> int:
        return self.tableau.error_order

    @property
    def attempt_cost(self) -> int:
        return self.tableau.stages - 1

    @property
    def extend_cost(self) -> int:
        return len(self.tableau.extra_c)

    def attempt(self, f: RightHandSide, t: float, y: Array, h: float, first: Array) -> Step:
        """Return a step of size h; `first` is f(t, y)."""
        tableau = self.tableau
        k = np.empty((tableau.stages, len(y)))
        k[0] = first
        with may_overflow():
            for stage in range(1, tableau.stages):
                k[stage] = f(t + tableau.c[stage] * h, y + h * (tableau.a[stage, :stage] @ k[:stage]))
            return Step(t, h, y, y + h * (tableau.b @ k), k)

    def error(self, f: RightHandSide, t: float, step: Step) -> tuple[Step, Array]:
        """Return the step to t with f at its end, and the estimates of its local error, (e, N)."""
        last, weights = f(t, step.y_new), self.tableau.error
        return replace(step, last=last), step.h * (weights[:, :-1] @ step.k + weights[:, -1:] * last)

    def extend(self, f: RightHandSide, step: Step) -> Extension:
        """Return the continuous extension of a step whose error was estimated."""
        tableau = self.tableau
        assert step.last is not None
        k = np.concatenate([step.k, step.last[None]])
        for row, c in zip(tableau.extra_a, tableau.extra_c, strict=True):
            k = np.concatenate([k, f(step.t + c * step.h, step.y + step.h * (row[: len(k)] @ k))[None]])
        return Extension(step, tableau.dense.T @ k)

    def quadrature(self, step: Step) -> Iterator[tuple[float, Array]]:
        """The points at which a step has evaluated f, with the weights of its quadrature."""
        a, b = self.tableau.a, self.tableau.b
        for stage in np.flatnonzero(b):
            yield float(b[stage]), step.y + step.h * (a[stage, :stage] @ step.k[:stage])


# --- The stability region of a Runge-Kutta method ---------------------------------------------------------------------
# |R(z)| <= 1 at z = h λ. The stability function R(z) = 1 + z bᵀ(I - zA)⁻¹1 is a polynomial for an explicit method
# (Hairer & Wanner 1996, sect. IV.2 and IV.3).


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
