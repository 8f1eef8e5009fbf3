"""Where searches begin: the scene's own numbers and the best of many points; designs that do not run are brought there
by what they lack."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from mbproj.arrays import Array, Flags
from mbproj.studies.design.slopes.derivative import Counted, derivative
from mbproj.studies.design.spec import DesignSpec
from mbproj.studies.design.trial import Trial, Wish, tried_together

#: Points that are tried for each start.
POINTS = 8
#: Searches begin at least so far from a bound, in parts of the range.
INSIDE = 1e-6
#: Runs to bring one design to where it runs: so many for each number, and the step of their differences.
EFFORT, STEP = 20, 1e-6


def points_of(spec: DesignSpec) -> tuple[Array, bool]:
    """Points of the box as shares (n, d), of Sobol's sequence; and whether the first are the scene's own numbers, which
    are there where all are known and within the bounds."""
    count = max(POINTS * spec.starts, 2)
    sampler = qmc.Sobol(len(spec.paths), rng=np.random.default_rng(spec.seed))
    points = sampler.random_base2(int(np.ceil(np.log2(count))))[:count]
    own = (spec.own - spec.low) / (spec.high - spec.low)
    within = bool(np.all((own >= 0.0) & (own <= 1.0)))
    points = np.concatenate([own[None], points]) if within else points
    return np.clip(points, INSIDE, 1.0 - INSIDE), within


def looked_at(wish: Wish, points: Sequence[list[float]]) -> list[list[float]]:
    """How good each point is, as numbers that are compared one after another; smaller is better. A work item."""
    return [_rank(trial) for trial in tried_together(wish, [np.array(point) for point in points])]


def _rank(trial: Trial) -> list[float]:
    """Designs that run come first; of these, those that keep the constraints."""
    if trial.runs:
        broken = violation(trial)
        return [0.0, broken, value_of(trial)]
    lacking = float(np.linalg.norm(trial.lacking))
    return [1.0, lacking if np.isfinite(lacking) else np.inf, 0.0]


def value_of(trial: Trial) -> float:
    """What is to be small: the sum of squares, or of the goals."""
    return trial.cost if len(trial.residuals) else float(trial.goals.sum())


def violation(trial: Trial, equal: Flags | None = None) -> float:
    """By how much constraints are not kept, their root sum of squares; `equal` (c,) are those that have to be 0."""
    broken = np.minimum(trial.limits, 0.0)
    if equal is not None:
        broken = np.where(equal, trial.limits, broken)
    return float(np.linalg.norm(broken))


def brought_in(trials: Counted, u: Array) -> Array | None:
    """The design that runs which is next to u, found by what u lacks: how far its rows are from closing, how much of
    the duration it does not run. None where none is found."""
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
    with suppress(StopIteration, ValueError):  # the latter where no number is to be had
        least_squares(
            lacking,
            inside,
            lambda v: np.nan_to_num(derivative(lacking, v, lacking(v), STEP, central=False)),
            bounds=(0.0, 1.0),
            max_nfev=EFFORT,
        )
    return poses[0] if poses else None
