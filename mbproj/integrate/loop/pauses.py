"""Pauses of a run between two steps, at which its caller may end it and let another method continue."""

from __future__ import annotations

from collections.abc import Callable

from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.integrate.reporting.marks import Mark


@dataclass(frozen=True, eq=False)
class Standing:
    """The state of a run between two steps: its counts so far, and the mark from which another method can continue.

    `shaped`: whether the run's end has influenced the way here. `state` returns the state of the system."""

    steps: int
    rejected: int
    evaluations: int
    shaped: bool
    mark: Mark
    state: Callable[[], State]

    @property
    def attempts(self) -> int:
        """The number of steps tried since the start."""
        return self.steps + self.rejected


@dataclass
class Pauses:
    """The pauses of one run by one method. When `due` steps were tried since the start, `look` is called: it returns
    whether the run ends here, and sets `due` anew. The steps do not depend on it. `sampled`: whether the run also makes
    samples."""

    due: int
    look: Callable[[Standing], bool]
    sampled: bool = True
