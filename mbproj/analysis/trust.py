"""How long a path can be trusted: the first time at which its error exceeds a limit, and how uncertain that time is.

The error of a run is not known. Known is its distance d from a better solution, whose own error is at most u. So the
true error is between d - u and d + u, which gives a range of times.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.results import Results

#: Part of the distance that the markers travel which an error must stay below by default.
PART = 1e-3
#: A horizon is settled where its range is at most this part of it.
SETTLED = 0.05


@dataclass(frozen=True, eq=False)
class Horizons:
    """Times in s by point and limit, (k, E): the first sample at which the distance exceeds the limit. `low`: the first
    at which the true error can exceed it. `high`: the first at which it must. Infinite where that does not happen."""

    time: Array
    low: Array
    high: Array


def settled(low: Array, high: Array, time: Array) -> Flags:
    """Which ranges of horizons are narrow, compared with the sampling interval or with the time itself."""
    narrow = np.maximum(SETTLED * high, 1.5 * (time[1] - time[0]))
    with np.errstate(invalid="ignore"):
        near: Flags = (low == high) | (np.isfinite(high) & (high - low <= narrow))
    return near


def horizons(time: Array, distance: Array, uncertainty: Array, limits: Array) -> Horizons:
    """The horizons from distances (T, k) to a better solution with errors (T, k), at times (T), for limits (E), all in
    m. A NaN distance is unknown."""
    with np.errstate(invalid="ignore"):
        bounds = (distance, np.nan_to_num(distance + uncertainty, nan=np.inf), distance - uncertainty)
    return Horizons(*(np.stack([_first_above(time, bound, limit) for limit in limits], axis=-1) for bound in bounds))


def _first_above(time: Array, values: Array, limit: float) -> Array:
    """For each column of (T, k) the first time with a value above the limit, (k,); infinite without one."""
    beyond = values > limit
    first: Array = np.where(beyond.any(axis=0), time[np.argmax(beyond, axis=0)], np.inf)
    return first


def usual_limit(results: Sequence[Results]) -> float:
    """The largest power of ten, in m, that is at most a thousandth of how far the markers, or the bodies, travel."""
    kind = "markers" if results[0].names("markers") else "bodies"
    travel = max(float(np.ptp(result[f"{kind}/position"], axis=0).max(initial=0.0)) for result in results)
    return float(10.0 ** np.floor(np.log10(PART * travel))) if travel > 0.0 else PART
