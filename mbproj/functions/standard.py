"""The standard motions of machine design as programs of time."""

from __future__ import annotations

from collections.abc import Sequence

from mbproj.functions.program import TIME, Code, Instruction, Op, apply, number, variable
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
