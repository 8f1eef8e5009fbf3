"""One explicit Runge-Kutta step, its error estimate, and its continuous extension, for y' = f(t, y)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array, may_overflow
from mbproj.integrate.steppers.tableau import Tableau

RightHandSide = Callable[[float, Array], Array]


@dataclass(frozen=True, eq=False)
class Step:
    """A step from (t, y) over h to `y_new` (N,), with its stages k (s, N)."""

    t: float
    h: float
    y: Array
    y_new: Array
    k: Array


def rk_step(f: RightHandSide, tableau: Tableau, t: float, y: Array, h: float, first: Array) -> Step:
    """One step of size h; `first` is f(t, y)."""
    k = np.empty((tableau.stages, len(y)))
    k[0] = first
    with may_overflow():
        for stage in range(1, tableau.stages):
            k[stage] = f(t + tableau.c[stage] * h, y + h * (tableau.a[stage, :stage] @ k[:stage]))
        return Step(t, h, y, y + h * (tableau.b @ k), k)


def error_estimates(tableau: Tableau, step: Step, last: Array) -> Array:
    """The estimates of the local error, (e, N); `last` is f at the new point."""
    return step.h * (tableau.error[:, :-1] @ step.k + tableau.error[:, -1:] * last)


def continuous_extension(f: RightHandSide, tableau: Tableau, step: Step, last: Array) -> Callable[[float], Array]:
    """y(t + θh) as a function of θ in [0, 1]; `last` is f at the new point. May evaluate f for its extra stages."""
    k = np.concatenate([step.k, last[None]])
    for row, c in zip(tableau.extra_a, tableau.extra_c, strict=True):
        k = np.concatenate([k, f(step.t + c * step.h, step.y + step.h * (row[: len(k)] @ k))[None]])
    slopes = tableau.dense.T @ k

    def at(theta: float) -> Array:
        total = np.zeros_like(step.y)
        for slope in slopes[::-1]:
            total = theta * (slope + total)
        return step.y + step.h * total

    return at
