"""Refuses motions that drive a coordinate beyond its rigid stop, which is known before the run."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem
from mbproj.functions.look_times import look_times
from mbproj.functions.series import run, time_series
from mbproj.model.channels import Motions
from mbproj.model.stops import Stops
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

HINT = "end the motion inside, widen the range, or let the stop give way with 'stiffness'"
#: The number of halvings of the interval in which a motion passes a stop.
HALVINGS = 60


def refuse_driven_beyond(system: System, start: float, end: float) -> None:
    """Raise InputError where a motion drives its coordinate beyond a rigid stop before `end`."""
    if system.stops is None:
        return
    problems = _problems(system, system.motions, system.stops, start, end)
    if problems:
        raise InputError(list(problems))


@lru_cache(maxsize=256)
def _problems(system: System, motions: Motions, stops: Stops, start: float, end: float) -> tuple[Problem, ...]:
    """Return the first passage of each stop. The result is cached: studies run one mechanism many times."""
    return tuple(
        problem
        for stop in np.flatnonzero(stops.is_rigid)
        for number in np.flatnonzero(motions.joint_coordinate == stops.joint_coordinate[stop])
        for problem in _passage(system, motions, stops, int(stop), int(number), start, end)
    )


def _passage(
    system: System, motions: Motions, stops: Stops, stop: int, number: int, start: float, end: float
) -> Iterator[Problem]:
    unit = system.names.stop_units[stop]
    size = system.length if unit == "m" else 1.0
    slack = THRESHOLDS.same_written * size

    def gap(t: Array) -> Array:
        value = motions.start[number] + run(motions.programs, number, [time_series(t)])[0]
        return np.asarray(stops.side[stop] * (value - stops.bound[stop]))

    times = look_times(motions.programs, number, start, end)
    gaps = gap(times)
    beyond = np.flatnonzero(gaps < -slack)
    if not len(beyond):
        return
    first, last = times[max(int(beyond[0]) - 1, 0)], times[beyond[0]]
    for _ in range(HALVINGS):
        middle = 0.5 * (first + last)
        first, last = (first, middle) if gap(np.array([middle]))[0] < -slack else (middle, last)
    coordinate = system.names.coordinates[int(stops.joint_coordinate[stop])]
    message = (
        f"motion '{system.names.motions[number]}' drives {coordinate} beyond this rigid stop from t = {last:.6g} s on, "
        f"by up to {-gaps.min():.6g} {unit}"
    )
    yield Problem(message, stops.places[stop], HINT)
