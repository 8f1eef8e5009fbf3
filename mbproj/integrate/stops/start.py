"""The start of a run with stops: inside all of them, or touching some with speeds that agree."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.inside import nearest_inside, stop_sizes
from mbproj.dynamics.equations.gaps import gap_rates, gaps
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.errors import InputError, Problem
from mbproj.model.system import System
from mbproj.registry import EQUILIBRIUM
from mbproj.thresholds import THRESHOLDS

#: Words for a coordinate beyond the bound of a stop, by the stop's side.
BEYOND = {1.0: "below the least", -1.0: "above the most"}


class AtStart(TypedDict):
    """The gap of a stop in m or rad and its rate per s, the `unit` of the gap, and whether the stop touches."""

    gap: float
    rate: float
    unit: str
    touches: bool


def gaps_at_start(system: System, state: State) -> dict[str, AtStart]:
    """Return the gaps of stops at the start, by the stops' names."""
    if system.stops is None:
        return {}
    pose = pose_of(state.q)
    gap, rate = gaps(system.stops, pose, state.turns), gap_rates(system.stops, pose, twist_of(pose, state.v))
    touches = gap <= THRESHOLDS.same_written * stop_sizes(system)
    return {
        name: {
            "gap": float(gap[k]),
            "rate": float(rate[k]),
            "unit": system.names.stop_units[k],
            "touches": bool(touches[k]),
        }
        for k, name in enumerate(system.names.stops)
    }


def refuse_penetration(system: System, state: State, start: str = "scene") -> None:
    """Raises InputError where the state is beyond a stop, or touches a rigid one and moves into it. A run that is to
    `start` from its equilibrium may compress compliant stops."""
    if system.stops is None:
        return
    pose = pose_of(state.q)
    gap, slack = gaps(system.stops, pose, state.turns), THRESHOLDS.same_written * stop_sizes(system)
    beyond = np.flatnonzero((gap < -slack) & (system.stops.is_rigid | (start != EQUILIBRIUM)))
    if len(beyond):
        raise InputError(_limit_problems(system, state, gap, beyond))
    rate = gap_rates(system.stops, pose, twist_of(pose, state.v))
    struck = system.stops.is_rigid & (gap <= slack) & (rate < -slack)
    if struck.any():
        raise InputError([_into(system, int(k), float(-rate[k])) for k in np.flatnonzero(struck)])


def _limit_problems(system: System, state: State, gap: Array, beyond: Integers) -> list[Problem]:
    """Return the problems of stops that the start is beyond. They say how to begin inside, or that the stops exclude
    each other."""
    assert system.stops is not None
    places = system.stops.places
    _, left = nearest_inside(system, state)
    apart = np.flatnonzero(left < -np.sqrt(THRESHOLDS.assembled) * stop_sizes(system))
    if len(apart):
        names = " and ".join(f"'{system.names.stops[k]}'" for k in apart)
        whom = "exclude each other" if len(apart) > 1 else "cannot be kept"
        missed = " and ".join(f"{-left[k]:.3g} {system.names.stop_units[k]}" for k in apart)
        said = f"the limits {names} {whom}: no pose near the start is inside, the nearest is beyond by {missed}"
        return [Problem(said, places[k], "widen the range, or look at the joints of the loop") for k in apart]
    return [_outside(system, int(k), float(gap[k])) for k in beyond]


def _outside(system: System, k: int, gap: float) -> Problem:
    stops, unit = system.stops, system.names.stop_units[k]
    assert stops is not None
    side, bound = float(stops.side[k]), float(stops.bound[k])
    at = f"at {bound + side * gap:.6g} {unit}, {BEYOND[side]}, {bound:.6g} {unit}"
    message = f"the start is beyond the stop '{system.names.stops[k]}' by {-gap:.6g} {unit}: {at}"
    return Problem(message, stops.places[k], "start inside, or widen the range")


def _into(system: System, k: int, speed: float) -> Problem:
    stops, unit = system.stops, system.names.stop_units[k]
    assert stops is not None
    message = f"the start touches the stop '{system.names.stops[k]}' and moves into it at {speed:.6g} {unit}/s"
    return Problem(message, stops.places[k], "start before the stop, or with a speed that leads away from it")
