"""The error that contacts leave in any solution: the slack with which they are decided, and loads that they share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.nearby import largest_distance
from mbproj.studies.measure.solve import Solution, solve
from mbproj.thresholds import Thresholds

#: The thresholds that decide when contacts open and frictions slip, the factor by which they are loosened, and the part
#: of the distance to the looser solution that bounds the error. A decision comes between one slack and twice the slack
#: early: the looser solution is at least 8 slacks away, and the true one at most 2.
SLACKS, LOOSER, PART = ("slips", "contact_pulls"), 10.0, 0.25
#: How much lower the floor under one of the feet is where these share a load, in lengths of the mechanism, and the most
#: feet under which it is lowered.
UNEVEN, MOST_FEET = 1e-6, 8


def slack_bound(mechanism: Mechanism, of: Solution) -> Array:
    """A bound on the error of a solution by the slack with which contacts and dry frictions are decided, up to each
    time, (T, k), m. 0 without any."""
    system = mechanism.system
    if system.stops is None and system.frictions is None:
        return np.zeros(of.position.shape[:2])
    own = system.thresholds
    looser = Thresholds(**{name: LOOSER * getattr(own, name) for name in SLACKS})
    other = solve(Mechanism(mechanism.scene, replace(system, thresholds=looser), mechanism.state), of.setting, of.times)
    return PART * largest_distance([other], of)


def share_bound(mechanism: Mechanism, of: Solution, stops: Sequence[str]) -> Array | None:
    """How far a solution depends on how these stops share a load, up to each time, (T, k), m: the largest distance to
    those with the floor a little lower under one of them. None where none of these runs to the end."""
    others = []
    for uneven in _uneven(mechanism, stops):
        other = solve(uneven, of.setting, of.times)
        if other.failure is None:
            others.append(other)
    return largest_distance(others, of) if others else None


def _uneven(mechanism: Mechanism, stops: Sequence[str]) -> Iterator[Mechanism]:
    """Yield the mechanism with a bound of one of the stops shifted away from it."""
    system = mechanism.system
    assert system.stops is not None
    for name in stops[:MOST_FEET]:
        at = system.names.stops.index(name)
        bound = system.stops.bound.copy()
        bound[at] -= system.stops.side[at] * UNEVEN * system.length
        yield Mechanism(mechanism.scene, replace(system, stops=replace(system.stops, bound=bound)), mechanism.state)
