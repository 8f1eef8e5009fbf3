"""What a run is asked for: when its steps end, and what is recorded."""

from __future__ import annotations

from dataclasses import replace

from mbproj.dataclass import dataclass
from mbproj.integrate.events.breaks import Break, breaks_of
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.scene.sampling import SampleTimes, output_every, output_interval, output_times, whole_steps


@dataclass(frozen=True)
class Leg:
    """A run from `start` over `duration`, in s.

    Fixed steps: `count` steps of size `step`, of which every `every`-th is recorded. With error control: samples at
    `times`. `interval` is the time between two samples."""

    start: float
    duration: float
    interval: float
    breaks: tuple[Break, ...]
    step: float | None = None
    count: int = 0
    every: int = 1
    times: SampleTimes | None = None

    @classmethod
    def whole(cls, system: System, settings: Settings, start: float, asks: float | None = None) -> Leg:
        """Return that of a run with these settings; with a period `asks` it waits at its start, then once in each."""
        assert settings.duration is not None  # settings_to_run has seen to it
        duration, interval = settings.duration, output_interval(settings)
        breaks = breaks_of(system, start, settings, asks)
        if settings.step is None:
            return cls(start, duration, interval, breaks, times=output_times(settings, start))
        steps, every = whole_steps(settings), output_every(settings)
        return cls(start, duration, interval, breaks, settings.step, steps, every)

    @property
    def without_samples(self) -> Leg:
        """The same with error control, and samples only at its start and end."""
        return replace(self, times=SampleTimes(self.start, self.end, self.start, self.duration))

    @property
    def end(self) -> float:
        """The time at which it ends."""
        return self.start + self.duration
