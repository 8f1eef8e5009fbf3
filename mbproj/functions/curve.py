"""A function of one coordinate, with its first and second derivative by it."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from mbproj.arrays import Numbers
from mbproj.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.functions.program_set import ProgramSet, flatten
from mbproj.functions.series import run


@dataclass(frozen=True)
class Curve:
    """f(s) of a program whose COORDINATE is s, and which names nothing else."""

    program: Program

    def __call__(self, s: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """f, f' and f'' at s (...), which may be complex."""
        none = np.zeros(s.shape)  # real: constants follow the time
        return run(self._set, 0, [(none, none, none), (s, none + 1.0, none)])

    @cached_property
    def _set(self) -> ProgramSet:
        return flatten([self.program])
