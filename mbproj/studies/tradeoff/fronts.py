"""Pareto fronts of a grid of settings, the settings near them that are timed, and the families of settings that are
lines in diagrams."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import Any

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.measure.setting import Setting

#: A setting is timed where its first time is within this factor of the cheapest setting that is as good. At most
#: `MOST_TIMED` settings are timed.
NEAR_IN_TIME, MOST_TIMED = 1.5, 40
#: Errors below this count as zero, before a logarithm is taken. They occur where nothing moves, or the span is zero.
NONE = 1e-300
#: Joints count as closed where |C| is at most this part of the mechanism's size, or of 1 m.
CLOSED = 1e-11


def front(cost: Sequence[float] | Array, error: Sequence[float] | Array) -> Integers:
    """Indices of the Pareto front, by increasing cost. A setting is on it where no other has at most its cost and its
    error, and less of one. Of equal settings the first counts; infinite values never do."""
    costs, errors = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    order = np.lexsort((np.arange(len(costs)), errors, costs))
    indices, best = [], np.inf
    for index in order:
        if np.isfinite(costs[index]) and errors[index] < best:
            indices.append(index)
            best = errors[index]
    return np.array(indices, dtype=np.intp)


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


def projections_at_one_size(trials: Sequence[Measurement], errors: Array, own: Setting | None) -> list[int]:
    """Indices of settings with one integrator and one fixed step that differ only in their projection. The largest such
    group is taken. Of equally large groups, take the one with the scene's own setting, or else the one with the middle
    error."""
    groups: dict[Any, list[int]] = {}
    for index, trial in enumerate(trials):
        if trial.setting.step is not None and trial.failure is None:
            groups.setdefault((trial.setting.integrator, trial.setting.step), []).append(index)
    most = max((len(group) for group in groups.values()), default=0)
    full = [group for group in groups.values() if len(group) == most and most > 1]
    if not full:
        return []
    for group in full:
        if own is not None and any(trials[index].setting == own for index in group):
            return group
    best = np.log(np.array([errors[group].min() for group in full]).clip(NONE))
    middle = 0.5 * (best.min() + best.max())
    return full[int(np.argmin(np.abs(best - middle)))]


def to_time(trials: Sequence[Measurement], errors: Array, closed: float, always: Sequence[int]) -> list[int]:
    """Indices of the settings to time: those near one of three fronts, and `always`. The fronts are of all settings, of
    the settings with |C| of at most `closed`, and with |C| in place of the error."""
    seconds = np.array([trial.seconds for trial in trials])
    violations = np.array([trial.position_violation for trial in trials])
    fronts = (errors, np.where(violations <= closed, errors, inf), violations)
    nearness = np.min([excess(seconds, values) for values in fronts], axis=0)
    near = [index for index in np.argsort(nearness, kind="stable") if nearness[index] <= NEAR_IN_TIME][:MOST_TIMED]
    alive = [index for index in always if trials[index].failure is None]
    return sorted({int(index) for index in (*near, *alive)})


def kind(setting: Setting) -> str:
    """The integrator of a setting and how its step is chosen: fixed steps or a tolerance."""
    return f"{setting.integrator}, {'fixed steps' if setting.tolerance is None else 'tolerance'}"


def by_integrator(trials: Sequence[Measurement]) -> dict[str, list[int]]:
    """Indices of the trials that have the projection and schedule of the first trial, by integrator and kind of
    step."""
    plain = trials[0].setting.schedule
    return grouped(trials, lambda setting: kind(setting) if setting.schedule == plain else None)


def studied(trials: Sequence[Measurement], front: Sequence[int]) -> str:
    """The integrator and kind of step with most settings on the front, among those that were tried with several
    projections."""
    tried = {
        name: len({trials[index].setting.schedule for index in indices})
        for name, indices in grouped(trials, kind).items()
    }
    wins = {name: sum(kind(trials[index].setting) == name for index in front) for name in tried}
    return max(tried, key=lambda name: (tried[name] > 1, wins[name]))


def by_projection(trials: Sequence[Measurement], name: str) -> dict[str, list[int]]:
    """Indices of the trials of one integrator and kind of step, by projection and schedule."""
    return grouped(trials, lambda setting: setting.schedule if kind(setting) == name else None)


def grouped(trials: Sequence[Measurement], key: Callable[[Setting], str | None]) -> dict[str, list[int]]:
    """Indices of the trials, grouped by `key` of their settings; trials whose key is None are left out."""
    groups: dict[str, list[int]] = {}
    for index, trial in enumerate(trials):
        name = key(trial.setting)
        if name is not None:
            groups.setdefault(name, []).append(index)
    return groups
