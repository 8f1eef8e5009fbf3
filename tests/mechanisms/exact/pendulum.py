"""The large swing of a bar by Jacobi's elliptic functions."""

from __future__ import annotations

import numpy as np
from scipy.special import ellipj, ellipk


def physical_angle(t: np.ndarray) -> np.ndarray:
    """sin(φ/2) = k sn(K + ω t | k²) for a bar of 1 m released at 120°: ω² = m g a / (J + m a²) = 3 g / 2."""
    k = np.sin(np.radians(60.0))
    sn, _, _, _ = ellipj(ellipk(k**2) + np.sqrt(1.5 * 9.81) * t, k**2)
    return 2.0 * np.arcsin(k * sn)
