"""Functions made of functions: the value of a channel, sums with factors, limits."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from mbproj.functions.program import CHANNELS, Code, Op, Program, apply, number, replaced, variable


def reading(name: str) -> Program:
    """Return the function that is the channel of this name."""
    return Program(variable(CHANNELS), name, (name,))


def joined(make: Callable[..., Code], *programs: Program) -> Program:
    """Return the function that `make` makes of the codes of others; it reads the channels that any of them reads."""
    reads = tuple(dict.fromkeys(name for program in programs for name in program.reads))
    at = {name: variable(CHANNELS + index) for index, name in enumerate(reads)}
    codes = [
        replaced(program.code, {CHANNELS + index: at[name] for index, name in enumerate(program.reads)})
        for program in programs
    ]
    text = next((program.text for program in programs if program.text), "")
    return Program(make(*codes), text, reads)


def weighted(terms: Iterable[tuple[float, Program]]) -> Program:
    """Return the sum of functions with factors; those with the factor 0 are left out."""
    kept = [(factor, program) for factor, program in terms if factor != 0.0]
    if not kept:
        return Program(number(0.0))
    scaled = [joined(_times(factor), program) for factor, program in kept]
    return scaled[0] if len(scaled) == 1 else joined(_added, *scaled)


def _times(factor: float) -> Callable[[Code], Code]:
    return lambda code: code if factor == 1.0 else apply(Op.MULTIPLY, number(factor), code)


def _added(*codes: Code) -> Code:
    return apply(Op.ADD, *codes)


def within(program: Program, low: float, high: float) -> Program:
    """Return the function, limited to values from `low` to `high`."""
    limited = apply(Op.MIN, apply(Op.MAX, program.code, number(low)), number(high))
    return replace(program, code=limited)
