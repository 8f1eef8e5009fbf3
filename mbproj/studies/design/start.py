"""The starts of searches: the scene's own numbers and the best of many points. A design that does not run is moved to
one that runs, by least squares of what it lacks."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from mbproj.arrays import Array, Flags
from mbproj.studies.design.slopes.derivative import Counted, derivative
from mbproj.studies.design.spec import DesignSpec
from mbproj.studies.design.trial import Trial, Wish, tried_by_arrays

#: The number of points tried for each start.
POINTS = 8
#: The least distance of a search's start from a bound, as a part of the range.
INSIDE = 1e-6
#: The most evaluations to move a design to one that runs, and the step of their differences.
EFFORT, STEP = 20, 1e-6


def points_of(spec: DesignSpec) -> tuple[Array, bool]:
    """Return points of Sobol's sequence as shares (n, d), and whether the scene's own numbers come first. They do where
    all are known and within the bounds."""
    count = max(POINTS * spec.starts, 2)
    sampler = qmc.Sobol(len(spec.paths), rng=np.random.default_rng(spec.seed))
    points = sampler.random_base2(int(np.ceil(np.log2(count))))[:count]
    own = (spec.own - spec.low) / (spec.high - spec.low)
    within = bool(np.all((own >= 0.0) & (own <= 1.0)))
    points = np.concatenate([own[None], points]) if within else points
    return np.clip(points, INSIDE, 1.0 - INSIDE), within


def looked_at(wish: Wish, points: Sequence[list[float]]) -> list[list[float]]:
    """Return the ranks of points, lists that are compared entry by entry; smaller is better. A work item."""
    return [_rank(trial) for trial in tried_by_arrays(wish, [np.array(point) for point in points])]


def _rank(trial: Trial) -> list[float]:
    """Designs that run come first; of these, those that keep the constraints."""
    if trial.runs:
        broken = violation(trial)
        return [0.0, broken, value_of(trial)]
    lacking = float(np.linalg.norm(trial.lacking))
    return [1.0, lacking if np.isfinite(lacking) else np.inf, 0.0]


def value_of(trial: Trial) -> float:
    """Return the value to be minimised: half the sum of squares, or the sum of the goals."""
    return trial.cost if len(trial.residuals) else float(trial.goals.sum())


def violation(trial: Trial, equal: Flags | None = None) -> float:
    """Return the root of the sum of squares of the constraints' violations; `equal` (c,) marks those that must be 0."""
    broken = np.minimum(trial.limits, 0.0)
    if equal is not None:
        broken = np.where(equal, trial.limits, broken)
    return float(np.linalg.norm(broken))


def brought_in(trials: Counted, u: Array) -> Array | None:
    """Return a design near u that runs, found by least squares: the violation of its rows, and the part of the duration
    that it does not run. None where none is found."""
    if trials(u).runs:
        return u
    if not np.isfinite(trials(u).lacking).all():
        return None
    poses: list[Array] = []

    def lacking(v: Array) -> Array:
        trial = trials(v)
        if trial.runs:
            poses.append(v.copy())
            raise StopIteration
        values = np.zeros(size)
        known = trial.lacking[: size - 1]
        values[: len(known)], values[-1] = known, 1.0 - trial.reached
        return values

    size, inside = max(len(trials(u).lacking), 2), np.clip(u, INSIDE, 1.0 - INSIDE)
    with suppress(StopIteration, ValueError):  # ValueError where values are NaN
        least_squares(
            lacking,
            inside,
            lambda v: np.nan_to_num(derivative(lacking, v, lacking(v), STEP, central=False)),
            bounds=(0.0, 1.0),
            max_nfev=EFFORT,
        )
    return poses[0] if poses else None
