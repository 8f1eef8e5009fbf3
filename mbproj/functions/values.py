"""Values of programs without derivatives. Each term that several programs share is computed once.

The programs of an element repeat long terms: a flow stands in the rates of two pressures and in the heat. So programs
are turned into a list of distinct terms, each of which names its arguments, before they are evaluated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from mbproj.base.arrays import Array, Numbers, numbers
from mbproj.functions.program import ARGUMENTS, Op
from mbproj.functions.program_set import FREE, ProgramSet
from mbproj.functions.series import LN10, direction, hypotenuse, smooth_step, table_series

Function = Callable[..., Numbers]


def _choose(first: Any, a: Numbers, b: Numbers) -> Numbers:
    return np.where(first, a, b)


FUNCTIONS: Mapping[Op, Function] = MappingProxyType(
    {
        Op.NEGATE: lambda x: -x,
        Op.ADD: lambda a, b: a + b,
        Op.SUBTRACT: lambda a, b: a - b,
        Op.MULTIPLY: lambda a, b: a * b,
        Op.DIVIDE: lambda a, b: a / b,
        Op.POWER_OF: lambda a, b: a**b,
        Op.ATAN2: direction,
        Op.HYPOT: hypotenuse,
        Op.MIN: lambda a, b: _choose(a <= b, a, b),
        Op.MAX: lambda a, b: _choose(a >= b, a, b),
        Op.SIN: np.sin,
        Op.COS: np.cos,
        Op.TAN: np.tan,
        Op.ASIN: np.arcsin,
        Op.ACOS: np.arccos,
        Op.ATAN: np.arctan,
        Op.SINH: np.sinh,
        Op.COSH: np.cosh,
        Op.TANH: np.tanh,
        Op.EXP: np.exp,
        Op.LOG: np.log,
        Op.LOG10: lambda x: 1.0 / LN10 * np.log(x),
        Op.SQRT: np.sqrt,
        Op.ABS: lambda x: np.sign(x.real) * x,
        Op.SIGN: lambda x: np.sign(x.real),
        Op.FLOOR: lambda x: np.floor(x.real),
        Op.CEIL: lambda x: np.ceil(x.real),
        Op.SMOOTH_STEP: lambda x: smooth_step(x)[0],
    }
)


class _Terms(NamedTuple):
    """The distinct terms of some programs, each after its arguments.

    `constants`: the value of each term that is a constant, else None. `variables`: (term, variable). `operations`:
    (term, function, terms of the arguments). `results`: the term of each program."""

    constants: tuple[Numbers | None, ...]
    variables: tuple[tuple[int, int], ...]
    operations: tuple[tuple[int, Function, tuple[int, ...]], ...]
    results: tuple[int, ...]


#: The most lists of terms that are kept for a set: one for each law, and again for each branch of its switches.
MOST_KNOWN = 10_000
_KNOWN: WeakKeyDictionary[ProgramSet, dict[tuple[tuple[int, ...], bytes | None], _Terms]] = WeakKeyDictionary()


def values(
    programs: ProgramSet, indices: Sequence[int], variables: Sequence[Numbers], held: Array | None = None
) -> list[Numbers]:
    """Return the value of each of these programs, with the bits of `mbproj.functions.series.run`. Undefined values are
    NaN or infinite. A constant has no shape, whatever that of the variables. `held`: as for `run`."""
    terms = _known_terms(programs, tuple(indices), held)
    at: list[Any] = list(terms.constants)
    for term, variable in terms.variables:
        at[term] = numbers(variables[variable])
    with np.errstate(all="ignore"):
        for term, function, arguments in terms.operations:
            at[term] = function(*[at[each] for each in arguments])
    results = [at[term] for term in terms.results]
    if held is None or all(np.isfinite(each).all() for each in results):
        return results
    free = values(programs, indices, variables)
    return [value if np.isfinite(value).all() else other for value, other in zip(results, free, strict=True)]


def value(programs: ProgramSet, index: int, variables: Sequence[Numbers], held: Array | None = None) -> Numbers:
    """Return the value of one program, as `values` does."""
    return values(programs, (index,), variables, held)[0]


def _known_terms(programs: ProgramSet, indices: tuple[int, ...], held: Array | None) -> _Terms:
    """Return the terms of these programs, which are kept as long as the set is."""
    known = _KNOWN.setdefault(programs, {})
    key = indices, None if held is None else held.tobytes()
    if key not in known:
        if len(known) >= MOST_KNOWN:
            known.clear()
        known[key] = _terms(programs, indices, [FREE] * len(programs.op) if held is None else held.tolist())
    return known[key]


def _terms(programs: ProgramSet, indices: tuple[int, ...], branches: list[float]) -> _Terms:
    """Return the distinct terms of these programs, on these branches, one for each instruction."""
    numbered: dict[tuple[object, ...], int] = {}
    constants, variables, operations, results = list[Numbers | None](), [], [], []
    for index in indices:
        stack: list[int] = []
        for at in range(programs.start[index], programs.start[index + 1]):
            op, operand, branch = programs.operations[at], programs.operand[at], branches[at]
            taken = len(stack) - ARGUMENTS[op]
            arguments = tuple(stack[taken:])
            key = op, operand.tobytes(), branch if branch == branch else None, arguments
            if key not in numbered:
                term = numbered[key] = len(constants)
                constants.append(np.array(operand) if op is Op.CONSTANT else None)
                if op is Op.VARIABLE:
                    variables.append((term, int(operand)))
                elif op is not Op.CONSTANT:
                    operations.append((term, _function(programs, op, operand.item(), branch), arguments))
            stack[taken:] = [numbered[key]]
        results.append(stack.pop())
    return _Terms(tuple(constants), tuple(variables), tuple(operations), tuple(results))


def _function(programs: ProgramSet, op: Op, operand: float, branch: float) -> Function:
    """Return the function of an operation, on the branch on which it is held."""
    if op is Op.TABLE:
        return lambda x: table_series(programs, int(operand), x, branch)[0]
    if op is Op.POWER:
        return lambda x: x**operand
    if np.isnan(branch):
        return FUNCTIONS[op]
    if op in (Op.MIN, Op.MAX):
        is_first = (branch > 0.0) == (op is Op.MAX)
        return lambda a, b: a if is_first else b
    return (lambda x: branch * x) if op is Op.ABS else lambda x: np.full_like(x, branch)
