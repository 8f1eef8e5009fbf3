"""Where a run stands between two steps, for who looks at it there and may let another method go on."""

from __future__ import annotations

from collections.abc import Callable

from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.integrate.outcome.marks import Mark


@dataclass(frozen=True, eq=False)
class Standing:
    """A run between two steps: what it has counted so far, whether the run's end has shaped what led here, and the mark
    from which another method can go on; `state` gives that of the system."""

    steps: int
    rejected: int
    evaluations: int
    shaped: bool
    mark: Mark
    state: Callable[[], State]

    @property
    def attempts(self) -> int:
        """Steps that were tried since the start."""
        return self.steps + self.rejected


@dataclass
class Looks:
    """Scratch of a run by one method: when `due` steps were tried since the start, `look` is called; it says whether
    the run ends here, and sets `due` anew. It has no say in the steps. `sampled`: whether samples are made, too."""

    due: int
    look: Callable[[Standing], bool]
    sampled: bool = True
