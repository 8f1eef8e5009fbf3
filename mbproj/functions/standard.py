"""Functions as programs: the standard motions of machine design, and functions made of functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from mbproj.functions.program import CHANNELS, TIME, Code, Instruction, Op, Program, apply, number, replaced, variable
from mbproj.functions.table import CubicTable

T = variable(TIME)


def uniform(speed: float) -> Code:
    """Return speed · t."""
    return apply(Op.MULTIPLY, number(speed), T)


def harmonic(amplitude: float, frequency: float, phase: float = 0.0, offset: float = 0.0) -> Code:
    """Return offset + amplitude sin(frequency · t + phase), with the frequency in rad/s."""
    wave = apply(Op.SIN, apply(Op.ADD, apply(Op.MULTIPLY, number(frequency), T), number(phase)))
    return apply(Op.ADD, number(offset), apply(Op.MULTIPLY, number(amplitude), wave))


def polynomial(coefficients: Sequence[float]) -> Code:
    """Return c0 + c1 t + c2 t² + ..., by Horner's rule."""
    *rest, code = (number(coefficient) for coefficient in coefficients)
    for coefficient in reversed(rest):
        code = apply(Op.ADD, coefficient, apply(Op.MULTIPLY, T, code))
    return code


def smooth_step(first: float, last: float, start: float, duration: float) -> Code:
    """Return a step from `first` to `last` between `start` and `start + duration`, with zero velocity and acceleration
    at both ends."""
    part = apply(Op.DIVIDE, apply(Op.SUBTRACT, T, number(start)), number(duration))
    change = apply(Op.MULTIPLY, number(last - first), apply(Op.SMOOTH_STEP, part))
    return apply(Op.ADD, number(first), change)


def tabulated(table: CubicTable, variable: Code = T) -> Code:
    """Return the table's value at a variable."""
    return (*variable, Instruction(Op.TABLE, table=table))


def reading(name: str) -> Program:
    """Return the function that is the channel of this name."""
    return Program(variable(CHANNELS), name, (name,))


def combine(make: Callable[..., Code], *programs: Program) -> Program:
    """Return the function that `make` makes of the codes of other functions; it reads the channels of all of them."""
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
    scaled = [combine(_times(factor), program) for factor, program in kept]
    return scaled[0] if len(scaled) == 1 else combine(_added, *scaled)


def _times(factor: float) -> Callable[[Code], Code]:
    return lambda code: code if factor == 1.0 else apply(Op.MULTIPLY, number(factor), code)


def _added(*codes: Code) -> Code:
    return apply(Op.ADD, *codes)


def within(program: Program, low: float, high: float) -> Program:
    """Return the function, limited to values from `low` to `high`."""
    limited = apply(Op.MIN, apply(Op.MAX, program.code, number(low)), number(high))
    return replace(program, code=limited)
