"""Sparse matrices over the tangent coordinates of bodies, as blocks of 6 × 6 and rows of 6; dense, or SciPy's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


@dataclass(frozen=True, eq=False)
class Blocks:
    """A matrix (6n, 6n): block e (6, 6) of `value` (e, 6, 6) couples body `row` (e,) with body `column` (e,); blocks of
    one pair add up. The ground has no coordinates, so that it has no blocks."""

    bodies: int
    row: Integers
    column: Integers
    value: Array

    @classmethod
    def of(cls, bodies: int, row: Integers, column: Integers, value: Array) -> Blocks:
        """The blocks of bodies that move; the ground is the body of index `bodies`."""
        moves = (row < bodies) & (column < bodies)
        return cls(bodies, row[moves], column[moves], value[moves])

    def matrix(self) -> Array | csr_matrix:
        """(6n, 6n): sparse of large mechanisms."""
        return self.sparse() if self.bodies > THRESHOLDS.dense_modes else self.dense()

    def dense(self) -> Array:
        """(6n, 6n)."""
        found = np.zeros((self.bodies, self.bodies, 6, 6))
        np.add.at(found, (self.row, self.column), self.value)
        return np.ascontiguousarray(found.transpose(0, 2, 1, 3)).reshape(6 * self.bodies, 6 * self.bodies)

    def sparse(self) -> csr_matrix:
        """(6n, 6n), of SciPy."""
        from scipy.sparse import coo_matrix

        six = np.arange(6)
        row = np.broadcast_to(6 * self.row[:, None, None] + six[:, None], self.value.shape)
        column = np.broadcast_to(6 * self.column[:, None, None] + six, self.value.shape)
        places = (row.ravel(), column.ravel())
        return coo_matrix((self.value.ravel(), places), shape=(6 * self.bodies,) * 2).tocsr()

    def scaled(self, factor: float) -> Blocks:
        """So many times the matrix."""
        return Blocks(self.bodies, self.row, self.column, factor * self.value)


def added(bodies: int, parts: Sequence[Blocks]) -> Blocks:
    """The sum of matrices over so many bodies."""
    none = Blocks(bodies, np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp), np.zeros((0, 6, 6)))
    joined = [none, *parts]
    row, column = (np.concatenate([getattr(part, name) for part in joined]) for name in ("row", "column"))
    return Blocks(bodies, row, column, np.concatenate([part.value for part in joined]))


def on_diagonal(value: Array) -> Blocks:
    """A block (n, 6, 6) of each body."""
    every = np.arange(len(value))
    return Blocks(len(value), every, every, value)


@dataclass(frozen=True, eq=False)
class Rows:
    """A matrix (m, 6n): entry e of `value` (e, 6) is what row `row` (e,) has of body `body` (e,); entries of one pair
    add up."""

    count: int
    bodies: int
    row: Integers
    body: Integers
    value: Array

    @classmethod
    def of(cls, count: int, bodies: int, row: Integers, body: Integers, value: Array) -> Rows:
        """The entries of bodies that move; the ground is the body of index `bodies`."""
        moves = body < bodies
        return cls(count, bodies, row[moves], body[moves], value[moves])

    def times(self, x: Array) -> Array:
        """The product (m,) with x (6n,), or (m, k) with x (6n, k)."""
        found = np.zeros((self.count, *x.shape[1:]))
        np.add.at(found, self.row, np.einsum("ej,ej...->e...", self.value, x.reshape(-1, 6, *x.shape[1:])[self.body]))
        return found

    def scaled(self, factor: Array) -> Rows:
        """Each row times its factor (m,)."""
        return Rows(self.count, self.bodies, self.row, self.body, factor[self.row, None] * self.value)

    def combined(self, matrix: Array) -> Rows:
        """The rows (k,) of a matrix (k, m) times these."""
        row, entry = np.nonzero(matrix[:, self.row])
        value = matrix[row, self.row[entry], None] * self.value[entry]
        return Rows(len(matrix), self.bodies, row, self.body[entry], value)

    def chosen(self, rows: Integers) -> Rows:
        """These rows (k,), each once, in their order."""
        place = np.full(self.count, -1, dtype=np.intp)
        place[rows] = np.arange(len(rows))
        mine = place[self.row] >= 0
        return Rows(len(rows), self.bodies, place[self.row[mine]], self.body[mine], self.value[mine])

    def at(self, row: int) -> Array:
        """One row, (6n,)."""
        return self.chosen(np.array([row])).dense()[0]

    def matrix(self) -> Array | csr_matrix:
        """(m, 6n): sparse of large mechanisms."""
        return self.sparse() if self.bodies > THRESHOLDS.dense_modes else self.dense()

    def dense(self) -> Array:
        """(m, 6n)."""
        found = np.zeros((self.count, self.bodies, 6))
        np.add.at(found, (self.row, self.body), self.value)
        return found.reshape(self.count, 6 * self.bodies)

    def sparse(self) -> csr_matrix:
        """(m, 6n), of SciPy."""
        from scipy.sparse import coo_matrix

        row = np.broadcast_to(self.row[:, None], self.value.shape)
        column = 6 * self.body[:, None] + np.arange(6)
        return coo_matrix((self.value.ravel(), (row.ravel(), column.ravel())), (self.count, 6 * self.bodies)).tocsr()


def stacked(bodies: int, parts: Sequence[Rows]) -> Rows:
    """Rows one after another."""
    first = np.cumsum([0, *(part.count for part in parts)])
    joined = [Rows(0, bodies, np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp), np.zeros((0, 6))), *parts]
    row = np.concatenate([part.row + start for part, start in zip(joined, [0, *first], strict=False)])
    body, value = (np.concatenate([getattr(part, name) for part in joined]) for name in ("body", "value"))
    return Rows(int(first[-1]), bodies, row, body, value)


def summed(parts: Sequence[Rows]) -> Rows:
    """Rows of the same number, added."""
    row, body, value = (np.concatenate([getattr(part, name) for part in parts]) for name in ("row", "body", "value"))
    return Rows(parts[0].count, parts[0].bodies, row, body, value)


def products(left: Rows, right: Rows, weight: Array) -> Blocks:
    """Σ weight leftᵀ right over the rows, which are few entries each: (6n, 6n)."""
    order = np.argsort(right.row, kind="stable")
    start = np.searchsorted(right.row[order], np.arange(right.count + 1))
    lengths = (start[1:] - start[:-1])[left.row]
    first = np.repeat(np.arange(len(left.row)), lengths)
    within = np.arange(len(first)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    second = order[start[left.row[first]] + within]
    value = weight[left.row[first], None, None] * left.value[first][:, :, None] * right.value[second][:, None, :]
    return Blocks(left.bodies, left.body[first], right.body[second], value)
