"""Narrow features of smooth functions of time: a pulse, a step by tanh, over which a long step would pass.

A function is quiet where it hardly changes from one of the evenly spaced times to the next. It has a feature where it
changes after a quiet stretch that is longer than the change. A vibration is no feature: error control finds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.functions.kinks import Kink
from mbproj.functions.look_times import look_times
from mbproj.functions.program import Op
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.series import run, time_series
from mbproj.thresholds import THRESHOLDS

#: Functions with only these operations have no narrow features.
PLAIN = frozenset({Op.CONSTANT, Op.VARIABLE, Op.NEGATE, Op.ADD, Op.SUBTRACT, Op.MULTIPLY})


class Feature(NamedTuple):
    """The start and the end of a feature. `after_kink`: whether a kink begins it, so that a step ends there anyway."""

    start: float
    end: float
    after_kink: bool = False


def features(
    programs: ProgramSet, index: int, start: float, end: float, kinks: Sequence[Kink], orders: int = 1
) -> tuple[Feature, ...]:
    """Return the narrow features of program `index`, a function of time alone with these kinks; with three `orders`
    also those of its derivatives. Features between two kinks, or between a kink and the end, are left out. A feature
    that a kink ends, ends there."""
    code = programs.op[programs.start[index] : programs.start[index + 1]]
    if not start < end or all(Op(int(op)) in PLAIN for op in code):
        return ()
    times = look_times(programs, index, start, end)
    bounds = np.array([kink.t for kink in kinks])
    listed: list[Feature] = []
    for values in run(programs, index, [time_series(times)])[:orders]:
        listed += _features_of(times, np.asarray(values), bounds)
    return tuple(sorted(set(listed)))


def _features_of(times: Array, values: Array, kinks: Array) -> list[Feature]:
    spacing = (times[-1] - times[0]) / THRESHOLDS.look_intervals
    undefined = np.flatnonzero(~np.isfinite(values))
    if len(undefined):  # perhaps beyond the run's end
        times, values = times[: undefined[0]], values[: undefined[0]]
    if not len(values) or not np.ptp(values) > THRESHOLDS.rounding * np.abs(values).max():
        return []
    jumps = np.unique(np.searchsorted(times, kinks))
    change = np.abs(np.diff(values)) / np.ptp(values)
    change[np.clip(np.concatenate([jumps - 1, jumps]), 0, len(change) - 1)] = 0.0
    cell = np.minimum(
        ((times[:-1] - times[0]) / spacing + THRESHOLDS.same_written).astype(int), THRESHOLDS.look_intervals - 1
    )
    in_cell = np.bincount(cell, change, THRESHOLDS.look_intervals).astype(float)
    listed = []
    for first, last in _loud(in_cell):
        inside = np.flatnonzero((cell >= first) & (cell <= last) & (change > THRESHOLDS.no_change))
        feature = Feature(float(times[inside[0]]), float(times[inside[-1] + 1]))
        length = feature.end - feature.start
        near_start, near_end = kinks - feature.start, kinks - feature.end
        ended = np.any((-spacing <= near_end) & (near_end <= length)) or times[-1] - feature.end <= length
        bounded = ended and np.any((-length <= near_start) & (near_start <= spacing))
        lost = len(undefined) > 0 and times[-1] - feature.end <= length  # the run stops there, and reports it
        if lost or bounded:
            continue
        ending = kinks[np.abs(near_end) <= spacing]
        feature = _with_tails(feature, kinks, float(times[0]), float(times[-1]))
        feature = feature._replace(after_kink=bool(np.any(np.abs(near_start) <= spacing)))
        listed.append(feature._replace(end=float(ending[0])) if len(ending) else feature)
    return listed


def _with_tails(feature: Feature, kinks: Array, first: float, last: float) -> Feature:
    """Return a feature extended by half its length on either side, up to a kink: a long step would enlarge its small
    tails."""
    tail = 0.5 * (feature.end - feature.start)
    low = max([first, feature.start - tail, *kinks[kinks <= feature.start]])
    high = min([last, feature.end + tail, *kinks[kinks >= feature.end]])
    return Feature(float(low), float(high))


def _loud(change: Array) -> list[tuple[int, int]]:
    """Return first and last interval of each stretch with much change after a longer quiet one."""
    loud = np.flatnonzero(change > 2.0 * THRESHOLDS.no_change)
    if not len(loud):
        return []
    breaks = np.flatnonzero(np.diff(loud) > THRESHOLDS.quiet_stretch)
    firsts, lasts = loud[np.concatenate([[0], breaks + 1])], loud[np.concatenate([breaks, [len(loud) - 1]])]
    before = np.concatenate([[-1], lasts[:-1]])
    return [
        (int(first), int(last))
        for first, last, quiet in zip(firsts, lasts, firsts - before - 1, strict=True)
        if quiet > last - first and change[first : last + 1].max() >= 5.0 * THRESHOLDS.no_change
    ]
