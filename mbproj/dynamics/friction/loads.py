"""The loads of bearings whose friction is part of what they carry.

The multipliers are linear in the forces. With the response of each bearing to each friction the loads L are the
solution of as many equations, L = load(f₀ + Σ L f), by Newton's method. Where friction is so strong that a load may
grow by more than itself there is no solution, or there are two (Painlevé 1895).
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.observe.bearings import Supports, load, slopes
from mbproj.model.bearings import Bearings
from mbproj.thresholds import THRESHOLDS


class Jammed(Exception):
    """No unique loads: the number of the bearing whose friction is strongest."""

    def __init__(self, bearing: int) -> None:
        super().__init__(f"bearing {bearing} jams")
        self.bearing = bearing


def settled_loads(bearings: Bearings, base: Supports, responses: Supports) -> Array:
    """L (B,) from the supports without friction, (B, 3), and the responses to the friction of each bearing with a load
    of 1, (B, B, 3), first axis: whose friction. Raises Jammed."""
    _refuse_jammed(bearings, base, responses)
    L = np.zeros(bearings.size)
    for _ in range(THRESHOLDS.most_passes):
        at = base.plus(responses, L)
        left = np.eye(bearings.size) - slopes(bearings, at, responses)
        change = np.linalg.solve(left, L - load(bearings, at))
        L = L - change
        if np.abs(change).max() <= THRESHOLDS.no_digits * np.abs(L).max():
            break
    return L


def _refuse_jammed(bearings: Bearings, base: Supports, responses: Supports) -> None:
    """Raises Jammed unless the loads have a unique solution. What pushes and never pulls may shrink by any part."""
    largest = (load(bearings, responses) - bearings.preload).T
    pushing = np.maximum(slopes(bearings, base, responses), 0.0)
    growth = np.where(bearings.is_push[:, None], pushing, largest)
    if not grows_bounded(growth):
        raise Jammed(int(np.argmax(np.diagonal(growth))))


def grows_bounded(growth: Array) -> bool:
    """Whether no loads grow by more than themselves, where each grows with each other one by `growth` (B, B) at most:
    (I - growth) x = 1 has a positive solution then, and only then."""
    try:
        x = np.linalg.solve(np.eye(len(growth)) - growth, np.ones(len(growth)))
    except np.linalg.LinAlgError:
        return False
    return bool((x > 0.0).all())
