"""A free body's angular velocity by Jacobi's elliptic functions."""

from __future__ import annotations

import numpy as np
from scipy.special import ellipj, ellipk


def racket_rates(moments, start, t):
    """ω (T, 3) in body axes for A < B < C and ω(0) = (p, q, 0) with L² < 2EB: ω = (a dn, b sn, c cn)(n t + K | m).

    n² = (B - A)(2EC - L²)/(ABC), m = (C - B)(L² - 2EA)/((B - A)(2EC - L²)): Landau's solution, A and C exchanged.
    """
    A, B, C = moments
    energy2 = A * start[0] ** 2 + B * start[1] ** 2
    momentum2 = (A * start[0]) ** 2 + (B * start[1]) ** 2
    n = np.sqrt((B - A) * (energy2 * C - momentum2) / (A * B * C))
    m = (C - B) * (momentum2 - energy2 * A) / ((B - A) * (energy2 * C - momentum2))
    sn, cn, dn, _ = ellipj(n * t + ellipk(m), m)
    a = np.sqrt((energy2 * C - momentum2) / (A * (C - A)))
    b = np.sqrt((momentum2 - energy2 * A) / (B * (B - A)))
    c = np.sqrt((momentum2 - energy2 * A) / (C * (C - A)))
    return np.stack([a * dn, b * sn, c * cn], axis=-1), 2.0 * ellipk(m) / n
