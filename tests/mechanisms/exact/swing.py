"""A pendulum that swings wide, by Jacobi's elliptic functions."""

from __future__ import annotations

import numpy as np
from scipy.special import ellipj, ellipk


def swinging(amplitude: float, frequency: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """φ and φ' of a pendulum that starts from rest at this amplitude; `frequency` is that of small swings."""
    k = np.sin(amplitude / 2)
    quarter = ellipk(k * k)
    sn, cn, dn, _ = ellipj(quarter + frequency * t, k * k)
    return 2 * np.arcsin(k * sn), 2 * k * frequency * cn * dn / np.sqrt(1 - (k * sn) ** 2)
