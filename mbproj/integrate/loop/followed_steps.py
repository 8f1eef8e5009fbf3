"""The steps of one run, which others follow. So a run beside it is a smooth function of its numbers, to round-off. With
steps of its own it is so to its tolerance alone: error control chooses others (Bock 1981)."""

from __future__ import annotations

from typing import Any

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.scene.records import Settings


@dataclass
class FollowedSteps:
    """Where steps of a run with error control end, in s, and its breaks. Without any, a run records its own here; with
    them, it follows. `left` says that a run could not: its breaks or its end are others."""

    ends: tuple[float, ...] = ()
    breaks: tuple[float, ...] = ()
    left: bool = False

    @property
    def known(self) -> bool:
        """Whether a run has recorded them."""
        return bool(self.ends)

    def of_another(self) -> FollowedSteps:
        """The same, for another run."""
        return FollowedSteps(self.ends, self.breaks)

    def begin(self, run: Any, leg: Leg) -> None:
        """Before the first step of a run in the kernel; those of another that are known are followed."""
        if leg.step is not None:
            return
        if not self.ends:
            run.keep_ends()
        elif self.breaks == _times(leg) and self.ends[-1] == leg.end:
            run.follow(list(self.ends))
        else:
            self.left = True

    def finish(self, compiled: Compiled, run: Any, leg: Leg, settings: Settings) -> None:
        """After the last step."""
        if leg.step is None and not self.ends:
            self.ends, self.breaks = tuple(run.ends), _times(leg)


@dataclass(frozen=True, eq=False)
class Trace:
    """A run in the kernel, as it was made: by which model, with which settings, from where to where; the ends (n,) of
    its steps, their sizes, and the kernel's states (n, S) there."""

    compiled: Compiled
    settings: Settings
    leg: Leg
    t: Array
    h: Array
    y: Array


@dataclass
class TracedSteps(FollowedSteps):
    """The same, and the states in which steps end: `trace`, of a run that came to its end."""

    trace: Trace | None = None

    def begin(self, run: Any, leg: Leg) -> None:
        """Before the first step."""
        super().begin(run, leg)
        run.keep_path()

    def finish(self, compiled: Compiled, run: Any, leg: Leg, settings: Settings) -> None:
        """After the last step."""
        super().finish(compiled, run, leg, settings)
        self.trace = Trace(compiled, settings, leg, *run.path)


def _times(leg: Leg) -> tuple[float, ...]:
    return tuple(each.time for each in leg.breaks)
