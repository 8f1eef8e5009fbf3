"""A function of one coordinate, with its first and second derivative by it."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from mbproj.arrays import Numbers
from mbproj.dataclass import dataclass
from mbproj.functions.program import Op, Program
from mbproj.functions.program_set import ProgramSet, flatten
from mbproj.functions.series import constant_series, run, walk
from mbproj.functions.switches import FREE, argument, switches
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True)
class Curve:
    """f(s) of a program whose COORDINATE is s, and which names nothing else; on the branches `held`, if any, one for
    each instruction."""

    program: Program
    held: tuple[float, ...] = ()

    def __call__(self, s: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """f, f' and f'' at s (...), which may be complex."""
        none = np.zeros(s.shape)  # real: constants follow the time
        held = np.array(self.held) if self.held else None
        return run(self._set, 0, [(none, none, none), (s, none + 1.0, none)], held)

    def on_branches(self, held: tuple[float, ...]) -> Curve:
        """The same, with its switches on these branches, one for each instruction."""
        return replace(self, held=held)

    def has_edges(self) -> bool:
        """Whether its slope jumps, or may: at what is no table."""
        own = self._set
        found = [(own.op[at] == Op.TABLE, int(own.operand[at])) for at in switches(own, 0)]
        return any(not is_table or own.jumps(number)[:, :2].any() for is_table, number in found)

    def repeats(self, period: float, by: float) -> bool:
        """Whether it repeats from half a period below 0 to half a period above: its derivatives, its switches, and its
        value but for multiples of `by`."""
        ends = np.array([-0.5, 0.5]) * period
        change, size = np.array(self(ends)), np.abs(self(ends)).max()
        change = change[:, 1] - change[:, 0]
        change[0] -= by * np.round(change[0] / by) if by else 0.0
        if np.abs(change).max() > THRESHOLDS.smooth_to * size:
            return False
        own, free, edges = self._set, FREE, set(switches(self._set, 0))
        first, last = (
            [argument(own, at, free, stack[-1]) for at, stack in walk(own, 0, [constant_series(s)] * 2) if at in edges]
            for s in ends
        )
        return bool(np.allclose(first, last, atol=THRESHOLDS.smooth_to))

    @cached_property
    def _set(self) -> ProgramSet:
        return flatten([self.program])
