"""Peaks and integrals of sampled curves. Polynomials interpolate between samples, but never across an event, where a
load may jump or have a kink."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, Integers

#: Samples of the polynomial that finds a peak, and of the lower one that gives its uncertainty. This has one sample
#: less: with two less the difference would vanish at a symmetric peak, whose odd derivatives are zero.
WIDE, NARROW = 7, 6
#: The uncertainty is this times their difference; at ten samples a swing the error is twice the difference.
SAFETY = 3.0
#: Samples of the polynomial that interpolates a curve.
AROUND = 6
#: Samples of the polynomial that is integrated.
CUBIC = 4
#: Points of a search, and the number of passes, each over two cells of the one before: the peak is exact to round-off.
GRID, PASSES = 33, 3
ROUND_OFF = 4.0 * float(np.finfo(float).eps)


class Peaks(NamedTuple):
    """The peaks of C curves: the largest magnitude with its sign (C,), its uncertainty, and its time in s."""

    value: Array
    uncertainty: Array
    time: Array


def pieces(time: Array, events: Array) -> Integers:
    """The number (T,) of the piece between events to which each sample belongs. A sample at an event ends its piece;
    two samples at one time are the states before and after it."""
    number = np.searchsorted(sorted(set(events.tolist())), time, side="left")  # np.unique imports masked arrays, 8 ms
    return np.asarray(number + np.concatenate([[0], np.cumsum(np.diff(time) <= 0.0)]), dtype=np.intp)


def size(values: Array) -> Array:
    """The magnitudes (T, C) of vectors (T, C, 3); of scalars (T, C, 1) the values with their sign."""
    return values[..., 0] if values.shape[-1] == 1 else np.asarray(np.linalg.norm(values, axis=-1))


def peaks(time: Array, values: Array, piece: Integers) -> Peaks:
    """The largest magnitudes of C curves, values (T, C, k). Polynomials do not cross the borders of `piece` (T,).

    The uncertainty is three times the difference to a polynomial of one sample less. Where a piece has too few samples
    for the polynomial, the largest sample is taken, and its difference to its neighbours, also beyond an event.
    """
    sizes = size(values)
    columns = np.arange(sizes.shape[1])
    row = np.argmax(_rough(np.abs(sizes), piece), axis=0)
    value, at = sizes[row, columns], time[row].copy()
    around = [np.clip(row + shift, 0, len(time) - 1) for shift in (-1, 1)]
    uncertainty = np.max([np.abs(sizes[near, columns] - value) for near in around], axis=0)
    first, last = (np.searchsorted(piece, piece[row], side=side) for side in ("left", "right"))
    smooth = np.flatnonzero((last - first >= WIDE) & np.isfinite(uncertainty))
    if len(smooth):
        chosen, begins, ends = row[smooth], first[smooth], last[smooth]
        wide = np.clip(chosen - WIDE // 2, begins, ends - WIDE)
        narrow = np.clip(chosen - NARROW // 2, begins, ends - NARROW)
        low, high = time[np.maximum(chosen - 1, begins)], time[np.minimum(chosen + 1, ends - 1)]
        sign = np.where(value[smooth] < 0.0, -1.0, 1.0)
        best, when = _search(time, values, columns[smooth], wide, WIDE, low, high, sign)
        other, _ = _search(time, values, columns[smooth], narrow, NARROW, low, high, sign)
        higher = np.abs(best) > (1.0 + ROUND_OFF) * np.abs(value[smooth])  # a constant has its peak at the first sample
        value[smooth], at[smooth] = np.where(higher, best, value[smooth]), np.where(higher, when, at[smooth])
        uncertainty[smooth] = SAFETY * np.abs(best - other) + ROUND_OFF * np.abs(best)
    return Peaks(value, uncertainty, at)


def _rough(sizes: Array, piece: Integers) -> Array:
    """The magnitudes, with each local maximum raised to that of the parabola through it and its neighbours. So a peak
    between two samples can be found larger than another one at a sample."""
    roughness = sizes.copy()
    if len(sizes) < 3:
        return roughness
    before, here, after = sizes[:-2], sizes[1:-1], sizes[2:]
    bend = 2.0 * here - before - after
    one_piece = ((piece[:-2] == piece[1:-1]) & (piece[1:-1] == piece[2:]))[:, None]
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


def _weights(nodes: Array, times: Array) -> Array:
    """The Lagrange polynomials (C, g, n) of the nodes (C, n) at the times (C, g)."""
    count = nodes.shape[1]
    weights = np.ones((*times.shape, count))
    for own in range(count):
        for other in range(count):
            if other != own:
                span = nodes[:, own] - nodes[:, other]
                weights[..., own] *= (times - nodes[:, other, None]) / span[:, None]
    return weights


def between(time: Array, values: Array, events: Array, when: Array) -> Array:
    """The curves (T, k) at N times between the first and the last sample: (N, k). The polynomials go through the
    samples around, and do not cross an event."""
    piece = pieces(time, events)
    after = np.clip(np.searchsorted(time, when, side="left"), 1, len(time) - 1)
    first, last = (np.searchsorted(piece, piece[after], side=side) for side in ("left", "right"))
    # The sample at an event ends its piece, and begins the next.
    first = first - ((piece[after] != piece[after - 1]) & (time[after] > time[after - 1]))
    start = np.clip(after - AROUND // 2, first, np.maximum(first, last - AROUND))
    values_between, counts = np.empty((len(when), values.shape[1])), np.minimum(last - start, AROUND)
    for count in set(counts.tolist()):
        own = np.flatnonzero(counts == count)
        rows = start[own, None] + np.arange(count)
        values_between[own] = np.einsum("gn,gnk->gk", _weights(time[rows], when[own, None])[:, 0], values[rows])
    return values_between


def integrals(time: Array, values: Array, piece: Integers) -> Array:
    """∫ f dt over each interval between samples, values (T, C): (T - 1, C). The curve is a cubic where four samples of
    one piece are around, else a straight line."""
    length = np.diff(time)
    areas = 0.5 * length[:, None] * (values[1:] + values[:-1])
    if len(time) < CUBIC:
        return np.asarray(areas)
    first = np.clip(np.arange(len(length)) - 1, 0, len(time) - CUBIC)
    rows = first[:, None] + np.arange(CUBIC)
    inside = np.flatnonzero(piece[rows[:, 0]] == piece[rows[:, -1]])
    nodes = time[rows[inside]]
    middle, half = 0.5 * (time[inside] + time[inside + 1]), 0.5 * length[inside]
    points = np.stack([middle - half / np.sqrt(3.0), middle + half / np.sqrt(3.0)], axis=1)  # Gauss: exact for cubics
    weights = half[:, None] * _weights(nodes, points).sum(axis=1)
    areas[inside] = np.einsum("in,inc->ic", weights, values[rows[inside]])
    return np.asarray(areas)


def in_and_out(time: Array, values: Array, piece: Integers) -> tuple[Array, Array]:
    """∫ max(f, 0) dt and ∫ max(-f, 0) dt, values (T, C): (C,) each. Their difference is ∫ f dt. An interval in which f
    changes its sign is divided at the zero of a straight line."""
    whole = integrals(time, values, piece)
    before, after, length = values[:-1], values[1:], np.diff(time)[:, None]
    changes = before * after < 0.0
    share = np.abs(before) / np.where(changes, np.abs(before) + np.abs(after), 1.0)
    side = np.where(before > 0.0, before * share, after * (1.0 - share))
    up = np.where(changes, 0.5 * length * side, np.maximum(whole, 0.0))
    return up.sum(axis=0), (up - whole).sum(axis=0)
