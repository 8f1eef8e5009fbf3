"""Thinning of long lines for a picture: a page has no room for a million points."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags, Integers

#: The number of points from which on a line is thinned.
MANY = 20_000
#: The columns and rows of a page: each is at most a third of a printed dot.
COLUMNS = 4000


def thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """Return fewer points of a line that look the same on a page. For ascending x these are the first, lowest, highest
    and last point of each column. For another line they are each movement between two dots, once."""
    if len(x) < MANY:
        return x, y
    ascends = bool(np.isfinite(x).all() and (np.diff(x) >= 0.0).all())
    return _over_time(x, y) if ascends else _path(x, y)


def _over_time(x: Array, y: Array) -> tuple[Array, Array]:
    column = _cells(x, float(x[0]), float(x[-1] - x[0]) / COLUMNS)
    begins = np.flatnonzero(np.diff(column, prepend=-1))
    of = np.repeat(np.arange(len(begins)), np.diff(begins, append=len(x)))
    low, high = np.fmin.reduceat(y, begins)[of], np.fmax.reduceat(y, begins)[of]
    kept = [begins, np.append(begins[1:], len(x)) - 1]  # the first and the last point of each column
    kept += [_first(which, of) for which in (y == low, y == high, np.isnan(y))]  # NaN leaves a gap
    at = np.unique(np.concatenate(kept))
    return x[at], y[at]


def _first(which: Flags, of: Integers) -> Integers:
    """The index of the first marked point in each column. `of` is the column of each point."""
    marked = np.flatnonzero(which)
    places: Integers = marked[np.unique(of[marked], return_index=True)[1]]
    return places


def _path(x: Array, y: Array) -> tuple[Array, Array]:
    drawn = np.isfinite(x) & np.isfinite(y)
    if not drawn.any():
        return x[:1], y[:1]
    size = max(float(np.ptp(values[drawn])) for values in (x, y)) / COLUMNS
    column, row = (_cells(np.where(drawn, each, 0.0), float(each[drawn].min()), size) for each in (x, y))
    dot = np.where(drawn, column * (COLUMNS + 1) + row, -1)
    moved = np.flatnonzero(np.diff(dot, prepend=-2))
    x, y, dot = np.where(drawn, x, np.nan)[moved], y[moved], dot[moved]
    way = dot[:-1] * (COLUMNS + 1) ** 2 + dot[1:]
    new = np.zeros(len(way), dtype=bool)
    new[np.unique(way, return_index=True)[1]] = True
    kept = np.flatnonzero(np.append(new, False) | np.append(True, new))
    ends = np.flatnonzero((np.diff(kept) > 1) | ~new[kept[:-1]]) + 1
    return np.insert(x[kept], ends, np.nan), np.insert(y[kept], ends, np.nan)


def _cells(values: Array, first: float, size: float) -> Integers:
    """The number of the cell that each value lies in. Cells have equal `size`, from `first` on."""
    return np.minimum(((values - first) / size).astype(np.int64), COLUMNS) if size > 0.0 else np.zeros(len(values), int)
