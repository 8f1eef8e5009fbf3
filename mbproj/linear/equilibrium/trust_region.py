"""Steps towards an equilibrium that are no longer than a radius (Conn, Gould and Toint 2000, ch. 7)."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.thresholds import THRESHOLDS


def downhill(residual: Array, K: Array, sizes: Array, radius: float, floor: float) -> tuple[Array, float]:
    """Return the step within the radius with the largest work of the model rᵀη - ½ ηᵀKη, and that work. Directions
    without stiffness, whose force is no more than `floor`, do not move."""
    κ, V = np.linalg.eigh(0.5 * (K + K.T))
    r = V.T @ residual
    size = np.einsum("ik,ij,jk->k", np.abs(V), sizes, np.abs(V), optimize=True)
    neutral = (np.abs(κ) <= THRESHOLDS.rounding * size) & (np.abs(r) <= floor)
    κ, r, V = κ[~neutral], r[~neutral], V[:, ~neutral]
    if not len(κ):
        return np.zeros_like(residual), 0.0
    shift = _shift(κ, r, radius)
    parts = r / (κ + shift)
    return V @ parts, float(r @ parts - 0.5 * parts @ (κ * parts))


def _shift(κ: Array, r: Array, radius: float) -> float:
    """Return the smallest μ ≥ 0 with all κ + μ > 0 and |r / (κ + μ)| ≤ radius."""
    least = max(0.0, -float(κ.min()))
    grain = np.finfo(float).eps * max(float(np.abs(κ).max()), np.finfo(float).tiny)

    def length(shift: float) -> float:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return float(np.linalg.norm(np.where(r == 0.0, 0.0, r / (κ + shift))))

    low = least + grain if κ.min() <= grain else 0.0
    if length(low) <= radius:
        return low
    high = least + float(np.linalg.norm(r)) / radius + grain
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if length(middle) > radius else (low, middle)
    return high


def towards_balance(residual: Array, K: Array, damping: float) -> Array:
    """Return the step that minimises |r - Kη|² + damping² |η|² (Levenberg)."""
    f = len(residual)
    stacked = np.concatenate([K, damping * np.eye(f)])
    right = np.concatenate([residual, np.zeros(f)])
    return np.asarray(np.linalg.lstsq(stacked, right, rcond=None)[0], dtype=float)
