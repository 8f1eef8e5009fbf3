"""Peaks of sampled curves, their values between samples, and their integrals. Polynomials interpolate between samples,
and reach from the samples of a piece to the events that begin and end it. They never cross an event, where a load may
jump or have a kink."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Integers

#: Samples of the polynomial that finds a peak. One of a sample less gives its uncertainty: with two less the difference
#: would vanish at a symmetric peak, whose odd derivatives are zero. Beside or beyond its samples either may vanish by
#: chance, and both do: `LOWER` polynomials are made.
WIDE, LOWER = 7, 3
#: The fewest samples of a polynomial that finds a peak.
FEWEST = 3
#: The uncertainty is this times their difference, inside and beside the samples. At ten samples a swing the error is
#: twice the difference inside; at a reversal of a wiper with 50 samples a turn, 3.2 times beside.
SAFETY, BEYOND = 3.0, 10.0
#: A polynomial tells the load at an event where it is known to this part of it.
TELLS = 0.1
#: Samples of the polynomial that interpolates a curve.
AROUND = 6
#: Points of a search, and the number of passes, each over two cells of the one before: the peak is exact to round-off.
GRID, PASSES = 33, 3
ROUND_OFF = 4.0 * float(np.finfo(float).eps)
#: The most samples of the polynomial that is integrated. With 25 samples a turn, four left 3e-4 of a work.
SMOOTH = 8
#: The places and weights of Gauss on an interval of half-length 1: exact for the polynomials of `SMOOTH` samples.
GAUSS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(SMOOTH // 2)
#: The number of parts into which an interval is divided where a curve changes its sign.
PARTS = 16
#: A value below this part of the largest is zero: at an event, to which a polynomial reaches, its sign is round-off.
NOTHING = 1e-12
#: The most intervals that are integrated at once.
AT_ONCE = 2**14


class Pieces(NamedTuple):
    """The piece of each of T samples: its number, its first sample and the one after its last, and the times in s at
    which it begins and ends. These are the times of events where a load may jump between two samples."""

    number: Integers
    first: Integers
    last: Integers
    begin: Array
    end: Array


def pieces(time: Array, events: Array) -> Pieces:
    """The pieces to which samples (T,) belong. A sample at an event ends its piece; two samples at one time are the
    states before and after it."""
    known = np.array(sorted(set(events.tolist())))  # np.unique imports masked arrays, 8 ms
    passed = np.searchsorted(known, time, side="left")
    number = np.asarray(passed + np.concatenate([[0], np.cumsum(np.diff(time) <= 0.0)]), dtype=np.intp)
    first, last = (np.searchsorted(number, number, side=side) for side in ("left", "right"))
    begin, end = time[first].copy(), time[last - 1].copy()
    if len(known):
        before = known[np.maximum(passed[first] - 1, 0)]
        reaches = (first > 0) & (passed[first] > passed[np.maximum(first - 1, 0)])
        begin = np.where(reaches, np.maximum(before, time[np.maximum(first - 1, 0)]), begin)
        after = known[np.minimum(passed[last - 1], len(known) - 1)]
        following = np.minimum(last, len(time) - 1)
        reaches = (last < len(time)) & (passed[following] > passed[last - 1])
        end = np.where(reaches, np.minimum(after, time[following]), end)
    return Pieces(number, first, last, begin, end)


class Peaks(NamedTuple):
    """The peaks of C curves: the largest magnitude with its sign (C,), its uncertainty, and its time in s."""

    value: Array
    uncertainty: Array
    time: Array


def size(values: Array) -> Array:
    """The magnitudes (T, C) of vectors (T, C, 3); of scalars (T, C, 1) the values with their sign."""
    return values[..., 0] if values.shape[-1] == 1 else np.asarray(np.linalg.norm(values, axis=-1))


def peaks(time: Array, values: Array, piece: Pieces) -> Peaks:
    """The largest magnitudes of C curves, values (T, C, k), in the pieces between events.

    The uncertainty is three times the difference to a polynomial of one sample less, ten times beside an event. It also
    covers what the load may be just before and after events. Where a piece has too few samples for a polynomial, the
    largest sample is taken, and its difference to its neighbours, also beyond an event."""
    sizes = size(values)
    columns = np.arange(sizes.shape[1])
    told, bound = _at_events(time, values, sizes, piece)
    row = np.argmax(np.maximum(_rough(np.abs(sizes), piece.number), told.max(axis=0)), axis=0)
    value, at = sizes[row, columns], time[row].copy()
    uncertainty = _to_neighbours(sizes)[row, columns]
    counts = np.minimum(piece.last - piece.first, WIDE)[row]
    for count in sorted(set(counts.tolist())):
        smooth = np.flatnonzero((counts == count) & np.isfinite(uncertainty))
        if count < FEWEST or not len(smooth):
            continue
        chosen = row[smooth]
        first, last = piece.first[chosen], piece.last[chosen]
        tells = np.isfinite(told[:, chosen, smooth])
        low = np.where(tells[0], piece.begin[chosen], time[np.maximum(chosen - 1, first)])
        high = np.where(tells[1], piece.end[chosen], time[np.minimum(chosen + 1, last - 1)])
        sign = np.where(value[smooth] < 0.0, -1.0, 1.0)
        starts = [(np.clip(chosen - n // 2, first, last - n), n) for n in range(count, max(count - LOWER, 1), -1)]
        searches = [_search(time, values, columns[smooth], *start, low, high, sign) for start in starts]
        best, when = searches[0]
        beside = (chosen - count // 2 < first) | (chosen - count // 2 > last - count)
        apart = [np.where(beside | (k == 0), np.abs(best - each), 0.0) for k, (each, _) in enumerate(searches[1:])]
        higher = np.abs(best) > (1.0 + np.where(beside, NOTHING, ROUND_OFF)) * np.abs(value[smooth])
        value[smooth], at[smooth] = np.where(higher, best, value[smooth]), np.where(higher, when, at[smooth])
        uncertainty[smooth] = np.where(beside, BEYOND, SAFETY) * np.max(apart, axis=0) + ROUND_OFF * np.abs(best)
    return Peaks(value, np.maximum(uncertainty, bound - np.abs(value)), at)


def _to_neighbours(sizes: Array) -> Array:
    """The difference (T, C) of each sample to its neighbours, also beyond an event."""
    step = np.abs(np.diff(sizes, axis=0))
    none = np.zeros((1, sizes.shape[1]))
    return np.maximum(np.concatenate([none, step]), np.concatenate([step, none]))


def _at_events(time: Array, values: Array, sizes: Array, piece: Pieces) -> tuple[Array, Array]:
    """The largest magnitudes from the first sample of a piece to the event before it, and from its last sample to the
    event after it, (2, T, C): 0 where they are not larger than the sample, -inf where polynomials do not tell them; and
    the largest magnitude that any of these may have, (C,)."""
    told = np.full((2, *sizes.shape), -np.inf)
    bound = np.full(sizes.shape[1], -np.inf)
    index, apart = np.arange(len(time)), _to_neighbours(sizes)
    sides = (
        (index[(piece.first == index) & (piece.begin < time)], piece.begin),
        (index[(piece.last == index + 1) & (piece.end > time)], piece.end),
    )
    for side, (rows, when) in enumerate(sides):
        counts = np.minimum(piece.last - piece.first, WIDE)[rows]
        few = rows[counts < FEWEST]
        bound = np.maximum(bound, (np.abs(sizes[few]) + apart[few]).max(axis=0, initial=-np.inf))
        for count in sorted(set(counts[counts >= FEWEST].tolist())):
            chosen = rows[counts == count]
            ends = []
            for many in range(count, max(count - LOWER, 1), -1):
                nodes = (piece.first[chosen] if side == 0 else piece.last[chosen] - many)[:, None] + np.arange(many)
                times = time[chosen, None] + (when[chosen] - time[chosen])[:, None] * np.linspace(0.25, 1.0, 4)
                ends.append(np.abs(size(np.einsum("egn,enck->egck", _weights(time[nodes], times), values[nodes]))))
            spread = BEYOND * np.max([np.abs(ends[0] - each) for each in ends[1:]], axis=(0, 2))
            most = ends[0].max(axis=1)
            larger = np.where(most > np.abs(sizes[chosen]) + spread, most, 0.0)
            told[side, chosen] = np.where(spread <= TELLS * most, larger, -np.inf)
            bound = np.maximum(bound, (most + spread).max(axis=0, initial=-np.inf))
    return told, bound


def _rough(sizes: Array, number: Integers) -> Array:
    """The magnitudes, with each local maximum raised to that of the parabola through it and its neighbours. So a peak
    between two samples can be found larger than another one at a sample."""
    roughness = sizes.copy()
    if len(sizes) < 3:
        return roughness
    before, here, after = sizes[:-2], sizes[1:-1], sizes[2:]
    bend = 2.0 * here - before - after
    one_piece = ((number[:-2] == number[1:-1]) & (number[1:-1] == number[2:]))[:, None]
    tops = one_piece & (here >= before) & (here >= after) & (bend > 0.0)
    roughness[1:-1] += np.where(tops, (after - before) ** 2 / (8.0 * np.where(tops, bend, 1.0)), 0.0)
    return roughness


def _search(
    time: Array, values: Array, column: Integers, first: Integers, count: int, low: Array, high: Array, sign: Array
) -> tuple[Array, Array]:
    """The largest magnitudes (C,) and their times, between `low` and `high` (C,), of the polynomials through `count`
    samples from `first` (C,) on."""
    rows = first[:, None] + np.arange(count)
    nodes, node_values = time[rows], values[rows, column[:, None]]
    low, high = low.copy(), high.copy()
    everyone = np.arange(len(column))
    for _ in range(PASSES):
        times = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, GRID)
        curve = size(np.einsum("cgn,cnk->cgk", _weights(nodes, times), node_values))
        best = np.argmax(sign[:, None] * curve, axis=1)
        top, when = curve[everyone, best], times[everyone, best]
        cell = (high - low) / (GRID - 1)
        low, high = np.maximum(when - cell, low), np.minimum(when + cell, high)
    return top, when


def between(time: Array, values: Array, events: Array, when: Array) -> Array:
    """The curves (T, k) at N times between the first and the last sample: (N, k). The polynomials go through the
    samples around, and do not cross an event."""
    number = pieces(time, events).number
    after = np.clip(np.searchsorted(time, when, side="left"), 1, len(time) - 1)
    first, last = (np.searchsorted(number, number[after], side=side) for side in ("left", "right"))
    # The sample at an event ends its piece, and begins the next.
    first = first - ((number[after] != number[after - 1]) & (time[after] > time[after - 1]))
    start = np.clip(after - AROUND // 2, first, np.maximum(first, last - AROUND))
    values_between, counts = np.empty((len(when), values.shape[1])), np.minimum(last - start, AROUND)
    for count in set(counts.tolist()):
        chosen = np.flatnonzero(counts == count)
        rows = start[chosen, None] + np.arange(count)
        values_between[chosen] = np.einsum("gn,gnk->gk", _weights(time[rows], when[chosen, None])[:, 0], values[rows])
    return values_between


class _Segments(NamedTuple):
    """S parts of intervals between samples in which a curve is smooth: the number of the interval, the ends in s, and
    the first sample of the polynomial; each has as many `samples`."""

    interval: Integers
    begin: Array
    end: Array
    start: Integers
    samples: int


def integrals(time: Array, values: Array, piece: Pieces) -> Array:
    """∫ f dt over each interval between samples, values (T, C): (T - 1, C)."""
    areas = np.zeros((max(len(time) - 1, 0), values.shape[1]))
    for part in _segments(time, piece):
        np.add.at(areas, part.interval, _area(time, values, part))
    return areas


def in_and_out(time: Array, values: Array, piece: Pieces) -> tuple[Array, Array]:
    """∫ max(f, 0) dt and ∫ max(-f, 0) dt, values (T, C): (C,) each. Their difference is ∫ f dt."""
    up, down = np.zeros(values.shape[1]), np.zeros(values.shape[1])
    nothing = NOTHING * np.abs(values).max(axis=0, initial=0.0)
    for part in _segments(time, piece):
        whole = _area(time, values, part)
        ends = np.stack([part.begin, part.end], axis=1)
        rows = part.start[:, None] + np.arange(part.samples)
        before, after = np.einsum("sgn,snc->gsc", _weights(time[rows], ends), values[rows])
        changes = (before * after < 0.0) & (np.minimum(np.abs(before), np.abs(after)) > nothing)
        up += np.where(changes, 0.0, np.maximum(whole, 0.0)).sum(axis=0)
        down += np.where(changes, 0.0, np.maximum(-whole, 0.0)).sum(axis=0)
        row, column = np.nonzero(changes)
        if len(row):
            some = _Segments(part.interval[row], part.begin[row], part.end[row], part.start[row], part.samples)
            for total, sign in ((up, 1.0), (down, -1.0)):
                np.add.at(total, column, _above(time, sign * values, some, column))
    return up, down


def _segments(time: Array, piece: Pieces) -> Iterator[_Segments]:
    """Yield all intervals between samples, each up to the first event within it and from there on."""
    index = np.arange(len(time) - 1)
    inside = piece.number[:-1] == piece.number[1:]
    across = index[~inside]
    ends = [
        (index[inside], index[inside], time[:-1][inside], time[1:][inside]),
        (across, across, time[across], piece.end[across]),
        (across, across + 1, piece.end[across], time[across + 1]),
    ]
    interval, sample, begin, end = (np.concatenate(each) for each in zip(*ends, strict=True))
    some = end > begin
    interval, sample, begin, end = interval[some], sample[some], begin[some], end[some]
    first, last = piece.first[sample], piece.last[sample]
    counts = np.minimum(last - first, SMOOTH)
    start = np.clip(sample - counts // 2 + 1, first, last - counts)
    for count in sorted(set(counts.tolist())):
        chosen = np.flatnonzero(counts == count)
        for at in range(0, len(chosen), AT_ONCE):
            few = chosen[at : at + AT_ONCE]
            yield _Segments(interval[few], begin[few], end[few], start[few], count)


def _area(time: Array, values: Array, part: _Segments) -> Array:
    """The integrals (S, C) of the polynomials."""
    middle, half = 0.5 * (part.begin + part.end), 0.5 * (part.end - part.begin)
    rows = part.start[:, None] + np.arange(part.samples)
    share = np.einsum("g,sgn->sn", GAUSS_WEIGHTS, _weights(time[rows], middle[:, None] + half[:, None] * GAUSS))
    return np.asarray(half[:, None] * np.einsum("sn,snc->sc", share, values[rows]))


def _above(time: Array, values: Array, part: _Segments, column: Integers) -> Array:
    """∫ max(f, 0) dt (S,) of the curve `column` (S,) of each polynomial: that of lines through it in a part of the
    interval where it changes its sign, and by Simpson's rule in the others."""
    share = np.linspace(0.0, 1.0, 2 * PARTS + 1)
    times = part.begin[:, None] + (part.end - part.begin)[:, None] * share
    rows = part.start[:, None] + np.arange(part.samples)
    curve = np.einsum("sgn,sn->sg", _weights(time[rows], times), values[rows, column[:, None]])
    before, middle, after = curve[:, :-1:2], curve[:, 1::2], curve[:, 2::2]
    smooth = np.maximum(before + 4.0 * middle + after, 0.0) / 6.0
    high, height = np.maximum(np.maximum(before, after), 0.0), np.abs(before) + np.abs(after)
    crossed = 0.5 * high * high / np.where(height > 0.0, height, 1.0)
    mean = np.where(before * after < 0.0, crossed, smooth)
    return np.asarray((part.end - part.begin) * mean.mean(axis=1))


def _weights(nodes: Array, times: Array) -> Array:
    """The Lagrange polynomials (C, g, n) of the nodes (C, n) at the times (C, g)."""
    count = nodes.shape[1]
    weights = np.ones((*times.shape, count))
    for node in range(count):
        for other in range(count):
            if other != node:
                span = nodes[:, node] - nodes[:, other]
                weights[..., node] *= (times - nodes[:, other, None]) / span[:, None]
    return weights
