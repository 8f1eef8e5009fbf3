"""The reason why an error goal is missed or cannot be checked: chaos, round-off, too many kinks, or a poor
reference."""

from __future__ import annotations

import numpy as np

from mbproj.analysis.growth import growth
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.nearby import round_off_bound, tight_solution
from mbproj.studies.measure.reference import Reference
from mbproj.studies.measure.uneven import not_smooth, uneven
from mbproj.studies.parallel.progress import Tell, silent

#: Round-off explains an uncertainty if it makes up at least this part of it.
EXPLAINS = 0.1
#: A motion is chaotic where errors grow exponentially, by more than this factor over the study.
CHAOS = 1e3


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
        found = growth(times, parted, np.zeros_like(parted), extent)
        grown = parted[-1] / max(float(parted[1]), np.finfo(float).tiny)
        if found.law == "exponential" and grown > CHAOS:
            return f"the motion is chaotic: starts that differ by round-off part as exp({found.rate:.2g} t)"
        return f"errors grow from round-off: starts that differ by it are {parted[at]:.1g} m apart at {times[at]:.4g} s"
    known = bool(uncertainty[at] <= goal)
    differ = f"the best solutions are uncertain by {uncertainty[at]:.1g} m at {times[at]:.4g} s"
    said = "no setting is that accurate" if known else differ
    rough = uneven(mechanism, float(times[-1]))
    if rough:
        return f"{not_smooth(rough)}, and {said}"
    why = reference.limit or "a load that is shorter than a step may be the reason"
    return said if known else f"the reference does not converge: {differ}; {why}"
