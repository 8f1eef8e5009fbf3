"""Whether the rows outside hold every body in the plane: full column rank in the motions out of it.

Out of the plane a body has three motions: a shift along n and turns about e1 and e2. The rows are those of
`dynamics/rank.py`: lengths in units of the system's length, rows of unit length, and a row counts where it stands off
from the span of those before it. A walk from the ground takes bodies one by one: a body whose rows to bodies that are
already held have rank 3 is held too (the matrix is block triangular). It costs linear time and settles trees, and loops
that close joint by joint; only what it leaves, piece by connected piece, needs a dense test.
"""

from __future__ import annotations

import math
from collections import Counter, deque

import numpy as np

from mbproj.arrays import cross
from mbproj.model.planar.rows import RowMap, Seen
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.thresholds import THRESHOLDS

#: Per row: the three numbers that it has for each body it acts on, by body.
Rows = list[dict[int, list[float]]]


def escape(bound: PrimitiveSet, seen: Seen, outside: RowMap, names: tuple[str, ...], length: float) -> str | None:
    """Which of the bodies, by their `names`, the rows outside do not hold in the plane; None where they hold all."""
    rows = _rows(bound, seen, outside, len(names), length)
    free = _not_reached(rows, len(names))
    for piece, own_rows in _pieces(rows, free):
        if len(piece) > THRESHOLDS.largest_piece and len(own_rows) >= 3 * len(piece):
            return f"body '{names[piece[0]]}' is in a piece of {len(piece)} bodies, too many to test, seen in the plane"
        body = _moving(own_rows, piece)
        if body is not None:
            return f"nothing but symmetry keeps body '{names[body]}' in the plane"
    return None


def _rows(bound: PrimitiveSet, seen: Seen, outside: RowMap, bodies: int, length: float) -> Rows:
    """The rows outside in (δz / length, turns about e1 and e2) of each body."""
    gradient, arm = bound.gradient_entries(seen.x), seen.arm[bound.entry_slot]
    shift = length * bound.is_point[bound.entry_slot] * gradient[:, 2]
    turn = cross(arm, gradient)
    parts = zip(shift.tolist(), turn[:, 0].tolist(), turn[:, 1].tolist(), strict=True)
    entries: list[list[tuple[int, tuple[float, float, float]]]] = [[] for _ in range(bound.size)]
    for row, body, part in zip(bound.entry_row.tolist(), bound.body[bound.entry_slot].tolist(), parts, strict=True):
        if body < bodies:
            entries[row].append((body, part))
    found: Rows = [{} for _ in range(outside.size)]
    for at, source, weight in zip(outside.row.tolist(), outside.source.tolist(), outside.weight.tolist(), strict=True):
        for body, (x, y, z) in entries[source]:
            total = found[at].setdefault(body, [0.0, 0.0, 0.0])
            total[0], total[1], total[2] = total[0] + weight * x, total[1] + weight * y, total[2] + weight * z
    for row_parts in found:
        norm = math.sqrt(sum(x * x + y * y + z * z for x, y, z in row_parts.values())) or 1.0
        for body, (x, y, z) in row_parts.items():
            row_parts[body] = [x / norm, y / norm, z / norm]
    return found


def _not_reached(rows: Rows, bodies: int) -> list[int]:
    """The bodies that the walk from the ground does not reach."""
    rows_of: list[list[int]] = [[] for _ in range(bodies)]
    for index, row in enumerate(rows):
        for body in row:
            rows_of[body].append(index)
    basis: list[list[list[float]]] = [[] for _ in range(bodies)]
    waiting = [len(row) for row in rows]
    ready = deque(index for index, count in enumerate(waiting) if count == 1)
    while ready:
        index = ready.popleft()
        for body in [body for body in rows[index] if len(basis[body]) < 3]:  # one, or by now none
            _extend(basis[body], rows[index][body])
            if len(basis[body]) == 3:
                for other in rows_of[body]:
                    waiting[other] -= 1
                    if waiting[other] == 1:
                        ready.append(other)
    return [body for body in range(bodies) if len(basis[body]) < 3]


def _extend(basis: list[list[float]], part: list[float]) -> None:
    """Gram-Schmidt: what is new in `part` joins the basis. Twice is enough (Kahan)."""
    x, y, z = part
    for _ in range(2):
        for a, b, c in basis:
            inner = a * x + b * y + c * z
            x, y, z = x - inner * a, y - inner * b, z - inner * c
    norm = (x * x + y * y + z * z) ** 0.5
    if norm > THRESHOLDS.dependent:
        basis.append([x / norm, y / norm, z / norm])


def _pieces(rows: Rows, free: list[int]) -> list[tuple[list[int], Rows]]:
    """The free bodies, connected by the rows between them, and these rows without the bodies that are held."""
    piece_of = {body: [body] for body in free}
    left = [{body: part for body, part in row.items() if body in piece_of} for row in rows]
    left = [row for row in left if row]
    for row in left:
        first, *others = row
        for body in others:
            one, other = sorted((piece_of[first], piece_of[body]), key=len, reverse=True)
            if one is not other:
                one.extend(other)
                piece_of.update(dict.fromkeys(other, one))
    rows_of: dict[int, Rows] = {id(piece): [] for piece in piece_of.values()}
    for row in left:
        rows_of[id(piece_of[next(iter(row))])].append(row)
    pieces = {id(piece): piece for piece in piece_of.values()}
    return [(sorted(piece), rows_of[key]) for key, piece in pieces.items()]


def _moving(rows: Rows, piece: list[int]) -> int | None:
    """The body of the piece that its rows let move most, the first of equals; None where their rank is full. A large
    piece has too few."""
    if len(piece) > THRESHOLDS.largest_piece:
        rows_on = Counter(body for row in rows for body in row)
        return min(piece, key=lambda body: rows_on[body])
    place = {body: index for index, body in enumerate(piece)}
    matrix = np.zeros((len(rows), len(piece), 3))
    for line, row in zip(matrix, rows, strict=True):
        for body, part in row.items():
            line[place[body]] = part
    _, values, vectors = np.linalg.svd(matrix.reshape(len(rows), 3 * len(piece)), full_matrices=True)
    motions = vectors[np.count_nonzero(values > THRESHOLDS.dependent) :].reshape(-1, len(piece), 3)
    if not len(motions):
        return None
    moved = np.linalg.norm(motions, axis=(0, 2))
    return piece[int(np.argmax(moved > (1.0 - THRESHOLDS.equal_share) * moved.max()))]
