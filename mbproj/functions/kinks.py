"""Kinks of functions of time: those of `abs min max sign floor ceil`, ends of smooth steps, rows of tables, and any
other jump of a value or a slope. Examples of the last are the root of a square, and an arc function between branches.

Kinks of the first kind follow from the program. Each such operation is on one of its branches at a time. Where the
branch changes between two samples, bisection finds the time, down to the resolution of time. Jumps of the second kind
appear between two samples as a change that the derivatives at both do not explain. Halving the interval makes that
vanish where the function is smooth, and leaves it where it jumps. A branch that changes twice between two of the times
of `look_times` is not found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.program import Op
from mbproj.functions.program_set import ROUND_OFF, ProgramSet
from mbproj.functions.series import run, time_series, walk

# --- The times at which functions of time are sampled -----------------------------------------------------------------
# Evenly spaced, and ever closer to the zeros of their intermediate values. Narrow features lie there: the peak of
# exp(-((t - 1)/1e-4)²), the pulse max(0, 1 - abs(t - 1)/1e-4).


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


# --- Kinks of functions of time ---------------------------------------------------------------------------------------


#: The operations with several branches, and others that need not be smooth everywhere.
BRANCHED = frozenset({Op.ABS, Op.SIGN, Op.MIN, Op.MAX, Op.FLOOR, Op.CEIL, Op.SMOOTH_STEP, Op.TABLE})
UNEVEN = frozenset({Op.POWER, Op.POWER_OF, Op.SQRT, Op.HYPOT, Op.ATAN2, Op.ASIN, Op.ACOS})


class Kink(NamedTuple):
    """A time, and the jumps of the value, the first and the second derivative there."""

    t: float
    jump: tuple[float, float, float]


def kinks(programs: ProgramSet, index: int, start: float, end: float) -> tuple[Kink, ...]:
    """Return the kinks of program `index`, a function of time alone, from `start` to `end`, in order: the first
    `most_kinks` within. A kink at `start` or `end` counts where the value or a derivative there differs from that right
    beside it. Rows of tables count where one of these jumps."""
    branched, uneven = _suspects(programs, index)
    if not (branched or uneven) or not start < end:
        return ()
    look = _SampledFunction(programs, index, look_times(programs, index, start, end))
    smooth = look.changes(branched - {Op.TABLE})
    jumping = look.largest_of_each_interval(look.jumps()) if uneven else np.zeros(0)
    rows = look.changes(branched & {Op.TABLE})
    times = look.distinct_times(np.concatenate([smooth, jumping, rows]))[: THRESHOLDS.most_kinks]
    jumps = look.jump(times - look.aside, times + look.aside)
    counts = np.isin(times, smooth) | np.any(jumps != 0.0, axis=1)
    ends = np.array([start, end - look.aside]), np.array([start + look.aside, end])
    first, last = (
        [Kink(t, tuple(jump))] if any(jump) else []
        for t, jump in zip((start, end), look.jump(*ends).tolist(), strict=True)
    )
    inner = zip(times[counts].tolist(), jumps[counts].tolist(), strict=True)
    return (*first, *(Kink(t, tuple(jump)) for t, jump in inner), *last)


def _suspects(programs: ProgramSet, index: int) -> tuple[frozenset[Op], frozenset[Op]]:
    """Return the operations of a program that have branches, and the others that need not be smooth."""
    branched, uneven = set(), set()
    for at in range(programs.start[index], programs.start[index + 1]):
        op, operand = Op(int(programs.op[at])), float(programs.operand[at])
        if op in BRANCHED:
            branched.add(op)
        elif op in UNEVEN and not (op is Op.POWER and operand >= 0.0 and operand.is_integer()):
            uneven.add(op)
    return frozenset(branched), frozenset(uneven)


class _SampledFunction:
    """The values of a function at the times of its samples, for one search of kinks."""

    def __init__(self, programs: ProgramSet, index: int, times: Array) -> None:
        self.programs, self.index, self.times = programs, index, times
        self.grain = float(np.spacing(max(abs(times[0]), abs(times[-1]))))
        self.aside = THRESHOLDS.closed_grains * self.grain
        self.values = self.value(times)
        sizes = [float(np.abs(each[np.isfinite(each)]).max(initial=0.0)) for each in self.values]
        self.round_off = ROUND_OFF * sizes

    def value(self, t: Array) -> Array:
        """Return value and derivatives, (3, T)."""
        return np.array(run(self.programs, self.index, [time_series(t)]))

    def changes(self, ops: frozenset[Op]) -> Array:
        """Return the times at which the branch of one of these operations changes."""
        if not ops:
            return np.zeros(0)

        def differs(low: Array, high: Array, before: Array, after: Array) -> Array:
            return np.any(before != after, axis=0).astype(float)

        def branches(t: Array) -> Array:
            return _branches(self.programs, self.index, t, ops)

        return self._bisected(branches, branches(self.times), differs)

    def jumps(self) -> Array:
        """Return the times at which the value or the slope changes by more than the next derivative explains."""

        def unexplained(low: Array, high: Array, before: Array, after: Array) -> Array:
            with np.errstate(all="ignore"):
                explained = 0.5 * (high - low) * (before[1:] + after[1:])
                left = np.abs(after[:2] - before[:2] - explained) / np.maximum(self.round_off[:2, None], 1e-300)
            seen = np.isfinite(before[:2]) | np.isfinite(after[:2])
            return np.max(np.where(seen & ~(left <= 1.0), np.nan_to_num(left, nan=np.inf), 0.0), axis=0)

        return self._bisected(self.value, self.values, unexplained)

    def _bisected(
        self, look: Callable[[Array], Array], looks: Array, score: Callable[[Array, Array, Array, Array], Array]
    ) -> Array:
        """Return the upper ends of the intervals with a score above 0, halved down to the resolution of time.

        `score` rates an interval by the values of `look` at its ends. Of many intervals those with the largest score,
        or the earliest, are kept."""
        low, high, before, after = self.times[:-1], self.times[1:], looks[:, :-1], looks[:, 1:]
        while True:
            scores = score(low, high, before, after)
            chosen = np.sort(
                np.argsort(-scores, kind="stable")[: min(2 * THRESHOLDS.most_kinks, np.count_nonzero(scores))]
            )
            low, high, before, after = low[chosen], high[chosen], before[:, chosen], after[:, chosen]
            wide = high - low > self.grain
            if not wide.any():
                return high
            middle = np.where(wide, 0.5 * (low + high), high)
            between = look(middle)
            order = np.argsort(np.concatenate([low, middle]), kind="stable")
            low, high = np.concatenate([low, middle])[order], np.concatenate([middle, high])[order]
            before = np.concatenate([before, between], axis=1)[:, order]
            after = np.concatenate([between, after], axis=1)[:, order]

    def largest_of_each_interval(self, times: Array) -> Array:
        """Return the largest jump of each even interval: near a jump round-off may look like many."""
        jumps = self.jump(times - self.aside, times + self.aside)
        size = np.max(np.abs(jumps[:, :2]) / np.maximum(self.round_off[:2], 1e-300), axis=1, initial=0.0)
        even = np.linspace(self.times[0], self.times[-1], THRESHOLDS.look_intervals + 1)
        interval = np.searchsorted(even, times - self.aside)
        return np.array([times[interval == each][np.argmax(size[interval == each])] for each in np.unique(interval)])

    def distinct_times(self, times: Array) -> Array:
        """Return the times in order, none twice, and none at the start or the end."""
        times = np.unique(times)
        times = times[(times > self.times[0] + self.aside) & (times < self.times[-1] - self.aside)]
        return times[np.concatenate([[True], np.diff(times) > 2.0 * self.aside])] if len(times) else times

    def jump(self, before: Array, after: Array) -> Array:
        """Return the jumps of value and derivatives, (T, 3), between times so near that only a jump changes them; else
        0."""
        left, right = self.value(before), self.value(after)
        with np.errstate(all="ignore"):
            slopes = np.maximum(np.abs(left), np.abs(right))[1:]
            grown = 4.0 * (after - before) * np.concatenate([slopes, np.zeros((1, len(before)))])
            difference = right - left
            difference = np.where(np.abs(difference) <= grown + self.round_off[:, None], 0.0, difference)
        return np.nan_to_num(difference, nan=np.inf, posinf=np.inf, neginf=-np.inf).T


def _branches(programs: ProgramSet, index: int, t: Array, ops: frozenset[Op]) -> Array:
    """Return the branch of each of these operations, (operations, T)."""
    branches = []
    with np.errstate(all="ignore"):
        for at, stack in walk(programs, index, [time_series(t)]):
            op = Op(int(programs.op[at]))
            if op in ops:
                branches.append(_branch(programs, op, int(programs.operand[at]), [series[0] for series in stack[-2:]]))
    return np.array(branches, dtype=float).reshape(-1, len(t))


def _branch(programs: ProgramSet, op: Op, operand: int, arguments: list[Any]) -> Any:
    x = arguments[-1]
    if op in (Op.MIN, Op.MAX):
        return arguments[0] >= x
    if op in (Op.ABS, Op.SIGN):
        return x >= 0.0
    if op is Op.SMOOTH_STEP:
        return (x >= 0.0).astype(float) + (x >= 1.0)
    if op is Op.TABLE:
        return np.searchsorted(programs.knot[slice(*programs.table_start[operand : operand + 2])], x, side="right")
    return np.nan_to_num(np.floor(x) if op is Op.FLOOR else np.ceil(x))


# --- Narrow features of smooth functions of time ----------------------------------------------------------------------
# A pulse, a step by tanh, over which a long step would pass.
# A function is quiet where it hardly changes from one of the evenly spaced times to the next. It has a feature where
# it changes after a quiet stretch that is longer than the change. A vibration is no feature: error control finds it.


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
