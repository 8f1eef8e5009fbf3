"""Functions of a scene made into others: multiplied, summed up, run faster."""

from __future__ import annotations

from collections.abc import Sequence

from mbproj.functions.program import Code, Op, Program, apply, number


def times(factor: float, program: Program) -> Program:
    """factor · f."""
    return Program(apply(Op.MULTIPLY, number(factor), program.code), program.text)


def combined(factors: Sequence[float], programs: Sequence[Program]) -> Program:
    """Σ factor · f."""
    parts = [times(factor, program).code for factor, program in zip(factors, programs, strict=True)]
    return Program(apply(Op.ADD, *parts), ", ".join(program.text for program in programs if program.text))


def with_argument(program: Program, variable: int, factor: float) -> Program:
    """f of factor · x, where x is the variable of this number (`TIME`, `COORDINATE`, `RATE`)."""
    code: Code = ()
    for step in program.code:
        is_it = step.op is Op.VARIABLE and int(step.operand) == variable
        code += apply(Op.MULTIPLY, number(factor), (step,)) if is_it else (step,)
    return Program(code, program.text)
