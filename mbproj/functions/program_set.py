"""Many programs as flat arrays: what an evaluator needs, in NumPy or in compiled code."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.functions.program import CHANNELS, Op, Program
from mbproj.thresholds import THRESHOLDS

#: Changes of a function's value, slope and second derivative up to this part of the largest are round-off.
ROUND_OFF = np.array([THRESHOLDS.constant_to, THRESHOLDS.smooth_to, THRESHOLDS.smooth_to])


@dataclass(frozen=True, eq=False)
class ProgramSet:
    """P programs of N instructions: program p is instructions `start[p]` to `start[p + 1]`, `start` (P+1,).

    `op` (N,) the operations by number (`Op`), `operand` (N,) a constant, an exponent, the number of a variable or of a
    table. Tables: piece i of table k is row `table_start[k] + i` of `knot`, `origin` (B,) and `piece` (B, 4) (see
    `Table`). `texts`: how the scene writes each.
    """

    start: Integers
    op: Integers
    operand: Array
    table_start: Integers
    knot: Array
    origin: Array
    piece: Array
    texts: tuple[str, ...]

    @property
    def size(self) -> int:
        """P."""
        return len(self.start) - 1

    def names_channels(self, index: int) -> bool:
        """Whether program `index` does."""
        code = slice(self.start[index], self.start[index + 1])
        return bool(np.any((self.op[code] == Op.VARIABLE) & (self.operand[code] >= CHANNELS)))

    @cached_property
    def kinked(self) -> npt.NDArray[np.bool_]:
        """The pieces of tables that begin with a kink, where the value, the slope or the second derivative jumps, and
        the first of each table, (B,)."""
        found = np.ones(len(self.knot), dtype=bool)
        for start, end in zip(self.table_start[:-1], self.table_start[1:], strict=True):
            knot, origin, piece = self.knot[start + 1 : end], self.origin[start:end], self.piece[start:end]
            before, after = _derivatives(piece[:-1], knot - origin[:-1]), _derivatives(piece[1:], knot - origin[1:])
            largest = np.maximum(np.abs(before), np.abs(after)).max(axis=0, initial=0.0)
            found[start + 1 : end] = np.any(np.abs(after - before) > ROUND_OFF * largest, axis=1)
        return found


def _derivatives(piece: Array, u: Array) -> Array:
    """Value, slope and second derivative of cubics (n, 4) at u (n,), (n, 3)."""
    c0, c1, c2, c3 = piece.T
    value = c0 + u * (c1 + u * (c2 + u * c3))
    return np.column_stack([value, c1 + u * (2.0 * c2 + 3.0 * u * c3), 2.0 * c2 + 6.0 * u * c3])


def joined(sets: Sequence[ProgramSet]) -> ProgramSet:
    """Sets one after another, their programs and tables numbered through."""
    start, table_start, operand = [np.zeros(1, np.intp)], [np.zeros(1, np.intp)], []
    code = pieces = tables = 0
    for each in sets:
        start.append(each.start[1:] + code)
        table_start.append(each.table_start[1:] + pieces)
        operand.append(np.where(each.op == Op.TABLE, each.operand + tables, each.operand))
        code, pieces, tables = code + len(each.op), pieces + len(each.knot), tables + len(each.table_start) - 1
    rest = {name: np.concatenate([getattr(each, name) for each in sets]) for name in ("op", "knot", "origin", "piece")}
    return ProgramSet(
        start=np.concatenate(start),
        operand=np.concatenate(operand),
        table_start=np.concatenate(table_start),
        texts=tuple(text for each in sets for text in each.texts),
        **rest,
    )


def flatten(programs: Sequence[Program]) -> ProgramSet:
    """The programs one after another, their tables numbered through."""
    code = [instruction for program in programs for instruction in program.code]
    tables = [instruction.table for instruction in code if instruction.table is not None]
    numbers = iter(range(len(tables)))
    return ProgramSet(
        start=np.cumsum([0, *(len(program.code) for program in programs)], dtype=np.intp),
        op=np.array([instruction.op for instruction in code], dtype=np.intp),
        operand=np.array([next(numbers) if each.op is Op.TABLE else each.operand for each in code], dtype=float),
        table_start=np.cumsum([0, *(len(table.knots) for table in tables)], dtype=np.intp),
        knot=np.array([knot for table in tables for knot in table.knots], dtype=float),
        origin=np.array([origin for table in tables for origin in table.origins], dtype=float),
        piece=np.array([piece for table in tables for piece in table.pieces], dtype=float).reshape(-1, 4),
        texts=tuple(program.text for program in programs),
    )
