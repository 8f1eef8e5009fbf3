"""The leg of a run: the times of breaks, steps and samples; and their form in the kernel's classes."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType
from typing import TYPE_CHECKING, Any

from mbproj.dataclass import dataclass
from mbproj.integrate.events.breaks import Break, breaks_of
from mbproj.integrate.steppers.tableau import Tableau
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.scene.sampling import SampleTimes, output_every, output_interval, output_times, whole_steps

if TYPE_CHECKING:
    from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau


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
        """Return the leg of a run with these settings. With a period `asks` in s the run waits at its start, and once
        in each period."""
        assert settings.duration is not None  # settings_to_run requires it
        duration, interval = settings.duration, output_interval(settings)
        breaks = breaks_of(system, start, settings, asks)
        if settings.step is None:
            return cls(start, duration, interval, breaks, times=output_times(settings, start))
        steps, every = whole_steps(settings), output_every(settings)
        return cls(start, duration, interval, breaks, settings.step, steps, every)

    @property
    def without_samples(self) -> Leg:
        """This leg with error control, and with samples only at its start and end."""
        return replace(self, times=SampleTimes(self.start, self.end, self.start, self.duration))

    @property
    def end(self) -> float:
        """The time at which the leg ends, in s."""
        return self.start + self.duration


def kernel_tableau(core: ModuleType, tableau: Tableau | ImplicitTableau, *, kinematic: bool) -> Any:
    """Return a tableau as the kernel's class."""
    return core.Tableau(tableau=tableau, kinematic=kinematic)


def kernel_breaks(leg: Leg) -> list[tuple[Any, ...]]:
    """Return the times at which steps end, as the kernel takes them."""
    return [(*each[:3], list(each.actions), each.asks) for each in leg.breaks]


def kernel_steps(core: ModuleType, settings: Settings, leg: Leg) -> Any:
    """Return the steps of a run as the kernel's class: fixed, or by error control."""
    breaks = kernel_breaks(leg)
    if leg.step is not None:
        return core.Steps.fixed(leg.start, leg.duration, leg.step, leg.count, leg.every, breaks)
    assert leg.times is not None
    samples = (leg.times.origin, leg.times.interval, leg.times.offset, leg.times.number)
    return core.Steps.by_error(leg.start, leg.duration, settings.tolerance, samples, breaks)
