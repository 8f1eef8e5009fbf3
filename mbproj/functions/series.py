"""Evaluation of a program with exact first and second derivatives: Taylor arithmetic, truncated after the second order.

Every value on the stack is a `Series` (x, x', x''), derivatives with respect to the time, arrays of one shape. The
rules are the product, quotient and chain rules (Griewank & Walther 2008, ch. 13); nothing is differenced.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import final, overload

import numpy as np

from mbproj.arrays import Array, Integers, Numbers, numbers
from mbproj.functions.program import ARGUMENTS, Op
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.switches import FREE, lifted, pieces
from mbproj.functions.taylor import FUNCTIONS, OPERATIONS, Series, chain, power

#: The operations with an operand. To look up a member of an enumeration takes as long as a sum.
CONSTANT, VARIABLE, TABLE, POWER = Op.CONSTANT, Op.VARIABLE, Op.TABLE, Op.POWER


def time_series(t: Numbers) -> Series:
    """Return the series of the time: (t, 1, 0)."""
    t = np.asarray(t, dtype=float)
    return t, np.ones_like(t), np.zeros_like(t)


def constant_series(x: Numbers) -> Series:
    """Return the series of a value taken as constant, with derivatives of 0."""
    x = numbers(x)
    zero = np.zeros(x.shape)
    return x, zero, zero


@final
class Variables(Sequence[Series]):
    """Variables of a program at these `values`: constants, but for those with a series of their `own`. Each is made on
    first use, as a program names few of many."""

    def __init__(self, values: Sequence[Numbers], own: Mapping[int, Series]) -> None:
        self._values, self._own = values, own

    def __len__(self) -> int:
        return len(self._values)

    @overload
    def __getitem__(self, index: int) -> Series: ...

    @overload
    def __getitem__(self, index: slice) -> list[Series]: ...

    def __getitem__(self, index: int | slice) -> Series | list[Series]:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        return self._own[index] if index in self._own else constant_series(self._values[index])


def run(programs: ProgramSet, index: int, variables: Sequence[Series], held: Array | None = None) -> Series:
    """Return value, first and second derivative of program `index`. Undefined values are NaN or infinite.

    With `held`, switches are on these branches, one for each instruction of the set (see `switches`). This does not
    apply where a branch has no value beyond its end, as the root of a negative number."""
    with np.errstate(all="ignore"):
        stack: list[Series] = []
        for at in range(programs.start[index], programs.start[index + 1]):
            _step(programs, at, stack, variables, held)
    result = stack.pop()
    return result if held is None or np.all(np.isfinite(result[0])) else run(programs, index, variables)


def walk(
    programs: ProgramSet, index: int, variables: Sequence[Series], held: Array | None = None
) -> Iterator[tuple[int, list[Series]]]:
    """Yield the instructions of program `index` one by one, each with the stack before it."""
    stack: list[Series] = []
    for at in range(programs.start[index], programs.start[index + 1]):
        yield at, stack
        _step(programs, at, stack, variables, held)


def slope(programs: ProgramSet, index: int, at: Sequence[Numbers], variable: int) -> Numbers:
    """Return the partial derivative of program `index` by variable number `variable` at values of the variables.
    Undefined values are NaN or infinite."""
    return run(programs, index, Variables(at, {variable: time_series(at[variable])}))[1]


def slopes(programs: ProgramSet, index: int, at: Sequence[Numbers], variables: Integers) -> Array:
    """Return the partial derivatives by each of these variables, (k,), at one point."""
    none, rows = np.zeros(len(variables)), np.eye(len(variables))
    own = {k: (np.full(len(row), at[k]), row, none) for k, row in zip(variables.tolist(), rows, strict=True)}
    return np.broadcast_to(run(programs, index, Variables(at, own))[1], none.shape)


def failure(programs: ProgramSet, index: int, variables: Sequence[Series]) -> str:
    """Return the cause, in words, of a value that is not finite at one point: "sqrt(-0.25) is not finite"."""
    with np.errstate(all="ignore"):
        stack: list[Series] = []
        for at in range(programs.start[index], programs.start[index + 1]):
            op = programs.operations[at]
            given = ", ".join(f"{float(x[0]):.6g}" for x in stack[len(stack) - ARGUMENTS[op] :])
            _step(programs, at, stack, variables)
            if not np.all(np.isfinite(np.array(stack[-1]))):
                what = "is" if not np.isfinite(stack[-1][0]) else "has a derivative that is"
                return f"{op.name.lower()}({given}) {what} not finite"
    return "it is not finite"


def _step(
    programs: ProgramSet, at: int, stack: list[Series], variables: Sequence[Series], held: Array | None = None
) -> None:
    """Execute instruction number `at`, on the branch that is held."""
    op, operand = programs.operations[at], programs.operand[at].item()
    if held is not None and not np.isnan(held[at]):
        stack.append(_on_branch(programs, at, stack, float(held[at])))
    elif op is CONSTANT:
        stack.append(constant_series(np.where(True, operand, variables[0][0].real)))  # in the shape of the time
    elif op is VARIABLE:
        stack.append(variables[int(operand)])
    elif op is TABLE:
        x = stack.pop()
        stack.append(chain(table_series(programs, int(operand), x[0]), x))
    elif op is POWER:
        stack.append(chain(power(stack[-1][0], operand), stack.pop()))
    elif op in FUNCTIONS:
        stack.append(chain(FUNCTIONS[op](stack[-1][0]), stack.pop()))
    else:
        second, first = stack.pop(), stack.pop()
        stack.append(OPERATIONS[op](first, second))


def _on_branch(programs: ProgramSet, at: int, stack: list[Series], branch: float) -> Series:
    """Return the value of a switch on one of its branches; its arguments are taken from the stack."""
    op, x = programs.operations[at], stack.pop()
    if op in (Op.MIN, Op.MAX):
        first = stack.pop()
        return first if (branch > 0.0) == (op is Op.MAX) else x
    if op is Op.ABS:
        return branch * x[0], branch * x[1], branch * x[2]
    if op is Op.TABLE:
        return chain(table_series(programs, int(programs.operand[at]), x[0], branch), x)
    return constant_series(np.full_like(x[0], branch))


def table_series(programs: ProgramSet, number: int, x: Numbers, branch: float = FREE) -> Series:
    """Return the piece of table `number` that contains x, or the nearest piece of a branch, at x."""
    start, end = programs.table_start[number : number + 2]
    x = lifted(programs, number, x, branch)
    first, last = (start, end - 1) if np.isnan(branch) else pieces(programs, number, branch)
    at = np.clip(start - 1 + np.searchsorted(programs.knot[start:end], x, side="right"), first, last)
    c = programs.piece[at]
    u = x - programs.origin[at]
    c0, c1, c2, c3 = (c[..., i] for i in range(4))
    return c0 + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + 3.0 * u * c3), 2.0 * c2 + 6.0 * u * c3
