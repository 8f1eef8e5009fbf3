"""A function of one coordinate, with its first and second derivative by it."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from mbproj.arrays import Numbers
from mbproj.dataclass import dataclass
from mbproj.functions.kinks import kinks
from mbproj.functions.program import TIME, Op, Program
from mbproj.functions.program_set import OF_ROWS, ProgramSet, flatten
from mbproj.functions.series import constant_series, run, walk
from mbproj.functions.switches import FREE, argument, natural, switches
from mbproj.thresholds import THRESHOLDS


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
        own, ends = self._set, np.array([-0.5, 0.5]) * period
        held, edges = np.full(len(own.op), FREE), set(switches(own, 0))

        def arguments(s: float) -> list[float]:
            """Return the arguments of the switches."""
            seen = walk(own, 0, [constant_series(np.asarray(s))] * 2, held)
            return [
                argument(own, at, float(held[at]), [each[0] for each in stack[-2:]])
                for at, stack in seen
                if at in edges
            ]

        for at, x in zip(sorted(edges), arguments(ends[0]), strict=True):
            held[at] = natural(own, at, x)
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
