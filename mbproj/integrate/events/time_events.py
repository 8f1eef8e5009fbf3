"""The times that a run's steps must not pass over: kinks, jumps and narrow features of the scene's functions of time,
those inside force laws too, and what `break_times` adds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mbproj.functions.kinks import kinks
from mbproj.functions.look_times import look_windows
from mbproj.functions.narrow import features
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.series import run, time_series
from mbproj.functions.time_parts import time_parts
from mbproj.model.forces import Forces
from mbproj.model.motions import Motions
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.scene.sampling import output_interval
from mbproj.thresholds import THRESHOLDS

#: Derivatives of forces do not count; of motions the acceleration does.
OF_FORCES, OF_MOTIONS = 1, 3


@dataclass(frozen=True, order=True)
class Event:
    """When, whose it is ("force 'push'", "motion 'm'", "stop 's'", "break_times"), what it is, and where to: 1 or -1, 0
    in time. Of an impact, the impulse in N s or N m s and the energy that is lost in J."""

    time: float
    name: str
    kind: str
    direction: int = 0
    impulse: float = 0.0
    energy: float = 0.0


def time_events(
    system: System, start: float, end: float, interval: float, asked: tuple[float, ...] = ()
) -> tuple[Event, ...]:
    """From `start` to `end`, in their order: of each function the first `most_kinks` kinks, and the narrow features.
    `interval` is the time between two samples, s. A later end adds events and changes none."""
    own = _of_scene(system.forces, system.motions, system.names.motions, start, end, interval)
    return tuple(sorted({*own, *(Event(t, "break_times", "asked for") for t in asked if start < t < end)}))


def events_of(system: System, start: float, settings: Settings) -> tuple[Event, ...]:
    """Those of a run from `start`."""
    assert settings.duration is not None
    return time_events(system, start, start + settings.duration, output_interval(settings), settings.break_times)


def crowded(events: tuple[Event, ...]) -> tuple[str, ...]:
    """Whose kinks are so many that some may not count."""
    names = [event.name for event in events]
    return tuple(name for name in dict.fromkeys(names) if names.count(name) >= THRESHOLDS.most_kinks)


@lru_cache(maxsize=256)
def _of_scene(
    forces: Forces | None, motions: Motions | None, names: tuple[str, ...], start: float, end: float, interval: float
) -> tuple[Event, ...]:
    """Studies run a mechanism many times, and it does not change."""
    found: set[Event] = set()
    if forces is not None:
        owners = tuple(f"force '{name}'" for name in forces.program_owners)
        found |= set(_of_programs(forces.programs, owners, start, end, interval, OF_FORCES))
    if motions is not None:
        owners = tuple(f"motion '{name}'" for name in names)
        found |= set(_of_programs(motions.programs, owners, start, end, interval, OF_MOTIONS))
    return tuple(sorted(found))


def _of_programs(
    programs: ProgramSet, owners: tuple[str, ...], start: float, end: float, interval: float, orders: int
) -> Iterator[Event]:
    seen: dict[tuple[bytes, bytes], list[tuple[float, str]]] = {}
    for index, owner in enumerate(owners):
        for part in time_parts(programs, index):
            code = slice(*part.start)
            same = part.op[code].tobytes(), part.operand[code].tobytes()
            if same not in seen:
                seen[same] = list(_of_function(part, start, end, interval, orders))
            yield from (Event(t, owner, kind) for t, kind in seen[same])


def _of_function(
    part: ProgramSet, start: float, end: float, interval: float, orders: int
) -> Iterator[tuple[float, str]]:
    counted = 0
    for low, high in look_windows(start, end, interval):
        beside = THRESHOLDS.one_break * float(np.spacing(max(abs(low), abs(high))))
        found = [kink for kink in kinks(part, 0, low, high) if _goes_on(part, kink.t, beside, start, end)]
        for feature in features(part, 0, low, high, found, orders):
            sides = zip(feature, ("begins", "ends"), strict=True)
            yield from ((t, f"narrow feature {what}") for t, what in sides if t <= end)
        for kink in found[: THRESHOLDS.most_kinks - counted]:
            if kink.t <= end:
                yield kink.t, "jump" if any(kink.jump[:orders]) else "kink"
        counted += len(found)
        if counted >= THRESHOLDS.most_kinks:
            return


def _goes_on(part: ProgramSet, t: float, beside: float, start: float, end: float) -> bool:
    """Whether a function has values beside t: where it ends, a run stops and names it."""
    times = np.clip([t - beside, t + beside], start, end)
    return bool(np.all(np.isfinite(run(part, 0, [time_series(times)])[0])))
