"""Functions as programs: the standard motions of machine design, and functions made of functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from mbproj.base.arrays import Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.kinks import kinks
from mbproj.functions.program import CHANNELS, TIME, Code, Instruction, Op, Program, apply, number, replaced, variable
from mbproj.functions.program_set import FREE, OF_ROWS, ProgramSet, argument, flatten, natural, switches
from mbproj.functions.series import constant_series, run, walk
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
    nonzero = [(factor, program) for factor, program in terms if factor != 0.0]
    if not nonzero:
        return Program(number(0.0))
    scaled = [combine(_times(factor), program) for factor, program in nonzero]
    return scaled[0] if len(scaled) == 1 else combine(_added, *scaled)


def _times(factor: float) -> Callable[[Code], Code]:
    return lambda code: code if factor == 1.0 else apply(Op.MULTIPLY, number(factor), code)


def _added(*codes: Code) -> Code:
    return apply(Op.ADD, *codes)


def within(program: Program, low: float, high: float) -> Program:
    """Return the function, limited to values from `low` to `high`."""
    limited = apply(Op.MIN, apply(Op.MAX, program.code, number(low)), number(high))
    return replace(program, code=limited)


# --- A function of one coordinate, with its first and second derivative by it -----------------------------------------


@dataclass(frozen=True)
class Curve:
    """f(s) of a program whose COORDINATE is s, and which names nothing else. `held`: the branches of its switches, one
    for each instruction, if any."""

    program: Program
    held: tuple[float, ...] = ()

    def __call__(self, s: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Return f, f' and f'' at s (...), which may be complex."""
        none = np.zeros(s.shape)  # real, where s is complex
        held = np.array(self.held) if self.held else None
        return run(self._set, 0, [(none, none, none), (s, none + 1.0, none)], held)

    def on_branches(self, held: tuple[float, ...]) -> Curve:
        """Return the function with its switches on these branches, one for each instruction."""
        return replace(self, held=held)

    def edges(self, low: float, high: float) -> tuple[float, ...]:
        """Return the places from s = low to high where the value or the slope jumps."""
        s = tuple(
            replace(each, operand=TIME) if each.op is Op.VARIABLE else each  # kinks are searched in time
            for each in self.program.code
        )
        jumping = kinks(flatten([replace(self.program, code=s)]), 0, low, high)
        return tuple(each.t for each in jumping if any(jump and np.isfinite(jump) for jump in each.jump[:2]))

    def repeats(self, period: float, by: float) -> bool:
        """Return whether the function repeats from half a period below 0 to half a period above: its derivatives, its
        switches, and its value up to multiples of `by`. Both ends are evaluated on the branches of the first, as a knot
        may be there."""
        programs, ends = self._set, np.array([-0.5, 0.5]) * period
        held, edges = np.full(len(programs.op), FREE), set(switches(programs, 0))

        def arguments(s: float) -> list[float]:
            """Return the arguments of the switches."""
            seen = walk(programs, 0, [constant_series(np.asarray(s))] * 2, held)
            return [
                argument(programs, at, float(held[at]), [each[0] for each in stack[-2:]])
                for at, stack in seen
                if at in edges
            ]

        for at, x in zip(sorted(edges), arguments(ends[0]), strict=True):
            held[at] = natural(programs, at, x)
        on_branches = self.on_branches(tuple(held.tolist()))
        change, size = np.array(on_branches(ends)), np.abs(on_branches(ends)).max()
        change = change[:, 1] - change[:, 0]
        change[0] -= by * np.round(change[0] / by) if by else 0.0
        if np.abs(change).max() > THRESHOLDS.same_written * size:
            return False
        first, last = (arguments(end) for end in ends)
        return bool(np.allclose(first, last, atol=THRESHOLDS.same_written))

    @cached_property
    def _set(self) -> ProgramSet:
        return flatten([self.program], OF_ROWS)
