"""Sparse matrices over the tangent coordinates of bodies, as blocks of 6 × 6 and rows of 6; dense, or SciPy's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


@dataclass(frozen=True, eq=False)
class Blocks:
    """A matrix (6n, 6n): block e (6, 6) of `value` (e, 6, 6) couples body `row` (e,) with body `column` (e,). Blocks of
    one pair add up. The ground has no coordinates, and therefore no blocks."""

    bodies: int
    row: Integers
    column: Integers
    value: Array

    @classmethod
    def of(cls, bodies: int, row: Integers, column: Integers, value: Array) -> Blocks:
        """Return the blocks between moving bodies; blocks of the ground, index `bodies`, are dropped."""
        moves = (row < bodies) & (column < bodies)
        return cls(bodies, row[moves], column[moves], value[moves])

    def matrix(self) -> Array | csr_matrix:
        """Return the matrix (6n, 6n), sparse for large mechanisms."""
        return self.sparse() if self.bodies > THRESHOLDS.large else self.dense()

    def dense(self) -> Array:
        """Return the dense matrix (6n, 6n)."""
        matrix = np.zeros((self.bodies, self.bodies, 6, 6))
        np.add.at(matrix, (self.row, self.column), self.value)
        return np.ascontiguousarray(matrix.transpose(0, 2, 1, 3)).reshape(6 * self.bodies, 6 * self.bodies)

    def sparse(self) -> csr_matrix:
        """Return the matrix (6n, 6n) as SciPy's sparse matrix."""
        from scipy.sparse import coo_matrix

        six = np.arange(6)
        row = np.broadcast_to(6 * self.row[:, None, None] + six[:, None], self.value.shape)
        column = np.broadcast_to(6 * self.column[:, None, None] + six, self.value.shape)
        places = (row.ravel(), column.ravel())
        return coo_matrix((self.value.ravel(), places), shape=(6 * self.bodies,) * 2).tocsr()

    def scaled(self, factor: float) -> Blocks:
        """Return the matrix times a factor."""
        return Blocks(self.bodies, self.row, self.column, factor * self.value)


def added(bodies: int, parts: Sequence[Blocks]) -> Blocks:
    """Return the sum of matrices over `bodies` bodies."""
    none = Blocks(bodies, np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp), np.zeros((0, 6, 6)))
    joined = [none, *parts]
    row, column = (np.concatenate([getattr(part, name) for part in joined]) for name in ("row", "column"))
    return Blocks(bodies, row, column, np.concatenate([part.value for part in joined]))


def on_diagonal(value: Array) -> Blocks:
    """Return the matrix with the diagonal blocks `value` (n, 6, 6), one a body."""
    every = np.arange(len(value))
    return Blocks(len(value), every, every, value)


@dataclass(frozen=True, eq=False)
class Rows:
    """A matrix (m, 6n): entry e of `value` (e, 6) is the part of row `row` (e,) for body `body` (e,). Entries of one
    pair add up."""

    count: int
    bodies: int
    row: Integers
    body: Integers
    value: Array

    @classmethod
    def of(cls, count: int, bodies: int, row: Integers, body: Integers, value: Array) -> Rows:
        """Return the entries of moving bodies; entries of the ground, index `bodies`, are dropped."""
        moves = body < bodies
        return cls(count, bodies, row[moves], body[moves], value[moves])

    def times(self, x: Array) -> Array:
        """Return the product (m,) with x (6n,), or (m, k) with x (6n, k)."""
        product = np.zeros((self.count, *x.shape[1:]))
        np.add.at(product, self.row, np.einsum("ej,ej...->e...", self.value, x.reshape(-1, 6, *x.shape[1:])[self.body]))
        return product

    def scaled(self, factor: Array) -> Rows:
        """Return the rows, each multiplied by its factor (m,)."""
        return Rows(self.count, self.bodies, self.row, self.body, factor[self.row, None] * self.value)

    def combined(self, matrix: Array) -> Rows:
        """Return the product of a matrix (k, m) with these rows."""
        row, entry = np.nonzero(matrix[:, self.row])
        value = matrix[row, self.row[entry], None] * self.value[entry]
        return Rows(len(matrix), self.bodies, row, self.body[entry], value)

    def chosen(self, rows: Integers) -> Rows:
        """Return the chosen rows (k,) in this order; each may be chosen once."""
        place = np.full(self.count, -1, dtype=np.intp)
        place[rows] = np.arange(len(rows))
        mine = place[self.row] >= 0
        return Rows(len(rows), self.bodies, place[self.row[mine]], self.body[mine], self.value[mine])

    def at(self, row: int) -> Array:
        """Return one row, (6n,)."""
        return self.chosen(np.array([row])).dense()[0]

    def matrix(self) -> Array | csr_matrix:
        """Return the matrix (m, 6n), sparse for large mechanisms."""
        return self.sparse() if self.bodies > THRESHOLDS.large else self.dense()

    def dense(self) -> Array:
        """Return the dense matrix (m, 6n)."""
        matrix = np.zeros((self.count, self.bodies, 6), like=self.value)
        np.add.at(matrix, (self.row, self.body), self.value)
        return matrix.reshape(self.count, 6 * self.bodies)

    def sparse(self) -> csr_matrix:
        """Return the matrix (m, 6n) as SciPy's sparse matrix."""
        from scipy.sparse import coo_matrix

        row = np.broadcast_to(self.row[:, None], self.value.shape)
        column = 6 * self.body[:, None] + np.arange(6)
        return coo_matrix((self.value.ravel(), (row.ravel(), column.ravel())), (self.count, 6 * self.bodies)).tocsr()


def stacked(bodies: int, parts: Sequence[Rows]) -> Rows:
    """Return the parts as one matrix, one below another."""
    first = np.cumsum([0, *(part.count for part in parts)])
    joined = [Rows(0, bodies, np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp), np.zeros((0, 6))), *parts]
    row = np.concatenate([part.row + start for part, start in zip(joined, [0, *first], strict=False)])
    body, value = (np.concatenate([getattr(part, name) for part in joined]) for name in ("body", "value"))
    return Rows(int(first[-1]), bodies, row, body, value)


def summed(parts: Sequence[Rows]) -> Rows:
    """Return the sum of matrices with the same number of rows."""
    row, body, value = (np.concatenate([getattr(part, name) for part in parts]) for name in ("row", "body", "value"))
    return Rows(parts[0].count, parts[0].bodies, row, body, value)


def products(left: Rows, right: Rows, weight: Array) -> Blocks:
    """Return Σ weight leftᵀ right over the rows, (6n, 6n). Each row has few entries."""
    order = np.argsort(right.row, kind="stable")
    start = np.searchsorted(right.row[order], np.arange(right.count + 1))
    lengths = (start[1:] - start[:-1])[left.row]
    first = np.repeat(np.arange(len(left.row)), lengths)
    within = np.arange(len(first)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    second = order[start[left.row[first]] + within]
    value = weight[left.row[first], None, None] * left.value[first][:, :, None] * right.value[second][:, None, :]
    return Blocks(left.bodies, left.body[first], right.body[second], value)
