"""The loads of bearings, where friction is proportional to the load and is part of the load.

The multipliers are linear in the forces. f₀ are the supports without friction, f the response to the friction of each
bearing. Newton's method solves L = load(f₀ + Σ L f) for the loads L. Where friction is so strong that a load may grow
by more than itself, there is no solution, or there are two (Painlevé 1895).
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.observe.bearings import Supports, load, slopes
from mbproj.model.bearings import Bearings
from mbproj.thresholds import THRESHOLDS


class Jammed(Exception):
    """The loads are not unique. `bearing`: the number of the bearing whose friction is strongest."""

    def __init__(self, bearing: int) -> None:
        super().__init__(f"bearing {bearing} jams")
        self.bearing = bearing


def settled_loads(bearings: Bearings, base: Supports, responses: Supports) -> Array:
    """The loads L (B,) of the bearings. Raises Jammed.

    `base` (B, 3) are the supports without friction. `responses` (B, B, 3) are those to the friction of one bearing
    under a load of 1; the first axis counts the bearing with this friction."""
    _refuse_jammed(bearings, base, responses)
    L = np.zeros(bearings.size)
    for _ in range(THRESHOLDS.most_passes):
        loaded = base.plus(responses, L)
        jacobian = np.eye(bearings.size) - slopes(bearings, loaded, responses)
        change = np.linalg.solve(jacobian, L - load(bearings, loaded))
        L = L - change
        if np.abs(change).max() <= THRESHOLDS.no_digits * np.abs(L).max():
            break
    return L


def _refuse_jammed(bearings: Bearings, base: Supports, responses: Supports) -> None:
    """Raises Jammed unless the loads have a unique solution. The load of a one-sided bearing may shrink by any amount:
    only its growth counts."""
    largest = (load(bearings, responses) - bearings.preload).T
    pushing = np.maximum(slopes(bearings, base, responses), 0.0)
    growth = np.where(bearings.is_push[:, None], pushing, largest)
    if not grows_bounded(growth):
        raise Jammed(int(np.argmax(np.diagonal(growth))))


def grows_bounded(growth: Array) -> bool:
    """Whether no loads grow by more than themselves. `growth` (B, B) is the most by which each load grows with each
    other one. The answer is yes where (I - growth) x = 1 has a positive solution, and only there."""
    try:
        x = np.linalg.solve(np.eye(len(growth)) - growth, np.ones(len(growth)))
    except np.linalg.LinAlgError:
        return False
    return bool((x > 0.0).all())
