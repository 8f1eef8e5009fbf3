"""The times that a run's steps must not pass over: kinks, jumps and narrow features of the scene's functions of time,
those inside force laws too, and what `break_times` adds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mbproj.functions.kinks import MOST, kinks
from mbproj.functions.narrow import features
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.series import run, time_series
from mbproj.functions.time_parts import time_parts
from mbproj.model.forces import Forces
from mbproj.model.motions import Motions
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.thresholds import THRESHOLDS

#: Derivatives of forces do not count; of motions the acceleration does.
OF_FORCES, OF_MOTIONS = 1, 3
#: Kinks of a function that count, at most.
COUNTED = MOST


@dataclass(frozen=True, order=True)
class Event:
    """When, whose it is ("force 'push'", "motion 'm'", "break_times"), what it is, and where to: 1 or -1, 0 in time."""

    time: float
    name: str
    kind: str
    direction: int = 0


def time_events(system: System, start: float, end: float, asked: tuple[float, ...] = ()) -> tuple[Event, ...]:
    """From `start` to `end`, in their order: of each function the first `COUNTED` kinks, and the narrow features."""
    own = _of_scene(system.forces, system.motions, system.names.motions, start, end)
    return tuple(sorted({*own, *(Event(t, "break_times", "asked for") for t in asked if start < t < end)}))


def events_of(system: System, start: float, settings: Settings) -> tuple[Event, ...]:
    """Those of a run from `start`."""
    assert settings.duration is not None
    return time_events(system, start, start + settings.duration, settings.break_times)


def crowded(events: tuple[Event, ...]) -> tuple[str, ...]:
    """Whose kinks are so many that some may not count."""
    names = [event.name for event in events]
    return tuple(name for name in dict.fromkeys(names) if names.count(name) >= COUNTED)


@lru_cache(maxsize=256)
def _of_scene(
    forces: Forces | None, motions: Motions | None, names: tuple[str, ...], start: float, end: float
) -> tuple[Event, ...]:
    """Studies run a mechanism many times, and it does not change."""
    found: set[Event] = set()
    if forces is not None:
        owners = tuple(f"force '{name}'" for name in forces.program_owners)
        found |= set(_of_programs(forces.programs, owners, start, end, OF_FORCES))
    if motions is not None:
        owners = tuple(f"motion '{name}'" for name in names)
        found |= set(_of_programs(motions.programs, owners, start, end, OF_MOTIONS))
    return tuple(sorted(found))


def _of_programs(
    programs: ProgramSet, owners: tuple[str, ...], start: float, end: float, orders: int
) -> Iterator[Event]:
    seen: dict[tuple[bytes, bytes], list[tuple[float, str]]] = {}
    for index, owner in enumerate(owners):
        for part in time_parts(programs, index):
            code = slice(*part.start)
            same = part.op[code].tobytes(), part.operand[code].tobytes()
            if same not in seen:
                seen[same] = list(_of_function(part, start, end, orders))
            yield from (Event(t, owner, kind) for t, kind in seen[same])


def _of_function(part: ProgramSet, start: float, end: float, orders: int) -> Iterator[tuple[float, str]]:
    beside = THRESHOLDS.one_break * float(np.spacing(max(abs(start), abs(end))))
    found = [kink for kink in kinks(part, 0, start, end) if _goes_on(part, kink.t, beside, start, end)]
    for kink in found:
        yield kink.t, "jump" if any(kink.jump[:orders]) else "kink"
    for feature in features(part, 0, start, end, found, orders):
        yield feature.start, "narrow feature begins"
        yield feature.end, "narrow feature ends"


def _goes_on(part: ProgramSet, t: float, beside: float, start: float, end: float) -> bool:
    """Whether a function has values beside t: where it ends, a run stops and names it."""
    times = np.clip([t - beside, t + beside], start, end)
    return bool(np.all(np.isfinite(run(part, 0, [time_series(times)])[0])))
