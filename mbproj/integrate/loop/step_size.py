"""Step-size control: Hairer's error norms, the PI controller, the first step (Hairer, Nørsett & Wanner 1993, II.4)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array, may_overflow
from mbproj.dataclass import dataclass
from mbproj.errors import SimulationError
from mbproj.integrate.steppers.runge_kutta import RightHandSide
from mbproj.thresholds import THRESHOLDS


def error_norm(estimates: Array, y: Array, y_new: Array, tolerance: float, scale: Array) -> float:
    """Return the root mean square of error / (tolerance × (scale + max(|y|, |y_new|))): 1 is just acceptable.

    Of two estimates (DOP853) the first is of higher order. They are combined as in the authors' code: |e5|² /
    sqrt(|e5|² + 0.01 |e3|²).
    """
    weighted = estimates / (tolerance * (scale + np.maximum(np.abs(y), np.abs(y_new))))
    norms = np.sqrt(np.mean(weighted * weighted, axis=1))
    if len(norms) == 1 or norms[0] == 0.0:
        return float(norms[0])
    return float(norms[0] ** 2 / np.hypot(norms[0], 0.1 * norms[1]))


@dataclass(frozen=True)
class StepSizeController:
    """PI controller: h_new = 0.9 h err^(-a) err_old^b with b = 0.2/k, a = 1/k - 0.75 b, k the estimate's order + 1.

    For k = 5 these are the constants of DOPRI5.
    """

    error_order: int
    previous_error: float = THRESHOLDS.least_error_before
    rejected: bool = False

    def after_accepted(self, error: float, h: float) -> tuple[float, StepSizeController]:
        """Return the size of the next step, and the controller for it."""
        k = self.error_order + 1
        integral = 0.2 / k
        reached = max(error, THRESHOLDS.least_error)
        factor = THRESHOLDS.safety * reached ** (0.75 * integral - 1.0 / k) * self.previous_error**integral
        largest = 1.0 if self.rejected else THRESHOLDS.largest_change
        factor = min(max(factor, THRESHOLDS.smallest_change), largest)
        return h * factor, StepSizeController(self.error_order, max(error, THRESHOLDS.least_error_before))

    def after_rejected(self, error: float, h: float) -> tuple[float, StepSizeController]:
        """Return the size to try again with, and the controller for it. An error that is not finite shrinks the step
        most."""
        k = self.error_order + 1
        factor = THRESHOLDS.safety * error ** (0.15 / k - 1.0 / k) if np.isfinite(error) else 0.0
        return h * max(factor, THRESHOLDS.smallest_change), StepSizeController(
            self.error_order, self.previous_error, rejected=True
        )


def _bend(
    f: RightHandSide, t: float, y: Array, slope: Array, h: float, norm: Callable[[Array], float]
) -> tuple[float, float]:
    """Return h, reduced where f overflows, and the norm of the derivative of f along f, by a difference over this h."""
    while True:
        try:
            with may_overflow():
                bend = norm(f(t + h, y + h * slope) - slope) / h
        except SimulationError:
            if h < np.finfo(float).tiny:
                raise
            bend = np.inf
        if np.isfinite(bend) or h < np.finfo(float).tiny:
            return h, bend
        h *= 0.1


def first_step(
    f: RightHandSide, order: int, t: float, y: Array, slope: Array, tolerance: float, scale: Array, longest: float
) -> tuple[float, bool]:
    """Return a first step size from f and an estimate of f', at most `longest` (Hairer's hinit), and whether `longest`
    has limited it.

    The trial step for f' is shortened while f overflows, or has no value, at its end. Raises SimulationError where that
    does not help."""
    weight = tolerance * (scale + np.abs(y))

    def norm(vector: Array) -> float:
        return float(np.sqrt(np.mean((vector / weight) ** 2)))

    size, speed = norm(y), norm(slope)
    wanted = 1e-6 if min(size, speed) <= 1e-5 else 0.01 * size / speed
    h, bend = _bend(f, t, y, slope, min(wanted, longest), norm)
    steepest = max(speed, bend)
    trial = max(1e-6, h * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** (1.0 / (order + 1))
    first = min(100.0 * h, trial)
    return float(min(first, longest)), wanted > longest or first > longest
