"""Exact motions: of one degree of freedom, and of a heavy top that nods, by integrals of periodic functions.

The time as an integral of 1/φ' over a turn, or over a nod, is that of a periodic function: the trapezoid rule converges
exponentially. What whole turns take is summed in extended precision; what is left of one is a Fourier series.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Array = Any
Real = np.longdouble
PI = np.arccos(Real(-1.0))
#: Points of a turn, and waves of the series.
POINTS, WAVES = 2048, 400


class Series:
    """∫ f dφ from 0, of an f that is periodic in φ with 2π."""

    def __init__(self, f: Array) -> None:
        """`f` (POINTS,) at equal distances."""
        self.mean = np.sum(f) / POINTS
        self.k, self.waves = np.arange(1, WAVES), np.fft.rfft(f.astype(float))[1:WAVES] / POINTS

    def __call__(self, φ: Real) -> Real:
        turned = np.exp(1j * self.k * float(φ % (2 * PI))) - 1.0
        return self.mean * φ + Real(2.0 * np.sum((self.waves * turned / (1j * self.k)).real))


def reached(slowness: Callable[[Array], Array], start: Real, t: float) -> Real:
    """The φ that is reached from `start` after t, where dt/dφ is `slowness`, of period 2π."""
    elapsed = Series(slowness(2.0 * PI * np.arange(POINTS) / POINTS))
    wanted, φ = elapsed(start) + Real(t), start + Real(t) / elapsed.mean
    for _ in range(60):
        φ = φ - (elapsed(φ) - wanted) / slowness(φ)
    return φ


def angle_of(
    inertia: Callable[[Array], Array], potential: Callable[[Array], Array], start: Real, speed: float, t: float
) -> float:
    """Of a mechanism with ½ I φ'² + V = E that goes round."""
    energy = inertia(start) * Real(speed) ** 2 / 2 + potential(start)
    return float(reached(lambda φ: np.sqrt(inertia(φ) / (2 * (energy - potential(φ)))), start, t))


def axis_of_top(A: float, C: float, weight: float, θ: float, rates: tuple[float, float], t: float) -> Array:
    """The axis (3,) of a symmetric top after t. It begins at θ from the vertical with θ' = 0, above the y axis.
    `rates`: those of φ and about the axis. u = cos θ goes between two roots of a cubic (Goldstein, sect. 5.7)."""
    A, C, weight, u0, (precession, axial) = Real(A), Real(C), Real(weight), np.cos(Real(θ)), map(Real, rates)
    along = C * axial
    vertical = A * (1 - u0 * u0) * precession + along * u0
    energy = A * (1 - u0 * u0) * precession**2 / 2 + weight * u0
    # A² u'² / (2 A) = (E - w u) (1 - u²) - (b - a u)² / (2 A): at u0 it is 0; the other roots are those of a quadratic.
    a, b = along, vertical
    cubic = [weight, -energy - a * a / (2 * A), -weight + a * b / A, energy - b * b / (2 * A)]
    p, q = cubic[1] / cubic[0] + u0, cubic[2] / cubic[0] + u0 * (cubic[1] / cubic[0] + u0)
    root = np.sqrt(p * p / 4 - q)
    other, far = -p / 2 - root, -p / 2 + root
    if far < 1:  # u0 may be either end of the nod
        other, far = far, other
    middle, half = (u0 + other) / 2, (u0 - other) / 2
    k = 2 * weight / A

    def u(τ: Array) -> Array:
        return middle + half * np.cos(τ)

    def slowness(τ: Array) -> Array:
        return 1 / np.sqrt(k * (far - u(τ)))

    def turning(τ: Array) -> Array:
        return (b - a * u(τ)) / (A * (1 - u(τ) ** 2)) * slowness(τ)

    τ = reached(slowness, Real(0.0), t)
    φ, end = Series(turning(2.0 * PI * np.arange(POINTS) / POINTS))(τ), u(τ)
    side = np.sqrt(1 - end * end)
    return np.array([-side * np.sin(φ), side * np.cos(φ), end], dtype=float)
