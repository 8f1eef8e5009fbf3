"""Breaks: the times at which steps end. Steps before and after evaluate functions of time from their own side."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.integrate.events.splits import splits_of
from mbproj.integrate.events.time_events import events_of
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.scene.sampling import output_interval, output_times
from mbproj.thresholds import THRESHOLDS


class Break(NamedTuple):
    """A time at which a step ends. Before it functions of time are evaluated no later than `left`, after it no earlier
    than `right`. `actions`: the controllers' actions at this time, in order. `asks`: whether the run waits there for
    inputs."""

    time: float
    left: float
    right: float
    actions: tuple[int, ...] = ()
    asks: bool = False


@dataclass(frozen=True)
class TimeWindow:
    """The window between two breaks, in which functions of time are evaluated."""

    first: float = -np.inf
    last: float = np.inf

    def clip(self, t: float) -> float:
        """Return the time within the window at which functions are evaluated for t."""
        return min(max(t, self.first), self.last)


def breaks_of(system: System, start: float, settings: Settings, asks: float | None = None) -> tuple[Break, ...]:
    """Return the breaks of a run, in their order.

    They are its events, the points that split its fixed steps, and the actions of controllers. With a period `asks`
    there are also the times at which the run waits. A break at the start or the end selects the side for evaluations
    there."""
    assert settings.duration is not None
    breaks: list[Break] = []
    grid = None
    interval, end = output_interval(settings), start + settings.duration
    times = {event.time for event in events_of(system, start, settings)}
    inner = {t for split in splits_of(system, start, settings) for t in split.times if start < t < end}
    slack = THRESHOLDS.round_off_grains * float(np.spacing(max(abs(start), interval)))
    acts = system.actions.instants(start, end, slack) if system.actions.size else {}
    waits = set((start + np.arange(int((end - start) / asks * (1.0 + 1e-12)) + 1) * asks).tolist()) if asks else set()
    for time in sorted(times | inner | acts.keys() | waits):
        grain = float(np.spacing(max(abs(start), abs(time), interval)))
        actions, waiting = acts.get(time, ()), time in waits
        grid = _grid(settings, start) if grid is None else grid
        left, right = time - THRESHOLDS.closed_grains * grain, time + THRESHOLDS.closed_grains * grain
        if breaks and time - breaks[-1].time <= THRESHOLDS.round_off_grains * grain:
            together = tuple(sorted({*breaks[-1].actions, *actions}))
            right, waiting = max(right, breaks[-1].right), waiting or breaks[-1].asks
            breaks[-1] = breaks[-1]._replace(right=right, actions=together, asks=waiting)
        else:
            at = _snapped(time, grid, settings, THRESHOLDS.round_off_grains * grain)
            breaks.append(Break(at, left, right, actions, waiting))
    return tuple(breaks)


def _grid(settings: Settings, start: float) -> Sequence[float]:
    """Return the times of samples for a run with error control; for fixed steps, the start."""
    return output_times(settings, start) if settings.step is None else [start]


def _snapped(t: float, grid: Sequence[float], settings: Settings, slack: float) -> float:
    """Return t, or the time of a step or a sample within `slack` of it."""
    if settings.step is not None:
        assert settings.duration is not None
        near = [grid[0] + round((t - grid[0]) / settings.step) * settings.step, grid[0] + settings.duration]
    else:
        at = bisect_left(grid, t)
        near = [*grid[max(at - 1, 0) : at + 1]]
    closest = min(near, key=lambda time: abs(time - t))
    return closest if abs(closest - t) <= slack else t


class BreakCursor:
    """The place of one run among its breaks: the number of breaks passed. `interval`: the time between two samples, in
    s."""

    def __init__(self, breaks: Sequence[Break], start: float, interval: float) -> None:
        self._breaks, self._passed, self._interval, self._acted = breaks, 0, interval, 0
        self.pass_break(start)

    @property
    def next(self) -> float:
        """The time at which the next step must end; infinite where no break follows."""
        return self._breaks[self._passed].time if self._passed < len(self._breaks) else np.inf

    @property
    def passed(self) -> int:
        """The number of breaks passed."""
        return self._passed

    @property
    def window(self) -> TimeWindow:
        """The window from the last break to the next one."""
        before, after = self._breaks[: self._passed][-1:], self._breaks[self._passed :][:1]
        return TimeWindow(before[0].right if before else -np.inf, after[0].left if after else np.inf)

    def is_at(self, t: float) -> bool:
        """Whether a step that ends at t ends at the next break."""
        return bool(self.next <= t + self._beside(t))

    def cuts(self, t: float) -> bool:
        """Whether a step to t would pass over the next break."""
        return bool(self.next < t - self._beside(t))

    def pass_break(self, t: float) -> None:
        """Mark the breaks up to t as passed."""
        while self.is_at(t):
            self._passed += 1

    def take_actions(self) -> list[int]:
        """Return the controllers' actions at breaks that were passed since the last call."""
        actions = [action for each in self._breaks[self._acted : self._passed] for action in each.actions]
        self._acted = self._passed
        return actions

    def _beside(self, t: float) -> float:
        """Return the tolerance within which a time counts as t, in s."""
        return float(16.0 * np.finfo(float).eps * max(abs(t), self._interval))
