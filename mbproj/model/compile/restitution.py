"""The resistance of a compliant stop that gives it a wanted coefficient of restitution.

A mass m meets F = k δᵖ (1 + d w), w = δ' / √(δ'² + κ 2V/m), V = k δᵖ⁺¹ / (p + 1), and loses energy by w alone. Let σ² =
δ'² / (δ'² + 2V/m) be the part of the energy E that is kinetic. Then w = σ / √(σ² + κ (1 - σ²)), and E changes by d(ln
E)/dσ = 2 d w σ / (1 + d w (1 - σ²)) while σ goes from 1 through 0 to -1. So the restitution

    ln e = - ∫ d w σ / (1 + d w (1 - σ²)) dσ   from -1 to 1

is the same at every speed and for every k, p and m. At rest w = 0, and the stop has its stiffness. It never pulls,
because d ≤ 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from mbproj.arrays import Array

#: Nodes of the quadrature in ln σ.
NODES = 400
#: Below this restitution e, κ = 8 e⁴ with a relative error of 5e-12.
SMALL = 1e-6
TINY = float(np.finfo(float).tiny)
#: The quadrature begins this far, in ln σ, below the scales of the integrand, which are 1 and κ^(1/2).
BELOW = 16


@lru_cache(maxsize=256)
def resistance(e: float) -> tuple[float, float]:
    """Return d and κ of a stop with restitution e, 0 < e <= 1: κ = 1 as long as d <= 1 suffices, else d = 1."""
    if e == 1.0:
        return 0.0, 1.0
    wanted = -math.log(e)
    if wanted <= _lost(1.0, 1.0):
        return _solve(lambda d: _lost(d, 1.0) - wanted, 0.0, 1.0), 1.0
    if e < SMALL:
        return 1.0, max(8.0 * e**4, TINY)
    return 1.0, math.exp(_solve(lambda x: wanted - _lost(1.0, math.exp(x)), -4.0 * wanted, 0.0))


def _lost(d: float, kappa: float) -> float:
    """Return -ln e of a stop with d and κ. The integrand sums approach and departure at each σ > 0."""
    x, weight = _quadrature()
    least = 0.5 * math.log(kappa) - BELOW
    sigma = np.exp(0.5 * least * (1.0 - x))
    elastic = 1.0 - sigma**2
    root = np.sqrt(sigma**2 + kappa * elastic)
    # root - d σ (1 - σ²), without cancellation
    kept = kappa * elastic / (root + sigma) + (1.0 - d) * sigma + d * sigma**3
    rate = d * sigma**2 * (1.0 / kept + 1.0 / (root + d * sigma * elastic))
    return float(-0.5 * least * (weight @ (rate * sigma)))


@lru_cache(maxsize=1)
def _quadrature() -> tuple[Array, Array]:
    """Return the Gauss-Legendre nodes and weights on -1 … 1."""
    return np.polynomial.legendre.leggauss(NODES)


def _solve(rising: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of a rising function, by bisection to round-off."""
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if rising(middle) < 0.0 else (low, middle)
    return middle
