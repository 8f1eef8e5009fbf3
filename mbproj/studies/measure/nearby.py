"""What round-off makes of a motion: runs from starts that differ by it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.perturbed import perturbed
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Solution, solve
from mbproj.studies.parallel.progress import PERTURBED_STARTS, Tell, silent

#: The tolerance that round-off dominates.
TIGHTEST = 1e-14
#: Runs from perturbed starts, and the factor by which the truth may be farther off than the farthest of them.
PERTURBED, SAFETY = 4, 3.0


def tight(mechanism: Mechanism, times: Array) -> Solution:
    """A solution that is as good as round-off allows, where the equations are smooth."""
    return solve(mechanism, Setting(integrator="dop853", tolerance=TIGHTEST), times)


def round_off(mechanism: Mechanism, of: Solution, tell: Tell = silent) -> Array:
    """How far from a `tight` solution starts that differ by round-off may lead up to each time, (T, k), m."""
    others = []
    for seed in range(1, PERTURBED + 1):
        tell(PERTURBED_STARTS, seed - 1, PERTURBED)
        setting = Setting(integrator="dop853", tolerance=(1.0 + 0.25 * seed) * TIGHTEST)
        others.append(solve(perturbed(mechanism, seed), setting, of.times))
    return SAFETY * spread(others, of)


def spread(others: Sequence[Solution], of: Solution) -> Array:
    """The largest distance so far of solutions to one of them, (T, k), m; infinite where one of them has ended."""
    apart = np.max([np.linalg.norm(other.position - of.position, axis=-1) for other in others], axis=0)
    found: Array = np.maximum.accumulate(np.nan_to_num(apart, nan=np.inf))
    return found
