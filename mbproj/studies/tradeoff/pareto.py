"""Pareto fronts: the settings for which no other is both cheaper and better."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array, Integers


def front(cost: Sequence[float] | Array, error: Sequence[float] | Array) -> Integers:
    """Indices of the Pareto front, by increasing cost. A setting is on it where no other has at most its cost and its
    error, and less of one. Of equal settings the first counts; infinite values never do."""
    costs, errors = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    order = np.lexsort((np.arange(len(costs)), errors, costs))
    found, best = [], np.inf
    for index in order:
        if np.isfinite(costs[index]) and errors[index] < best:
            found.append(index)
            best = errors[index]
    return np.array(found, dtype=np.intp)


def excess(cost: Sequence[float] | Array, error: Sequence[float] | Array) -> Array:
    """The cost of each setting over the least cost with at most its error, (N,) >= 1. It is infinite where the cost or
    the error is not finite."""
    costs, errors = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    ratios = np.full(len(costs), np.inf)
    for index in np.flatnonzero(np.isfinite(costs) & np.isfinite(errors)):
        ratios[index] = costs[index] / costs[errors <= errors[index]].min()
    return ratios


def cheapest(cost: Sequence[float] | Array, error: Sequence[float] | Array, limit: float) -> int | None:
    """The index of the cheapest setting with an error of at most `limit`; None where there is none."""
    costs = np.where(np.asarray(error, dtype=float) <= limit, np.asarray(cost, dtype=float), np.inf)
    index = int(np.argmin(costs)) if len(costs) else 0
    return index if len(costs) and np.isfinite(costs[index]) else None
