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
