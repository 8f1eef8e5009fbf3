"""A table of a function: cubics between its rows, straight lines beyond its ends."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf

from mbproj.base.dataclass import dataclass

#: The sweeps of an iteration to round-off.
SWEEPS = 40


@dataclass(frozen=True)
class CubicTable:
    """Pieces, each valid from its knot to the next: c0 + c1 u + c2 u² + c3 u³ with u = x - origin.

    The first piece begins at -∞; its origin is the first row. The origin of any other piece is its knot. A table with a
    `period` begins with its first knot, and covers one period.
    """

    knots: tuple[float, ...]
    origins: tuple[float, ...]
    pieces: tuple[tuple[float, float, float, float], ...]
    period: float = 0.0


def spline(rows: Sequence[tuple[float, float]], ends: str) -> CubicTable:
    """Return the cubic spline through rows (x, y), two at least, x increasing (de Boor 1978, ch. IV).

    `ends` "natural": y'' = 0 at both, so that the lines beyond continue it twice differentiable; "clamped": y' = 0.
    """
    return _hermite(rows, _slopes(rows, ends))


def periodic(rows: Sequence[tuple[float, float]], period: float) -> CubicTable:
    """Return the periodic cubic spline through rows (x, y), three at least with x of one period. The slopes come from a
    Gauss-Seidel iteration, whose error falls by a factor of four a sweep."""
    rows = sorted((x % period, y) for x, y in rows)
    count = len(rows)
    x, y = [row[0] for row in rows], [row[1] for row in rows]
    h = [(x[(i + 1) % count] - x[i]) % period for i in range(count)]
    step = [(y[(i + 1) % count] - y[i]) / h[i] for i in range(count)]
    slopes = [0.0] * count
    for _ in range(SWEEPS):
        for i in range(count):
            wanted = 3.0 * (h[i] * step[i - 1] + h[i - 1] * step[i])
            neighbours = h[i] * slopes[i - 1] + h[i - 1] * slopes[(i + 1) % count]
            slopes[i] = 0.5 * (wanted - neighbours) / (h[i - 1] + h[i])
    table = _hermite([*rows, (x[0] + period, y[0])], [*slopes, slopes[0]])
    return CubicTable(table.knots[1:-1], table.origins[1:-1], table.pieces[1:-1], period)


def polygon(rows: Sequence[tuple[float, float]]) -> CubicTable:
    """Return straight lines from row to row."""
    steps = [(y1 - y0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(rows)]
    pieces = [(y, step, 0.0, 0.0) for (_, y), step in zip(rows, steps, strict=False)]
    return _table(rows, pieces, steps[0], steps[-1])


def _slopes(rows: Sequence[tuple[float, float]], ends: str) -> list[float]:
    """Return y' at the rows, by Gaussian elimination in the tridiagonal system for continuous y''."""
    count = len(rows)
    h = [rows[i + 1][0] - rows[i][0] for i in range(count - 1)]
    step = [(rows[i + 1][1] - rows[i][1]) / h[i] for i in range(count - 1)]
    clamped = ends == "clamped"
    diagonal = [1.0 if clamped else 2.0]
    above = [0.0 if clamped else 1.0]
    right = [0.0 if clamped else 3.0 * step[0]]
    for i in range(1, count):
        last = i == count - 1
        below = (0.0 if clamped else 1.0) if last else h[i]
        middle = (1.0 if clamped else 2.0) if last else 2.0 * (h[i - 1] + h[i])
        wanted = (0.0 if clamped else 3.0 * step[-1]) if last else 3.0 * (h[i] * step[i - 1] + h[i - 1] * step[i])
        factor = below / diagonal[-1]
        diagonal.append(middle - factor * above[-1])
        right.append(wanted - factor * right[-1])
        above.append(0.0 if last else h[i - 1])
    slopes = [right[-1] / diagonal[-1]]
    for i in range(count - 2, -1, -1):
        slopes.append((right[i] - above[i] * slopes[-1]) / diagonal[i])
    return slopes[::-1]


def _hermite(rows: Sequence[tuple[float, float]], slopes: Sequence[float]) -> CubicTable:
    """Return the cubics with these values and slopes at the rows."""
    pieces = []
    for ((x0, y0), (x1, y1)), (s0, s1) in zip(pairwise(rows), pairwise(slopes), strict=True):
        h = x1 - x0
        step = (y1 - y0) / h
        pieces.append((y0, s0, (3.0 * step - 2.0 * s0 - s1) / h, (s0 + s1 - 2.0 * step) / (h * h)))
    return _table(rows, pieces, slopes[0], slopes[-1])


def _table(
    rows: Sequence[tuple[float, float]],
    pieces: Sequence[tuple[float, float, float, float]],
    first: float,
    last: float,
) -> CubicTable:
    """Return the pieces between the rows, with lines of the slopes `first` and `last` beyond them."""
    x = [row[0] for row in rows]
    lines = (rows[0][1], first, 0.0, 0.0), (rows[-1][1], last, 0.0, 0.0)
    return CubicTable((-inf, *x), (x[0], *x), (lines[0], *pieces, lines[1]))
