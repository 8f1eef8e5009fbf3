"""Many programs as flat arrays, for evaluators in NumPy or in compiled code."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers, Numbers, numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.program import ARGUMENTS, CHANNELS, TIME, Instruction, Op, Program
from mbproj.functions.table import CubicTable

#: Changes of a function's value, slope and second derivative up to this part of the largest are round-off.
ROUND_OFF = np.array([THRESHOLDS.rounding, THRESHOLDS.same_written, THRESHOLDS.same_written])
#: The number of derivatives, with the value, whose jumps are kinks: for functions in accelerations, and for functions
#: in rows, which are differentiated twice.
OF_FORCES, OF_ROWS = 2, 3


@dataclass(frozen=True, eq=False)
class ProgramSet:
    """P programs of N instructions: program p is instructions `start[p]` to `start[p + 1]`, `start` (P+1,).

    `op` (N,) the operations by number (`Op`), `operand` (N,) a constant, an exponent, the number of a variable or of a
    table. Tables: piece i of table k is row `table_start[k] + i` of `knot`, `origin` (B,) and `piece` (B, 4) (see
    `CubicTable`). `period` (T,): the period with which each table repeats. `smooth` (T,): the number of derivatives
    that jump only at kinks. `texts`: the text of each in the scene; `reads`: the names in it.
    """

    start: Integers
    op: Integers
    operand: Array
    table_start: Integers
    knot: Array
    origin: Array
    piece: Array
    period: Array
    smooth: Integers
    texts: tuple[str, ...]
    reads: tuple[tuple[str, ...], ...]

    @property
    def size(self) -> int:
        """P."""
        return len(self.start) - 1

    @cached_property
    def operations(self) -> tuple[Op, ...]:
        """The operations of all instructions, (N,)."""
        return tuple(map(Op, self.op.tolist()))

    def program(self, index: int) -> Program:
        """Return program `index`, as `flatten` took it."""
        span = slice(*self.start[index : index + 2].tolist())
        code = zip(self.op[span].tolist(), self.operand[span].tolist(), strict=True)
        return Program(
            tuple(
                Instruction(Op.TABLE, 0.0, self._table(int(operand)))
                if op == Op.TABLE
                else Instruction(Op(op), operand)
                for op, operand in code
            ),
            self.texts[index],
            self.reads[index],
        )

    def _table(self, number: int) -> CubicTable:
        span = slice(*self.table_start[number : number + 2].tolist())
        pieces = tuple((c0, c1, c2, c3) for c0, c1, c2, c3 in self.piece[span].tolist())

        return CubicTable(
            tuple(self.knot[span].tolist()), tuple(self.origin[span].tolist()), pieces, float(self.period[number])
        )

    def branches(self, index: int, held: Array) -> tuple[float, ...]:
        """Return the branches `held` of program `index`, one for each instruction, in the numbering of a set of this
        program alone: its tables begin with the first piece."""
        code = slice(self.start[index], self.start[index + 1])
        tables = self.op[code] == Op.TABLE
        before = self.table_start[self.operand[code][tables].astype(np.intp)[:1]]
        return tuple(np.where(tables, held[code] - before.sum(), held[code]).tolist())

    def names_channels(self, index: int) -> bool:
        """Return whether program `index` names channels."""
        return bool(len(self.channels(index)))

    def channels(self, index: int) -> Integers:
        """Return the channels that a program names, as numbers of variables, each once."""
        code = slice(self.start[index], self.start[index + 1])
        named = self.operand[code][self.op[code] == Op.VARIABLE].astype(np.intp)
        return np.unique(named[named >= CHANNELS])

    @cached_property
    def kinked(self) -> npt.NDArray[np.bool_]:
        """Whether each piece of tables begins with a kink, where the value or a derivative that counts jumps, (B,). The
        first piece of each table counts, too.

        A periodic table with kinks has at most half a period from one of these to the next, unless one piece is longer.
        Then a place near one of them is nearer to it than to its repetition."""
        is_kinked: npt.NDArray[np.bool_] = np.ones(len(self.knot), dtype=bool)
        for number, period in enumerate(self.period.tolist()):
            start, end = self.table_start[number : number + 2].tolist()
            kinks = np.any(self.jumps(number)[:, : self.smooth[number] + 1], axis=1)
            is_kinked[start + 1 : end] = kinks[: end - start - 1]
            begun, reach = self.knot[start], 0.5 * period if kinks.any() else np.inf
            for at in range(start + 1, end) if period else ():
                after = self.knot[at + 1] if at + 1 < end else self.knot[start] + period
                is_kinked[at] |= after - begun > reach
                begun = self.knot[at] if is_kinked[at] else begun
        return is_kinked

    def jumps(self, number: int) -> npt.NDArray[np.bool_]:
        """Return whether the value and three derivatives of a table jump at the start of each piece but the first,
        (pieces, 4) or one less. For a periodic table the last row is the start of the first piece again."""
        start, end = self.table_start[number : number + 2]
        origin, piece, period = self.origin[start:end], self.piece[start:end], self.period[number]
        ends = np.append(self.knot[start + 1 : end], [self.knot[start] + period] if period else [])
        count, after = len(ends), np.arange(1, len(ends) + 1) % len(piece)
        before = _derivatives(piece[:count], ends - origin[:count])
        behind = _derivatives(piece[after], np.where(after, ends, ends - period) - origin[after])
        largest = np.maximum(np.abs(before), np.abs(behind)).max(axis=0, initial=0.0)
        return np.asarray(np.abs(behind - before) > [*ROUND_OFF, THRESHOLDS.same_written] * largest)


def _derivatives(piece: Array, u: Array) -> Array:
    """Return value and derivatives of cubics (n, 4) at u (n,), (n, 4)."""
    c0, c1, c2, c3 = piece.T
    value = c0 + u * (c1 + u * (c2 + u * c3))
    return np.column_stack([value, c1 + u * (2.0 * c2 + 3.0 * u * c3), 2.0 * c2 + 6.0 * u * c3, 6.0 * c3])


def joined(sets: Sequence[ProgramSet]) -> ProgramSet:
    """Return sets one after another, with consecutive numbers of programs and tables."""
    start, table_start, operand = [np.zeros(1, np.intp)], [np.zeros(1, np.intp)], []
    code = pieces = tables = 0
    for each in sets:
        start.append(each.start[1:] + code)
        table_start.append(each.table_start[1:] + pieces)
        operand.append(np.where(each.op == Op.TABLE, each.operand + tables, each.operand))
        code, pieces, tables = code + len(each.op), pieces + len(each.knot), tables + len(each.table_start) - 1
    rest = {
        name: np.concatenate([getattr(each, name) for each in sets])
        for name in ("op", "knot", "origin", "piece", "period", "smooth")
    }
    return ProgramSet(
        start=np.concatenate(start),
        operand=np.concatenate(operand),
        table_start=np.concatenate(table_start),
        texts=tuple(text for each in sets for text in each.texts),
        reads=tuple(names for each in sets for names in each.reads),
        **rest,
    )


def flatten(programs: Sequence[Program], smooth: int = OF_FORCES) -> ProgramSet:
    """Return the programs as a set, with consecutive numbers of their tables."""
    code = [instruction for program in programs for instruction in program.code]
    tables = [instruction.table for instruction in code if instruction.table is not None]
    tables_before = iter(range(len(tables)))
    return ProgramSet(
        start=np.cumsum([0, *(len(program.code) for program in programs)], dtype=np.intp),
        op=np.array([instruction.op for instruction in code], dtype=np.intp),
        operand=numbers([next(tables_before) if each.op is Op.TABLE else each.operand for each in code]),
        table_start=np.cumsum([0, *(len(table.knots) for table in tables)], dtype=np.intp),
        knot=np.array([knot for table in tables for knot in table.knots], dtype=float),
        origin=numbers([origin for table in tables for origin in table.origins]),
        piece=numbers([piece for table in tables for piece in table.pieces]).reshape(-1, 4),
        period=np.array([table.period for table in tables]),
        smooth=np.full(len(tables), smooth, dtype=np.intp),
        texts=tuple(program.text for program in programs),
        reads=tuple(program.reads for program in programs),
    )


# --- The parts of programs that are functions of time alone -----------------------------------------------------------
# A whole program, or the factor of a coordinate in a law.


class _Value(NamedTuple):
    """A value on the stack: its first instruction, and whether it depends on the time (`timed`), and on anything else
    (`stated`)."""

    first: int
    timed: bool
    stated: bool


def time_parts(programs: ProgramSet, index: int) -> tuple[ProgramSet, ...]:
    """Return the largest parts of program `index` that depend on time alone, each as the one program of a set."""
    return tuple(
        replace(programs, start=np.array([first, last])) for first, last in _ranges(programs, index) if last - first > 1
    )


def _ranges(programs: ProgramSet, index: int) -> Iterator[tuple[int, int]]:
    """Yield the instructions of these parts, from the first to the one after the last."""
    stack: list[_Value] = []
    end = int(programs.start[index + 1])
    for at in range(int(programs.start[index]), end):
        op = Op(int(programs.op[at]))
        if op <= Op.VARIABLE:
            variable = op is Op.VARIABLE
            timed = variable and int(programs.operand[at]) == TIME
            stack.append(_Value(at, timed, variable and not timed))
            continue
        arguments = stack[len(stack) - ARGUMENTS[op] :]
        stated = any(value.stated for value in arguments)
        if stated:
            ends = [*(value.first for value in arguments[1:]), at]
            yield from ((value.first, last) for value, last in zip(arguments, ends, strict=True) if _is_of_time(value))
        stack[len(stack) - ARGUMENTS[op] :] = [
            _Value(arguments[0].first, any(value.timed for value in arguments), stated)
        ]
    if _is_of_time(stack[0]):
        yield stack[0].first, end


def _is_of_time(value: _Value) -> bool:
    return value.timed and not value.stated


# --- Switches ---------------------------------------------------------------------------------------------------------
# Instructions of functions whose branch changes with the state (`abs sign min max floor ceil`, tables with kinks).
# A switch has one argument x: the argument of its instruction, or the difference of two arguments. Each branch holds
# in an interval of x. A held branch is continued smoothly beyond its interval, so that an integrator keeps its order;
# where x leaves the interval there is an event. A branch is a number: -1 or 1 for the sign of x, the value of `floor`
# and `ceil`, or the first piece of a table between two of its kinks. NaN is free: the branch follows x.


FREE = float("nan")
SIDED = frozenset({Op.ABS, Op.SIGN, Op.MIN, Op.MAX})
SWITCHING = SIDED | {Op.FLOOR, Op.CEIL, Op.TABLE}
#: The operations whose value jumps where the branch changes, not only the slope.
JUMPING = frozenset({Op.SIGN, Op.FLOOR, Op.CEIL})


def switches(programs: ProgramSet, index: int) -> Iterator[int]:
    """Yield the numbers of the instructions of program `index` that are switches."""
    stack: list[bool] = []
    for at in range(int(programs.start[index]), int(programs.start[index + 1])):
        op, operand = Op(int(programs.op[at])), programs.operand[at]
        taken = ARGUMENTS[op]
        of_state = any(stack[len(stack) - taken :]) if taken else op is Op.VARIABLE and int(operand) != TIME
        if of_state and op in SWITCHING and (op is not Op.TABLE or len(_pieces_of_branches(programs, at)) > 1):
            yield at
        stack[len(stack) - taken :] = [of_state]


def all_switches(programs: ProgramSet) -> list[tuple[int, int]]:
    """Return the switches of all programs, one after another: (program, instruction)."""
    return [(index, at) for index in range(programs.size) for at in switches(programs, index)]


def natural(programs: ProgramSet, at: int, x: float) -> float:
    """Return the branch at x; free where x is on the edge of two signs, or not finite."""
    op = Op(int(programs.op[at]))
    if not np.isfinite(x):
        return FREE
    if op in SIDED:
        return float(np.sign(x)) or FREE
    if op is Op.TABLE:
        first, x = _pieces_of_branches(programs, at), float(lifted(programs, int(programs.operand[at]), np.asarray(x)))
        return float(first[np.searchsorted(programs.knot[first], x, side="right") - 1])
    return float(np.floor(x) if op is Op.FLOOR else np.ceil(x))


def argument(programs: ProgramSet, at: int, held: float, arguments: Sequence[Numbers]) -> float:
    """Return x of a switch on a branch, from the values on the stack. For a periodic table x is moved near the
    branch."""
    op = Op(int(programs.op[at]))
    if op in (Op.MIN, Op.MAX):
        return float(arguments[-2] - arguments[-1])
    return float(lifted(programs, int(programs.operand[at]), arguments[-1], held) if op is Op.TABLE else arguments[-1])


def lifted(programs: ProgramSet, number: int, x: Numbers, branch: float = FREE) -> Numbers:
    """Return x (...) minus whole periods, nearest to a branch of a table; for a free branch it is in the first
    period."""
    period = programs.period[number]
    if not period:
        return x
    if np.isnan(branch):
        return x - period * np.floor((x.real - programs.knot[programs.table_start[number]]) / period)
    return x - period * np.round((x.real - 0.5 * sum(_ends(programs, number, branch))) / period)


def pieces(programs: ProgramSet, number: int, branch: float) -> tuple[int, int]:
    """Return the first and the last piece of a table's branch."""
    end = programs.table_start[number + 1]
    after = np.flatnonzero(programs.kinked[int(branch) + 1 : end])
    return int(branch), int(branch + after[0] if len(after) else end - 1)


def _ends(programs: ProgramSet, number: int, branch: float) -> tuple[float, float]:
    """Return where a table's branch begins and ends."""
    (start, end), period = programs.table_start[number : number + 2], programs.period[number]
    first, last = pieces(programs, number, branch)
    high = programs.knot[last + 1] if last + 1 < end else programs.knot[start] + period if period else np.inf
    return float(programs.knot[first]), float(high)


def _pieces_of_branches(programs: ProgramSet, at: int) -> Integers:
    """Return the pieces with which the branches of a table begin."""
    number = int(programs.operand[at])
    start, end = programs.table_start[number : number + 2]
    return start + np.flatnonzero(programs.kinked[start:end])
