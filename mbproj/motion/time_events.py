"""Times that a run's steps must not pass over: kinks, jumps and narrow features of the scene's functions of time, those
inside force laws too, and `break_times`."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mbproj.functions.program_set import ProgramSet
from mbproj.model.channels import ElementStates, Motions
from mbproj.model.forces import Forces
from mbproj.model.system import Names, System
from mbproj.scene.records import Settings
from mbproj.scene.sampling import output_interval
from mbproj.thresholds import THRESHOLDS

#: The number of orders that count: for forces the value, for motions also velocity and acceleration.
OF_FORCES, OF_MOTIONS = 1, 3
#: The kind of events with direction 1 where contacts begin to share a force arbitrarily, and -1 where that ends.
SHARED = "shared"
#: The kind of events at stops where the motion begins to depend on how they share a force.
DECIDES = "share decides"


@dataclasses.dataclass(frozen=True, order=True)
class Event:
    """An event: its time, its owner ("force 'push'", "motion 'm'", "stop 's'", "break_times"), and its kind.

    `direction` is 1 or -1, and 0 for events in time. An impact has an `impulse` in N s or N m s and a loss of `energy`
    in J."""

    time: float
    name: str
    kind: str
    direction: int = 0
    impulse: float = 0.0
    energy: float = 0.0


class Stretch(NamedTuple):
    """A time between two neighbouring events of a function, or from its start to the first one. `parts`: the parts of
    the function that depend on time alone; `orders`: the number of orders that count."""

    owner: str
    parts: tuple[ProgramSet, ...]
    orders: int
    low: float
    high: float


def time_events(
    system: System, start: float, end: float, interval: float, asked: tuple[float, ...] = ()
) -> tuple[Event, ...]:
    """Return the events from `start` to `end`, in order: of each function the first `most_kinks` kinks, and the narrow
    features. `interval` is the time between two samples, in s. A later end adds events and changes none."""
    own, _ = _of_scene(system.forces, system.motions, system.states, system.names, start, end, interval, 0.0)
    return tuple(sorted({*own, *(Event(t, "break_times", "asked for") for t in asked if start < t < end)}))


def stretches(system: System, start: float, end: float, interval: float, longest: float) -> tuple[Stretch, ...]:
    """Return the stretches shorter than `longest` that begin between `start` and `end`; they may end later. A later end
    adds some and changes none."""
    return _of_scene(system.forces, system.motions, system.states, system.names, start, end, interval, longest)[1]


def events_of(system: System, start: float, settings: Settings) -> tuple[Event, ...]:
    """Return the time events of a run from `start`."""
    assert settings.duration is not None
    return time_events(system, start, start + settings.duration, output_interval(settings), settings.break_times)


def crowded(events: tuple[Event, ...]) -> tuple[str, ...]:
    """Return the owners with so many kinks that further ones are ignored."""
    names = [event.name for event in events]
    return tuple(name for name in dict.fromkeys(names) if names.count(name) >= THRESHOLDS.most_kinks)


@lru_cache(maxsize=256)
def _of_scene(
    forces: Forces,
    motions: Motions,
    states: ElementStates,
    names: Names,
    start: float,
    end: float,
    interval: float,
    longest: float,
) -> tuple[tuple[Event, ...], tuple[Stretch, ...]]:
    """Return events and stretches of a scene. The result is cached: studies run one mechanism many times."""
    events: set[Event] = set()
    narrow: list[Stretch] = []
    sets = (
        (forces.programs, tuple(f"force '{name}'" for name in forces.program_owners), OF_FORCES),
        (states.programs, tuple(f"state '{name}'" for name in names.states), OF_FORCES),
        (motions.programs, tuple(f"motion '{name}'" for name in names.motions), OF_MOTIONS),
    )
    for programs, owners, orders in sets:
        seen: dict[tuple[bytes, bytes], list[tuple[float, str]]] = {}
        for index, owner in enumerate(owners):
            from mbproj.functions.time_parts import time_parts

            parts, marks = time_parts(programs, index), {start}
            for part in parts:
                code = slice(*part.start)
                same = part.op[code].tobytes(), part.operand[code].tobytes()
                if same not in seen:
                    seen[same] = list(_of_function(part, start, end, interval, orders, longest))
                events |= {Event(t, owner, kind) for t, kind in seen[same] if kind and t <= end}
                marks |= {t for t, _ in seen[same]}
            pairs = pairwise(sorted(marks))
            narrow += [
                Stretch(owner, parts, orders, *pair) for pair in pairs if pair[0] < end and pair[1] - pair[0] < longest
            ]
    return tuple(sorted(events)), tuple(narrow)


def _of_function(
    part: ProgramSet, start: float, end: float, interval: float, orders: int, longest: float
) -> Iterator[tuple[float, str]]:
    """The times and kinds of events, also beyond the end. The kind is "" at the end of a feature that a kink begins."""
    from mbproj.functions.kinks import kinks
    from mbproj.functions.look_times import look_windows
    from mbproj.functions.narrow import features

    counted = 0
    for low, high in look_windows(start, end + longest, interval):
        beside = THRESHOLDS.round_off_grains * float(np.spacing(max(abs(low), abs(high))))
        own = [kink for kink in kinks(part, 0, low, high) if _goes_on(part, kink.t, beside, start, end)]
        for feature in features(part, 0, low, high, own, orders):
            if feature.after_kink:
                yield feature.end, ""
            else:
                yield feature.start, "narrow feature begins"
                yield feature.end, "narrow feature ends"
        for kink in own[: THRESHOLDS.most_kinks - counted]:
            yield kink.t, "jump" if any(kink.jump[:orders]) else "kink"
        counted += len(own)
        if counted >= THRESHOLDS.most_kinks:
            return


def _goes_on(part: ProgramSet, t: float, beside: float, start: float, end: float) -> bool:
    """Whether a function has finite values at both sides of t. Without them the run stops there, with an error that
    names the function."""
    from mbproj.functions.series import run, time_series

    times = np.clip([t - beside, t + beside], start, end)
    return bool(np.all(np.isfinite(run(part, 0, [time_series(times)])[0])))
