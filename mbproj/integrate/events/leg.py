"""A leg: the part of a run between two events that the loop itself does not handle, or all of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.integrate.events.breaks import Break, breaks_of
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.scene.sampling import SampleTimes, output_every, output_interval, output_times, whole_steps


@dataclass(frozen=True)
class Leg:
    """A leg from `start` over `duration`, in s.

    Fixed steps: `count` steps of size `step`, of which every `every`-th is recorded. With error control: samples at
    `times`, from `start` on, and the size of the `first` step, None where the run chooses it. `breaks` are those of the
    whole run; `interval` is the time between two of its samples."""

    start: float
    duration: float
    interval: float
    breaks: tuple[Break, ...]
    step: float | None = None
    count: int = 0
    every: int = 1
    times: SampleTimes | None = None
    first: float | None = None

    @classmethod
    def whole(cls, system: System, settings: Settings, start: float, asks: float | None = None) -> Leg:
        """Return a whole run as a leg; with a period `asks` it waits at its start and then once in each period."""
        assert settings.duration is not None  # settings_to_run has seen to it
        duration, interval = settings.duration, output_interval(settings)
        breaks = breaks_of(system, start, settings, asks)
        if settings.step is None:
            return cls(start, duration, interval, breaks, times=output_times(settings, start))
        steps, every = whole_steps(settings), output_every(settings)
        return cls(start, duration, interval, breaks, settings.step, steps, every)

    def after_actions(self, t: float) -> Leg:
        """Return the leg without the controllers' actions up to a time, which are done already."""
        if not any(each.actions for each in self.breaks):
            return self
        done = (each._replace(actions=()) if each.time <= t else each for each in self.breaks)
        return replace(self, breaks=tuple(done))

    @property
    def without_samples(self) -> Leg:
        """The leg with error control, and samples only at its start and end."""
        return replace(self, times=SampleTimes(self.start, self.end, self.start, self.duration))

    def records_at(self, times: Array) -> Flags:
        """Whether each of some times is that of a sample, with error control."""
        grid = self.times
        assert grid is not None
        k = np.clip(np.rint((times - grid.origin) / grid.interval) - grid.offset, 1, max(grid.number - 2, 1))
        regular = (grid.origin + (grid.offset + k) * grid.interval == times) & (grid.number > 2)
        found: Flags = regular | (times == grid.first) | (times == grid.last)
        return found

    @property
    def end(self) -> float:
        """The time at which it ends."""
        return self.start + self.duration
