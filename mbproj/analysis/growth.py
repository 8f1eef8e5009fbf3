"""The growth of a path's error: exponential, as in chaos, or a power of time, as in regular motion."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass

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
