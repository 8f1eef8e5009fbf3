"""Marks: the states from which a run begins, and from which another run can continue."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import astuple, field
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.motion.report import Peak, Tally
from mbproj.motion.time_events import Event

#: A state between two steps, with all that the next step depends on, by name: the time "t", arrays (n,) of float64, and
#: plain data as JSON has it. Empty: a run's start.
Mark = Mapping[str, Any]
START: Mark = MappingProxyType({})
PEAKS = ("position_peak", "velocity_peak", "joint_peak")


def _at_start() -> Mark:
    return START


@dataclass
class Marks:
    """The marks of one run, which continues from the mark `resumed`. Where marks are `wanted`, `newest` returns the
    last one that the run's end has not influenced: from there a longer run makes the same steps."""

    resumed: Mark = field(default_factory=_at_start)
    wanted: bool = False
    newest: Callable[[], Mark] = _at_start


class Keeping:
    """Hands marks of one run to `keep`, at intervals such that this takes at most a tenth of the run's time. A mark has
    all events so far; a million of them take a second."""

    def __init__(self, marks: Marks, keep: Callable[[Mark], None]) -> None:
        self._marks, self._keep = marks, keep
        self._due, self._passed = -np.inf, False

    def now_and_then(self) -> None:
        """Keep the newest mark after a block of samples, if it is time."""
        begun = perf_counter()
        self._passed = begun < self._due
        if not self._passed:
            self._keep(self._marks.newest())
            now = perf_counter()
            self._due = now + THRESHOLDS.marks_apart * (now - begun)

    @contextmanager
    def to_the_end(self) -> Iterator[None]:
        """Keep the newest mark at the end of the block, however it ends."""
        try:
            yield
        finally:
            if self._passed:
                self._keep(self._marks.newest())


@contextmanager
def resuming() -> Iterator[None]:
    """Turn errors in this block, while a run takes over a mark, into InputError: the mark does not fit."""
    try:
        yield
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        message = f"the state to go on from is not one of this scene: {error}"
        raise InputError(Problem(message, hint="start over with: mbproj rerun")) from error


def saved_events(met: Sequence[Event], until: float) -> list[list[Any]]:
    """Return the events up to some time as plain data. They may be very many: `astuple` takes ten times as long."""
    return [
        [
            event.time,
            event.name,
            event.kind,
            event.direction,
            event.impulse,
            event.energy,
        ]
        for event in met
        if event.time <= until
    ]


def restored_events(saved: Sequence[Sequence[Any]]) -> list[Event]:
    """Return the events that were saved."""
    return [Event(float(t), str(name), str(kind), int(way), *map(float, rest)) for t, name, kind, way, *rest in saved]


def saved_tally(tally: Tally) -> dict[str, Any]:
    """Return the counts of a run in NumPy's loop as plain data."""
    return {
        "counters": {name: int(value) for name, value in tally.counters().items()},
        "peaks": {name: list(astuple(getattr(tally, name))) for name in PEAKS},
    }


def restore_tally(tally: Tally, saved: Mapping[str, Any]) -> None:
    """Set the counts of a run to those that were saved."""
    tally.set_counters(int(saved["counters"][name]) for name in tally.counters())
    for name in PEAKS:
        value, row, time = saved["peaks"][name]
        setattr(tally, name, Peak(float(value), int(row), float(time)))
