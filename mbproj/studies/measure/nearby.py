"""The influence of round-off on a motion: runs from starts that differ by round-off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.linear.equilibrium.started import beside
from mbproj.model import initial_guess
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Solution, solve
from mbproj.studies.parallel.progress import PERTURBED_STARTS, Tell, silent

#: A tolerance so tight that round-off dominates the error.
TIGHTEST = 1e-14
#: The number of perturbed starts, and the factor by which the true motion may be farther away than the farthest of
#: them.
PERTURBED, SAFETY = 4, 3.0
#: Size of the perturbation in units of the round-off of the mechanism's coordinates.
UNITS = 4.0


def perturbed(mechanism: Mechanism, seed: int) -> Mechanism:
    """Return the mechanism with a perturbed start that is consistent too. A random number of a few units in the last
    place of the largest changes each coordinate and velocity."""
    random, system, state = np.random.default_rng(seed), mechanism.system, mechanism.state
    size = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
    ulp = UNITS * np.finfo(float).eps
    q = state.q + ulp * np.maximum(size, np.abs(state.q)) * random.uniform(-1.0, 1.0, len(size))
    fastest = float(np.abs(state.v).max(initial=0.0))
    v = state.v + ulp * fastest * random.uniform(-1.0, 1.0, len(size))
    guess = replace(initial_guess(mechanism.scene, system), q=q, v=v)
    return Mechanism(mechanism.scene, system, beside(mechanism.scene, system, guess))


def tight_solution(mechanism: Mechanism, times: Array) -> Solution:
    """A solution as accurate as round-off allows, where the equations are smooth."""
    return solve(mechanism, Setting(integrator="dop853", tolerance=TIGHTEST), times)


def round_off_bound(mechanism: Mechanism, of: Solution, tell: Tell = silent) -> Array:
    """A bound on the error that round-off causes in a `tight_solution` up to each time, (T, k), m. It comes from runs
    with perturbed starts."""
    others = []
    for seed in range(1, PERTURBED + 1):
        tell(PERTURBED_STARTS, seed - 1, PERTURBED)
        setting = Setting(integrator="dop853", tolerance=(1.0 + 0.25 * seed) * TIGHTEST)
        others.append(solve(perturbed(mechanism, seed), setting, of.times))
    return SAFETY * largest_distance(others, of)


def largest_distance(others: Sequence[Solution], of: Solution) -> Array:
    """The largest distance up to each time between the solution `of` and the others, (T, k), m. It is infinite from the
    end of one of them on."""
    apart = np.max([np.linalg.norm(other.position - of.position, axis=-1) for other in others], axis=0)
    distances: Array = np.maximum.accumulate(np.nan_to_num(apart, nan=np.inf))
    return distances
