"""Trust horizons: the first time at which a path's error exceeds a limit, and how uncertain that time is.

The error of a run is not known. What is known is its distance d from a better solution, whose own error is at most u.
So the true error is between d - u and d + u, which gives a range of times.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.results import Results

#: The default limit of an error, as a part of the distance that the markers travel.
PART = 1e-3
#: A horizon is settled where its range is at most this part of it.
SETTLED = 0.05


@dataclass(frozen=True, eq=False)
class Horizons:
    """Times in s by point and limit, (k, E). `time` is the first sample at which the distance exceeds the limit. `low`
    is the first at which the true error can exceed it, `high` the first at which it must. They are infinite where that
    does not happen."""

    time: Array
    low: Array
    high: Array


def settled(low: Array, high: Array, time: Array) -> Flags:
    """Mark the horizons whose range is narrow, compared with the sampling interval or with the time itself."""
    narrow = np.maximum(SETTLED * high, 1.5 * (time[1] - time[0]))
    with np.errstate(invalid="ignore"):
        near: Flags = (low == high) | (np.isfinite(high) & (high - low <= narrow))
    return near


def horizons(time: Array, distance: Array, uncertainty: Array, limits: Array) -> Horizons:
    """The horizons for `limits` (E) from the distances (T, k) to a better solution with errors (T, k), at times (T);
    lengths in m. A NaN distance is unknown."""
    with np.errstate(invalid="ignore"):
        bounds = (distance, np.nan_to_num(distance + uncertainty, nan=np.inf), distance - uncertainty)
    return Horizons(*(np.stack([_first_above(time, bound, limit) for limit in limits], axis=-1) for bound in bounds))


def _first_above(time: Array, values: Array, limit: float) -> Array:
    """The first time at which each column of (T, k) is above the limit, (k,); infinite where it never is."""
    beyond = values > limit
    first: Array = np.where(beyond.any(axis=0), time[np.argmax(beyond, axis=0)], np.inf)
    return first


def usual_limit(results: Sequence[Results]) -> float:
    """The largest power of ten, in m, that is at most a thousandth of the distance that the markers, or the bodies,
    travel."""
    kind = "markers" if results[0].names("markers") else "bodies"
    travel = max(float(np.ptp(result[f"{kind}/position"], axis=0).max(initial=0.0)) for result in results)
    return float(10.0 ** np.floor(np.log10(PART * travel))) if travel > 0.0 else PART
