"""The times at which functions of time are sampled: evenly spaced, and ever closer to the zeros of their intermediate
values. Narrow features lie there: the peak of exp(-((t - 1)/1e-4)²), the pulse max(0, 1 - abs(t - 1)/1e-4)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from mbproj.arrays import Array
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.series import time_series, walk
from mbproj.thresholds import THRESHOLDS

#: The golden ratio: the first window is this part of an output step, so that windows end where functions rarely have a
#: feature.
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


def look_windows(start: float, end: float, output_step: float) -> Iterator[tuple[float, float]]:
    """Yield the windows in which functions are sampled, one after another, until one reaches `end`, in s. They double,
    and do not depend on the end: a longer run has the same windows at first. `output_step` is the time between two
    samples, in s."""
    low, length = start, GOLDEN * output_step
    while low < end:
        high = start + length
        if high > low:
            yield low, high
            low = high
        length *= 2.0


@lru_cache(maxsize=8)
def look_times(programs: ProgramSet, index: int, start: float, end: float) -> Array:
    """Return the times, in order, at which program `index`, a function of time alone, is sampled. The array is shared:
    nobody may write to it."""
    even = np.linspace(start, end, THRESHOLDS.look_intervals + 1)
    zeros = _zeros(programs, index, even)
    if not len(zeros):
        return even
    near = (even[1] - even[0]) * 0.5 ** np.arange(-np.log2(THRESHOLDS.rounding))
    closer = np.add.outer(zeros, np.concatenate([-near, near])).ravel()
    return np.unique(np.concatenate([even, closer[(closer > start) & (closer < end)]]))


def _zeros(programs: ProgramSet, index: int, times: Array) -> Array:
    """Return the zeros of the values that the program computes on its way, by linear interpolation."""
    parts = [np.zeros(0)]
    with np.errstate(all="ignore"):
        for _, stack in walk(programs, index, [time_series(times)]):
            if not stack:
                continue
            x = np.broadcast_to(stack[-1][0], times.shape)
            at = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0) | (x[:-1] > 0.0) & (x[1:] <= 0.0))
            if len(at) <= THRESHOLDS.most_kinks:
                parts.append(times[at] - x[at] * (times[at + 1] - times[at]) / (x[at + 1] - x[at]))
    zeros = np.concatenate(parts)
    return np.unique(zeros[np.isfinite(zeros)])
