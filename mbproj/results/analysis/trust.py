"""Trust horizons: the first time at which a path's error exceeds a limit, and how uncertain that time is.

The error of a run is not known. What is known is its distance d from a better solution, whose own error is at most u.
So the true error is between d - u and d + u, which gives a range of times.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.base.arrays import Array, Flags
from mbproj.base.dataclass import dataclass
from mbproj.results.record import Results

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


# --- The growth of a path's error -------------------------------------------------------------------------------------
# Exponential, as in chaos, or a power of time, as in regular motion.


#: An error counts where it is above this multiple of its uncertainty, and below this part of the path's extent.
CLEAR, SATURATED = 10.0, 0.1
#: A fit needs this many samples, and growth of the error by this factor over them.
SAMPLES, GROWTH = 10, 10.0
#: The part of the time that is left out at the start, where the error has not yet grown.
ONSET = 0.02
NAN = float("nan")


@dataclass(frozen=True)
class Growth:
    """The fits of e ~ exp(rate t), rate in 1/s, and e ~ t^power to the largest error up to each time. `law` names the
    better fit: "exponential" or "power". It is "" where the error does not grow enough to tell; rate and power are then
    NaN."""

    rate: float = NAN
    power: float = NAN
    law: str = ""


def growth(time: Array, error: Array, uncertainty: Array, extent: float) -> Growth:
    """Fit the growth of an error (T) with its uncertainty (T), in m, at times (T) from 0 on. `extent` is the size of
    the path in m."""
    error = np.maximum.accumulate(np.nan_to_num(error, nan=np.inf))
    uncertainty = np.nan_to_num(uncertainty, nan=np.inf, posinf=np.finfo(float).max / CLEAR)
    clear = (error > CLEAR * uncertainty) & (error > 0.0) & (error < SATURATED * extent)
    clear &= time - time[0] > ONSET * (time[-1] - time[0])
    if np.count_nonzero(clear) < SAMPLES or error[clear][-1] < GROWTH * error[clear][0]:
        return Growth()
    since, logarithm = time[clear] - time[0], np.log(error[clear])
    rate, exponential = _fit(since, logarithm)
    power, algebraic = _fit(np.log(since), logarithm)
    return Growth(rate, power, "exponential" if exponential < algebraic else "power")


def _fit(x: Array, y: Array) -> tuple[float, float]:
    """The slope of the least-squares line y(x), and the sum of squares of its residual."""
    x, y = x - x.mean(), y - y.mean()
    slope = float(x @ y / (x @ x))
    left = y - slope * x
    return slope, float(left @ left)
