"""One-sided conditions: the smallest change x with N x + b >= 0, and the pushes z >= 0 that cause it, x = Nᵀz.

With x in coordinates in which the kinetic energy is ½|x|², this is the linear complementarity problem of impacts and of
contact, NNᵀz + b >= 0, z >= 0, zᵀ(NNᵀz + b) = 0. It is solved as a least distance problem by non-negative least squares
(Lawson & Hanson 1974, ch. 23): no regularisation, and rows may depend on each other. x is unique; where rows depend on
each other several z may give it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array
from mbproj.thresholds import THRESHOLDS

#: The most exchanges per unknown.
MOST_EXCHANGES = 20


def one_sided(N: Array, b: Array) -> Array | None:
    """Return z (k,) for rows N (k, f) and b (k,); None where no x meets all conditions."""
    size = np.linalg.norm(N, axis=1)
    able = size > THRESHOLDS.no_push * size.max(initial=0.0)
    deepest = float(np.max(-b, initial=0.0))
    if deepest == 0.0:
        return np.zeros(len(b))
    if not able.any() or (-b[~able] > THRESHOLDS.no_push * deepest).any():
        return None
    length = np.where(able, size, 1.0)
    unit, wanted = np.where(able[:, None], N, 0.0) / length[:, None], -b / length
    scale = float(np.abs(wanted[able]).max())
    E = np.vstack([unit.T, wanted / scale])
    goal = np.zeros(len(E))
    goal[-1] = 1.0
    u = non_negative(E, goal)
    if (goal - E @ u)[-1] <= THRESHOLDS.no_push:
        return None
    return _polished(unit, wanted, u > 0.0) / length


def _polished(unit: Array, wanted: Array, pressing: npt.NDArray[np.bool_]) -> Array:
    """Return the pushes of the `pressing` rows to round-off: their conditions hold as equations."""
    rows, z = unit[pressing], np.zeros(len(wanted))
    z[pressing] = np.maximum(np.linalg.lstsq(rows @ rows.T, wanted[pressing], rcond=THRESHOLDS.no_push)[0], 0.0)
    return z


def non_negative(E: Array, goal: Array) -> Array:
    """Return the u >= 0 with the least |E u - goal| (Lawson & Hanson 1974, algorithm NNLS)."""
    k = E.shape[1]
    u, free = np.zeros(k), np.zeros(k, dtype=bool)
    for _ in range(MOST_EXCHANGES * k):
        slope = E.T @ (goal - E @ u)
        slope[free] = -np.inf
        best = int(np.argmax(slope))
        if slope[best] <= THRESHOLDS.no_push:
            break
        free[best] = True
        while True:
            trial = np.zeros(k)
            trial[free] = np.linalg.lstsq(E[:, free], goal, rcond=None)[0]
            back = free & (trial <= 0.0)
            if not back.any():
                break
            way = u[back] / np.maximum(u[back] - trial[back], np.finfo(float).tiny)
            u = u + float(way.min()) * (trial - u)
            free &= u > THRESHOLDS.no_push * float(u.max())
            u[~free] = 0.0
        u = trial
    return u
