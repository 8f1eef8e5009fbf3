"""The comparison of two runs of one mechanism at the sample times that they share."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.results import Results

#: Sample times count as equal where they differ by less than this part of the sampling interval.
SAME_TIME = 1e-6


@dataclass(frozen=True)
class Difference:
    """The distance (S) in m between two paths at the common `time` (S) in s."""

    time: Array
    distance: Array

    @property
    def largest(self) -> float:
        """The largest distance in m; NaN where a path has a NaN."""
        return float(np.max(self.distance))


def common_samples(first: Array, second: Array) -> tuple[Integers, Integers]:
    """Indices (S), (S) of the sample times that two increasing series (s) share. Nothing is interpolated."""
    if len(first) == 0 or len(second) == 0:
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    intervals = np.concatenate([np.diff(first), np.diff(second)])
    tolerance = SAME_TIME * float(np.median(intervals)) if len(intervals) else 0.0
    after = np.minimum(np.searchsorted(second, first), len(second) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(second[after] - first) < np.abs(second[before] - first), after, before)
    shared = np.flatnonzero(np.abs(second[nearest] - first) <= tolerance)
    return shared, nearest[shared]


def trajectory_difference(first: Results, second: Results, marker: str) -> Difference:
    """The distance between the paths of a marker. Raises InputError for an unknown marker, and for results without
    common times."""
    paths = first.marker(marker).position, second.marker(marker).position
    rows = common_samples(first.time, second.time)
    if len(rows[0]) == 0:
        message = f"'{first.path}' and '{second.path}' have no sample time in common"
        raise InputError(Problem(message, hint="run both with the same --output-step"))
    distance = np.linalg.norm(paths[0][rows[0]] - paths[1][rows[1]], axis=1)
    return Difference(first.time[rows[0]], distance)
