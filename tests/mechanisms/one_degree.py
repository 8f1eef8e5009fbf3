"""The exact motion of a mechanism of one degree of freedom from its kinematics and energy alone."""

from __future__ import annotations

from collections.abc import Callable

from scipy.integrate import quad
from scipy.optimize import brentq

#: Of the coordinate: effective moment of inertia I, and potential energy V.
Of = Callable[[float], float]


def time_to_reach(angle: float, start: float, speed: float, moment: Of, potential: Of) -> float:
    """The time at which the coordinate gets from `start`, at `speed` > 0, to `angle` without stopping:

    ½ I(φ) φ'² + V(φ) = E, so t = ∫ dφ / φ'.
    """
    energy = 0.5 * moment(start) * speed**2 + potential(start)
    rate = lambda φ: (2.0 * (energy - potential(φ)) / moment(φ)) ** 0.5  # noqa: E731
    return float(quad(lambda φ: 1.0 / rate(φ), start, angle, epsabs=1e-13, epsrel=1e-13, limit=200)[0])


def reached_at(time: float, most: float, start: float, speed: float, moment: Of, potential: Of) -> float:
    """The coordinate at a time, which is below `most`: `time_to_reach` solved for the angle."""
    return float(brentq(lambda φ: time_to_reach(φ, start, speed, moment, potential) - time, start, most, xtol=1e-13))
