"""A reference up to the time until which it is certain, and why it is not certain, or an error goal is missed, beyond:
chaos, round-off, or too many kinks.

Where forces or motions have more kinks in time than steps can end at, no method keeps its order. Kinks in the state do
not count, as error control meets them anywhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.analysis.growth import growth
from mbproj.errors import InputError, Problem
from mbproj.integrate.events.time_events import crowded, time_events
from mbproj.scene.sampling import DEFAULT_SAMPLES
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.nearby import round_off_bound, tight_solution
from mbproj.studies.measure.reference import Reference, reference
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.spans import common_times
from mbproj.studies.parallel.progress import Tell, silent

#: A study ends early where the reference is uncertain by more than this part of the mechanism's size.
CERTAIN = 1e-6
#: Round-off explains an uncertainty if it makes up at least this part of it.
EXPLAINS = 0.1
#: A motion is chaotic where errors grow exponentially, by more than this factor over the study.
CHAOS = 1e3
#: The most forces and motions that a message names.
SHOWN = 3


def certain_reference(
    mechanism: Mechanism, until: float, own: Setting, names: Sequence[str], tell: Tell = silent
) -> tuple[Reference, list[str]]:
    """The reference up to `until` (s), or to the last time at which it is certain to `CERTAIN`, and notes on it. It
    serves to compare the integrators `names` and the setting `own`. Raises InputError where no time is certain."""
    steps = [own.step] if own.step is not None and own.step <= until else []
    tell("reference", 0, 1)
    known = reference(mechanism, common_times(until, steps), names)
    limit, notes = CERTAIN * mechanism.system.length, list[str]()
    while (certain := known.certain_until(limit)) < known.times[-1]:
        why = why_not(mechanism, known, limit, certain, tell)
        if certain < 2 * known.times[1]:
            raise InputError(Problem(f"there is no reference for this mechanism: {why}", hint="try a shorter time"))
        notes = [f"the study ends at {certain:.4g} s: the reference is certain to {limit:.1g} m up to there ({why})"]
        known = reference(mechanism, common_times(certain, steps), names)
    return known, [known.words, *notes]


def why_not(mechanism: Mechanism, reference: Reference, goal: float, until: float, tell: Tell = silent) -> str:
    """Return in words why an error of `goal` (m) is missed, or cannot be checked, after the time `until` (s).

    Runs from starts that differ by round-off tell. Round-off is the reason where these runs part by a fair part of the
    goal or of the reference's uncertainty. Where they part exponentially, the motion is chaotic.
    """
    uncertainty, times = reference.uncertainty.max(axis=1), reference.times
    ended = np.flatnonzero(~np.isfinite(uncertainty))
    if len(ended) and reference.limit:
        return reference.limit
    better = tight_solution(mechanism, times)
    parted = round_off_bound(mechanism, better, tell).max(axis=1)
    at = min(int(np.searchsorted(times, until * (1.0 + 1e-9), side="right")), len(times) - 1)
    if parted[at] >= EXPLAINS * min(goal, float(uncertainty[at])):
        extent = float(np.ptp(reference.position, axis=0).max())
        fitted = growth(times, parted, np.zeros_like(parted), extent)
        grown = parted[-1] / max(float(parted[1]), np.finfo(float).tiny)
        if fitted.law == "exponential" and grown > CHAOS:
            return f"the motion is chaotic: starts that differ by round-off part as exp({fitted.rate:.2g} t)"
        return f"errors grow from round-off: starts that differ by it are {parted[at]:.1g} m apart at {times[at]:.4g} s"
    known = bool(uncertainty[at] <= goal)
    differ = f"the best solutions are uncertain by {uncertainty[at]:.1g} m at {times[at]:.4g} s"
    said = "no setting is that accurate" if known else differ
    rough = uneven(mechanism, float(times[-1]))
    if rough:
        return f"{not_smooth(rough)}, and {said}"
    why = reference.limit or "a load that is shorter than a step may be the reason"
    return said if known else f"the reference does not converge: {differ}; {why}"


def uneven(mechanism: Mechanism, until: float) -> tuple[str, ...]:
    """The names of the forces and motions with too many kinks within `until` (s)."""
    start = mechanism.state.t
    return crowded(time_events(mechanism.system, start, start + until, until / DEFAULT_SAMPLES))


def not_smooth(names: Sequence[str]) -> str:
    """A sentence about the names that `uneven` returned: "force 'push' has more kinks in time than steps end at"."""
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    *others, last = [*names[:SHOWN], *more]
    said = "more kinks in time than steps end at"
    return f"{', '.join(others)} and {last} have {said}" if others else f"{last} has {said}"
