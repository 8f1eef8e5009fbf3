"""How long a path can be trusted: the first time at which its error exceeds a limit, with what is not known about it.

The error of a run is not known, only its distance d to a better solution, whose own error is at most u. The truth is
then between d - u and d + u, and so is the time at which it exceeds a limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array, Flags

#: Horizons count as settled where their range is at most this part of them.
SETTLED = 0.05


@dataclass(frozen=True, eq=False)
class Horizons:
    """Times in s by point and limit, (k, E): the first sample at which the distance exceeds the limit, and the first
    at which the true error can (`low`) and at which it must (`high`). Infinite where that does not happen."""

    time: Array
    low: Array
    high: Array


def settled(low: Array, high: Array, time: Array) -> Flags:
    """Which ranges of horizons are narrow, by the interval of the times or by themselves."""
    narrow = np.maximum(SETTLED * high, 1.5 * (time[1] - time[0]))
    with np.errstate(invalid="ignore"):
        near: Flags = (low == high) | (np.isfinite(high) & (high - low <= narrow))
    return near


def horizons(time: Array, distance: Array, uncertainty: Array, limits: Array) -> Horizons:
    """Of distances (T, k) to a better solution with errors (T, k), at times (T), for limits (E), all in m.

    A distance that is not a number is not known."""
    with np.errstate(invalid="ignore"):
        bounds = (distance, np.nan_to_num(distance + uncertainty, nan=np.inf), distance - uncertainty)
    return Horizons(*(np.stack([_first_above(time, bound, limit) for limit in limits], axis=-1) for bound in bounds))


def _first_above(time: Array, values: Array, limit: float) -> Array:
    """For each column of (T, k) the first time with a value above the limit, (k,); infinite without one."""
    beyond = values > limit
    first: Array = np.where(beyond.any(axis=0), time[np.argmax(beyond, axis=0)], np.inf)
    return first
