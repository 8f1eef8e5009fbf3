"""Switches: instructions of functions whose branch changes with the state (`abs sign min max floor ceil`, tables with
kinks).

A switch has one argument x: the argument of its instruction, or the difference of two arguments. Each branch holds in
an interval of x. A held branch is continued smoothly beyond its interval, so that an integrator keeps its order; where
x leaves the interval there is an event. A branch is a number: -1 or 1 for the sign of x, the value of `floor` and
`ceil`, or the first piece of a table between two of its kinks. NaN is free: the branch follows x.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.arrays import Integers, Numbers
from mbproj.functions.program import ARGUMENTS, TIME, Op
from mbproj.functions.program_set import ProgramSet

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
        if of_state and op in SWITCHING and (op is not Op.TABLE or len(_branches(programs, at)) > 1):
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
        first, x = _branches(programs, at), float(lifted(programs, int(programs.operand[at]), np.asarray(x)))
        return float(first[np.searchsorted(programs.knot[first], x, side="right") - 1])
    return float(np.floor(x) if op is Op.FLOOR else np.ceil(x))


def argument(programs: ProgramSet, at: int, held: float, given: Sequence[Numbers]) -> float:
    """Return x of a switch on a branch, from the values on the stack. For a periodic table x is moved near the
    branch."""
    op = Op(int(programs.op[at]))
    if op in (Op.MIN, Op.MAX):
        return float(given[-2] - given[-1])
    return float(lifted(programs, int(programs.operand[at]), given[-1], held) if op is Op.TABLE else given[-1])


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


def _branches(programs: ProgramSet, at: int) -> Integers:
    """Return the pieces with which the branches of a table begin."""
    number = int(programs.operand[at])
    start, end = programs.table_start[number : number + 2]
    return start + np.flatnonzero(programs.kinked[start:end])
