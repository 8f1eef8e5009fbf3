"""The steps of one run, which other runs follow. A run that follows them is a smooth function of its numbers, to
round-off. With steps of its own it would be smooth only to its tolerance, because error control changes steps with the
numbers (Bock 1981)."""

from __future__ import annotations

from typing import Any

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.scene.records import Settings


@dataclass
class FollowedSteps:
    """The ends of the steps of a run with error control, in s, and its breaks. A run follows these ends; where there
    are none, it records the ends of its own steps here. `left`: whether a run could not follow, because its breaks or
    its end differ."""

    ends: tuple[float, ...] = ()
    breaks: tuple[float, ...] = ()
    left: bool = False

    @property
    def are_recorded(self) -> bool:
        """Whether a run has recorded its steps."""
        return bool(self.ends)

    def of_another(self) -> FollowedSteps:
        """Return the steps for another run to follow."""
        return FollowedSteps(self.ends, self.breaks)

    def begin(self, run: Any, leg: Leg) -> None:
        """Prepare a run in the kernel before its first step: it follows the known steps, or records its own."""
        if leg.step is not None:
            return
        if not self.ends:
            run.keep_ends()
        elif self.breaks == _times(leg) and self.ends[-1] == leg.end:
            run.follow(list(self.ends))
        else:
            self.left = True

    def finish(self, compiled: Compiled, run: Any, leg: Leg, settings: Settings) -> None:
        """Record the steps after the last one."""
        if leg.step is None and not self.ends:
            self.ends, self.breaks = tuple(run.ends), _times(leg)


@dataclass(frozen=True, eq=False)
class Trace:
    """A run in the kernel: its model, its settings and its leg; the ends `t` (n,) of its steps, their sizes `h` (n,),
    and the kernel's states `y` (n, S) there."""

    compiled: Compiled
    settings: Settings
    leg: Leg
    t: Array
    h: Array
    y: Array


@dataclass
class TracedSteps(FollowedSteps):
    """Steps that also record the states at their ends: `trace`, for a run that came to its end."""

    trace: Trace | None = None

    def begin(self, run: Any, leg: Leg) -> None:
        """Prepare a run before its first step."""
        super().begin(run, leg)
        run.keep_path()

    def finish(self, compiled: Compiled, run: Any, leg: Leg, settings: Settings) -> None:
        """Record the steps and the trace after the last step."""
        super().finish(compiled, run, leg, settings)
        self.trace = Trace(compiled, settings, leg, *run.path)


def _times(leg: Leg) -> tuple[float, ...]:
    return tuple(each.time for each in leg.breaks)
