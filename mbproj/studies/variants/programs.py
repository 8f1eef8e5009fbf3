"""Functions of a scene combined into others: multiplied, summed, or with a scaled argument."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mbproj.functions.program import CHANNELS, Code, Op, Program, apply, number, replaced, variable


def times(factor: float, program: Program) -> Program:
    """The program factor · f."""
    return replace(program, code=apply(Op.MULTIPLY, number(factor), program.code))


def combined(factors: Sequence[float], programs: Sequence[Program]) -> Program:
    """The program Σ factor · f."""
    reads = tuple(dict.fromkeys(name for program in programs for name in program.reads))
    parts = []
    for factor, program in zip(factors, programs, strict=True):
        by = {CHANNELS + at: variable(CHANNELS + reads.index(name)) for at, name in enumerate(program.reads)}
        parts.append(replaced(times(factor, program).code, by))
    return Program(apply(Op.ADD, *parts), ", ".join(program.text for program in programs if program.text), reads)


def with_argument(program: Program, variable: int, factor: float) -> Program:
    """The program f with its argument x replaced by factor · x. `variable` is the number of x (`TIME`, `COORDINATE`,
    `RATE`)."""
    code: Code = ()
    for step in program.code:
        is_it = step.op is Op.VARIABLE and int(step.operand) == variable
        code += apply(Op.MULTIPLY, number(factor), (step,)) if is_it else (step,)
    return replace(program, code=code)
