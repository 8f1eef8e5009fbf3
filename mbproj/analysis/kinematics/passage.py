"""The first passage of a joint coordinate through a value, and the value of curves there. Both use polynomials through
neighbouring samples, which do not cross an event."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.results.loads.between_samples import between
from mbproj.scene.records import Passage

BISECTIONS = 60
#: A sample counts as at the value where it differs by at most this part of the largest value.
AT = 1e-12
TURN = 2.0 * np.pi


def passed(passage: Passage, time: Array, coordinate: Array, events: Array) -> float | None:
    """The time at which the coordinate (T,) first has the value, angles modulo a turn; None where it never has it."""
    turn = TURN if passage.unit == "rad" else np.inf
    apart = coordinate - passage.value
    whole = np.zeros_like(apart) if np.isinf(turn) else turn * np.round(apart / turn)
    size = max(float(np.abs(coordinate).max(initial=0.0)), abs(passage.value), 1e-300)
    met = np.flatnonzero(np.abs(apart - whole) <= AT * size)
    side = (apart > 0.0).astype(float) if np.isinf(turn) else np.floor(apart / turn)
    crossed = np.flatnonzero(side[1:] != side[:-1])
    first = [int(met[0])] if len(met) else []
    if len(crossed) and (not first or crossed[0] + 1 < first[0]):
        before = int(crossed[0])
        target = passage.value + (0.0 if np.isinf(turn) else turn * max(side[before], side[before + 1]))
        return _root(time, coordinate - target, before, events)
    return float(time[first[0]]) if first else None


def _root(time: Array, values: Array, before: int, events: Array) -> float:
    """The time of the sign change after the sample `before`, on the polynomial through neighbouring samples."""
    low, high = float(time[before]), float(time[before + 1])
    sign = values[before] > 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if (curves_at(time, values[:, None], middle, events)[0] > 0.0) == sign:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def curves_at(time: Array, values: Array, when: float, events: Array) -> Array:
    """The values (k,) of curves (T, k) at a time `when` between two samples."""
    return between(time, values, events, np.array([when]))[0]
