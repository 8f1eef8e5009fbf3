"""Many programs as flat arrays: what an evaluator needs, in NumPy or in compiled code."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.functions.program import Op, Program


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
