"""Whether the rows outside hold every body in the plane: full column rank in the motions out of it.

Out of the plane a body has three motions: a shift along n and turns about e1 and e2. As in `dynamics/rank`, lengths are
in units of the system's length, and rows have unit length. A row counts where it is independent of the rows before it.

A walk from the ground takes bodies one by one. A body whose rows to bodies already held have rank 3 is held too,
because the matrix is block triangular. The walk costs linear time and settles trees, and loops that close joint by
joint. Only connected pieces that it leaves need a factor: dense, or sparse where there are many bodies.
"""

from __future__ import annotations

import math
from collections import Counter, deque

import numpy as np

from mbproj.arrays import Array, Integers, cross, numbers
from mbproj.model.planar.rows import RowMap, Seen
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.thresholds import THRESHOLDS

#: Rows as mappings from each body to the three entries of the row for that body.
Rows = list[dict[int, list[float]]]
#: The number of random motions that are tried on a large piece, their seed, and the passes of inverse iteration.
MOTIONS, SEED, PASSES = 4, 3, 3


def escape(bound: PrimitiveSet, seen: Seen, outside: RowMap, names: tuple[str, ...], length: float) -> str | None:
    """Return, in words, a body that the rows outside do not hold in the plane; None where they hold all."""
    rows = _rows(bound, seen, outside, len(names), length)
    free = _not_reached(rows, len(names))
    for piece, own_rows in _pieces(rows, free):
        body = _moving(own_rows, piece)
        if body is not None:
            return f"nothing but symmetry keeps body '{names[body]}' in the plane"
    return None


def _rows(bound: PrimitiveSet, seen: Seen, outside: RowMap, bodies: int, length: float) -> Rows:
    """Return the rows outside in (δz / length, turns about e1 and e2) of each body."""
    gradient, arm = bound.gradient_entries(seen.x), seen.arm[bound.entry_slot]
    turn, owner = cross(arm, gradient), bound.body[bound.entry_slot]
    parts = np.column_stack([length * bound.is_point[bound.entry_slot] * gradient[:, 2], turn[:, :2]])
    mine = np.flatnonzero(owner < bodies)
    mine = mine[np.argsort(bound.entry_row[mine], kind="stable")]
    first, end = (np.searchsorted(bound.entry_row[mine], outside.source, side) for side in ("left", "right"))
    count = end - first
    entry = mine[np.repeat(first - np.cumsum(count) + count, count) + np.arange(count.sum())]
    places, same = np.unique(np.repeat(outside.row, count) * bodies + owner[entry], return_inverse=True)
    values = np.zeros((len(places), 3), like=parts)
    np.add.at(values, same, np.repeat(outside.weight, count)[:, None] * parts[entry])
    row = places // bodies
    norm = np.sqrt(np.bincount(row, np.sum(values**2, axis=1), minlength=outside.size))
    values /= np.where(norm == 0.0, 1.0, norm)[row, None]
    rows: Rows = [{} for _ in range(outside.size)]
    for at, body, part in zip(row.tolist(), (places % bodies).tolist(), values.tolist(), strict=True):
        rows[at][body] = part
    return rows


def _not_reached(rows: Rows, bodies: int) -> list[int]:
    """Return the bodies that the walk from the ground does not reach."""
    rows_of: list[list[int]] = [[] for _ in range(bodies)]
    for index, row in enumerate(rows):
        for body in row:
            rows_of[body].append(index)
    basis: list[list[list[float]]] = [[] for _ in range(bodies)]
    waiting = [len(row) for row in rows]
    ready = deque(index for index, count in enumerate(waiting) if count == 1)
    while ready:
        index = ready.popleft()
        for body in [body for body in rows[index] if len(basis[body]) < 3]:  # the free body, if it is not held yet
            _extend(basis[body], rows[index][body])
            if len(basis[body]) == 3:
                for other in rows_of[body]:
                    waiting[other] -= 1
                    if waiting[other] == 1:
                        ready.append(other)
    return [body for body in range(bodies) if len(basis[body]) < 3]


def _extend(basis: list[list[float]], part: list[float]) -> None:
    """Add the part that is independent of the basis to it (Gram-Schmidt). Two passes are enough (Kahan)."""
    x, y, z = part
    for _ in range(2):
        for a, b, c in basis:
            inner = a * x + b * y + c * z
            x, y, z = x - inner * a, y - inner * b, z - inner * c
    norm = np.sqrt(x * x + y * y + z * z)
    if norm > THRESHOLDS.dependent:
        basis.append([x / norm, y / norm, z / norm])


def _pieces(rows: Rows, free: list[int]) -> list[tuple[list[int], Rows]]:
    """Return the free bodies in connected pieces, each with its rows, without the entries of bodies that are held."""
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
    """Return the body of a piece that its rows let move most, the first among equals; None where their rank is full.
    For a large piece with too few rows, return the body with the fewest."""
    is_large = len(piece) > THRESHOLDS.large
    if is_large and len(rows) < 3 * len(piece):
        rows_on = Counter(body for row in rows for body in row)
        return min(piece, key=lambda body: rows_on[body])
    place = {body: index for index, body in enumerate(piece)}
    row = [number for number, parts in enumerate(rows) for _ in parts]
    column = [place[body] for parts in rows for body in parts]
    values = numbers([part for parts in rows for part in parts.values()]).reshape(-1, 3)
    free = _some_free_motions if is_large else _free_motions
    motions = free(np.array(row, dtype=np.intp), np.array(column, dtype=np.intp), values, (len(rows), len(piece)))
    if not len(motions):
        return None
    moved = np.linalg.norm(motions, axis=(0, 2))
    return piece[int(np.argmax(moved > (1.0 - THRESHOLDS.rounded) * moved.max()))]


def _free_motions(row: Integers, body: Integers, values: Array, shape: tuple[int, int]) -> Array:
    """Return a basis (k, b, 3) of the motions that all rows allow, from the rows' entries (e, 3)."""
    matrix = np.zeros((*shape, 3), like=values)
    matrix[row, body] = values
    _, values, vectors = np.linalg.svd(matrix.reshape(shape[0], 3 * shape[1]), full_matrices=True)
    motions: Array = vectors[np.count_nonzero(values > THRESHOLDS.dependent) :].reshape(-1, shape[1], 3)
    return motions


def _some_free_motions(row: Integers, body: Integers, values: Array, shape: tuple[int, int]) -> Array:
    """Return some random motions of a large piece that all rows allow, by inverse iteration with a sparse factor of
    RᵀR. A motion counts as allowed where the rows resist it by less than the root of the shift; the scene then runs in
    space."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    column = (3 * body[:, None] + np.arange(3)).ravel()
    R = sparse.csr_array((values.ravel(), (np.repeat(row, 3), column)), shape=(shape[0], 3 * shape[1]))
    shift = THRESHOLDS.no_digits
    shifted = (R.T @ R + shift * sparse.eye_array(3 * shape[1])).tocsc()
    factor = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    motions = np.random.default_rng(SEED).normal(size=(3 * shape[1], MOTIONS))
    for _ in range(PASSES):
        motions = factor.solve(motions)
        motions /= np.linalg.norm(motions, axis=0)
    allowed = np.linalg.norm(R @ motions, axis=0) < math.sqrt(shift)
    return np.asarray(motions[:, allowed].T.reshape(-1, shape[1], 3))
