"""How wrong a solution is, against a reference."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.studies.measure.reference import Reference
from mbproj.studies.measure.solve import Solution


def error(solution: Solution, reference: Reference) -> Array:
    """Distance of each point from the reference, (T, k) in m; infinite after a failure."""
    distance = np.linalg.norm(solution.position - reference.position, axis=2)
    return np.where(np.isnan(distance), np.inf, distance)


def largest_error(distance: Array, times: Array, until: float | None = None) -> Array:
    """The largest of `distance` (T, k) of each point up to the time `until` in s, (k,) in m."""
    rows = slice(None) if until is None else times <= until * (1.0 + 1e-9)
    largest: Array = distance[rows].max(axis=0, initial=0.0)
    return largest
