"""What part of a run is made in one go: all of it, or a leg between two events that the loop itself does not know."""

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
    """From `start` over `duration`, s. Fixed steps: `count` of size `step`, of which every `every`-th is recorded. With
    error control: samples at `times`, from `start` on; a `first` step of that size, None where it is chosen. `breaks`
    are those of the whole run, and `interval` lies between two of its samples."""

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
        """A whole run; with a period `asks` it waits at its start and that much later, again and again."""
        assert settings.duration is not None  # settings_to_run has seen to it
        duration, interval = settings.duration, output_interval(settings)
        breaks = breaks_of(system, start, settings, asks)
        if settings.step is None:
            return cls(start, duration, interval, breaks, times=output_times(settings, start))
        steps, every = whole_steps(settings), output_every(settings)
        return cls(start, duration, interval, breaks, settings.step, steps, every)

    def after_actions(self, t: float) -> Leg:
        """The same where what controllers do up to a time is done already."""
        if not any(each.actions for each in self.breaks):
            return self
        done = (each._replace(actions=()) if each.time <= t else each for each in self.breaks)
        return replace(self, breaks=tuple(done))

    @property
    def without_samples(self) -> Leg:
        """The same with error control, where samples at its start and end alone are made."""
        return replace(self, times=SampleTimes(self.start, self.end, self.start, self.duration))

    def records_at(self, times: Array) -> Flags:
        """Which of some times are those of samples, with error control."""
        grid = self.times
        assert grid is not None
        k = np.clip(np.rint((times - grid.origin) / grid.interval) - grid.offset, 1, max(grid.number - 2, 1))
        regular = (grid.origin + (grid.offset + k) * grid.interval == times) & (grid.number > 2)
        found: Flags = regular | (times == grid.first) | (times == grid.last)
        return found

    @property
    def end(self) -> float:
        """When it ends."""
        return self.start + self.duration
