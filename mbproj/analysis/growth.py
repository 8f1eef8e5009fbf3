"""How the error of a path grows: exponentially, as in chaos, or as a power of time, as in regular motion."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass

#: An error counts where it is this many times its uncertainty, and below this part of the path's extent.
CLEAR, SATURATED = 10.0, 0.1
#: A fit needs so many samples, and an error that grows by this factor over them.
SAMPLES, GROWTH = 10, 10.0
#: Part of the time that is left out at the start, where the error has no history yet.
ONSET = 0.02
NAN = float("nan")


@dataclass(frozen=True)
class Growth:
    """Fits to the largest error so far, e ~ exp(rate t) with the rate in 1/s and e ~ t^power, and which of them is
    nearer: "exponential", "power", or "" where the error does not grow enough to tell (rate and power are then NaN)."""

    rate: float = NAN
    power: float = NAN
    law: str = ""


def growth(time: Array, error: Array, uncertainty: Array, extent: float) -> Growth:
    """The growth of an error (T) with its uncertainty (T), in m, at times (T) that begin at 0. `extent`: the size of
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
    """The slope of the straight line nearest to y(x), and the sum of squares that it leaves."""
    x, y = x - x.mean(), y - y.mean()
    slope = float(x @ y / (x @ x))
    left = y - slope * x
    return slope, float(left @ left)
